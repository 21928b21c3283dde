//! Arrays of jobs in the functional model.

use crate::Datapath;
use crate::memory::{array, reference, required_text, results, separate};
use crate::status::{Failure, RAYPATH_OK, Status, status};
use raypath_embed::{Bounds, QuadboxResult, Ray, TriangleResult, Vertices};
use std::ffi::c_char;

/// Tests `count` rays against four boxes each: `boxes` has 4 * `count` elements. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_OPERATION`, `_NULL`, `_ALIGNMENT`, `_OVERLAP` of the results with another array.
///
/// # Safety
/// `datapath` is NULL or an open datapath; the arrays are NULL or have that many elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_quadbox(
    datapath: *const Datapath,
    rays: *const Ray,
    boxes: *const Bounds,
    count: usize,
    quadbox_results: *mut QuadboxResult,
) -> Status {
    status(|| {
        let boxes: *const [Bounds; 4] = boxes.cast();
        let to = ("results", quadbox_results.cast_const(), count);
        separate(("rays", rays, count), to)?;
        separate(("boxes", boxes, count), to)?;
        // SAFETY: by the contract of this function; the results overlap nothing.
        let (datapath, rays, boxes, to) = unsafe {
            (
                reference("datapath", datapath)?,
                array("rays", rays, count)?,
                array("boxes", boxes, count)?,
                results("results", quadbox_results, count)?,
            )
        };
        datapath.embedded.quadbox(rays, boxes, to)?;
        Ok(RAYPATH_OK)
    })
}

/// Tests `count` rays against a triangle each. With the feature `range`, rays begin at a distance of 0. Any thread may
/// call it.
///
/// Errors: those of `raypath_quadbox`.
///
/// # Safety
/// That of `raypath_quadbox`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_triangle(
    datapath: *const Datapath,
    rays: *const Ray,
    triangles: *const Vertices,
    count: usize,
    triangle_results: *mut TriangleResult,
) -> Status {
    status(|| {
        let to = ("results", triangle_results.cast_const(), count);
        separate(("rays", rays, count), to)?;
        separate(("triangles", triangles, count), to)?;
        // SAFETY: by the contract of this function; the results overlap nothing.
        let (datapath, rays, triangles, to) = unsafe {
            (
                reference("datapath", datapath)?,
                array("rays", rays, count)?,
                array("triangles", triangles, count)?,
                results("results", triangle_results, count)?,
            )
        };
        datapath.embedded.triangle(rays, triangles, to)?;
        Ok(RAYPATH_OK)
    })
}

/// Computes the squared Euclidean distances of `count` pairs of vectors with `dimensions` numbers each, in `a` and `b`
/// one vector after another. The sums are those of the hardware's beats. Any thread may call it.
///
/// Errors: `RAYPATH_ERROR_ARGUMENT` for 0 dimensions; those of `raypath_quadbox`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `a` and `b` are NULL or have `count` * `dimensions` elements, `distances`
/// `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_euclidean(
    datapath: *const Datapath,
    a: *const f32,
    b: *const f32,
    dimensions: usize,
    count: usize,
    distances: *mut f32,
) -> Status {
    status(|| {
        let size = size(dimensions, count)?;
        let to = ("distances", distances.cast_const(), count);
        separate(("a", a, size), to)?;
        separate(("b", b, size), to)?;
        // SAFETY: by the contract of this function; the results overlap nothing.
        let (datapath, a, b, to) = unsafe {
            (
                reference("datapath", datapath)?,
                array("a", a, size)?,
                array("b", b, size)?,
                results("distances", distances, count)?,
            )
        };
        datapath.embedded.euclidean(a, b, dimensions, to)?;
        Ok(RAYPATH_OK)
    })
}

/// Computes the dot products of `count` pairs of vectors, and the squared norms of the vectors of `b`. Shapes and
/// errors are those of `raypath_euclidean`. Any thread may call it.
///
/// # Safety
/// That of `raypath_euclidean`; `dot_products` and `norms` are NULL or have `count` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_angular(
    datapath: *const Datapath,
    a: *const f32,
    b: *const f32,
    dimensions: usize,
    count: usize,
    dot_products: *mut f32,
    norms: *mut f32,
) -> Status {
    status(|| {
        let size = size(dimensions, count)?;
        let dots = ("dot_products", dot_products.cast_const(), count);
        let squares = ("norms", norms.cast_const(), count);
        for to in [dots, squares] {
            separate(("a", a, size), to)?;
            separate(("b", b, size), to)?;
        }
        separate(dots, squares)?;
        // SAFETY: by the contract of this function; the results overlap nothing.
        let (datapath, a, b, dots, squares) = unsafe {
            (
                reference("datapath", datapath)?,
                array("a", a, size)?,
                array("b", b, size)?,
                results("dot_products", dot_products, count)?,
                results("norms", norms, count)?,
            )
        };
        datapath.embedded.angular(a, b, dimensions, dots, squares)?;
        Ok(RAYPATH_OK)
    })
}

/// Computes `count` jobs of any operation, in order, through the words at its ports: `inputs` has the words of one job
/// after another, in the order of `raypath_input`, and `outputs` receives those of the outcomes, in the order of
/// `raypath_output`. Numbers are in the IEEE 754 layout of the datapath's format. Accumulators are zero before the
/// first job. Any thread may call it.
///
/// Errors: those of `raypath_quadbox`.
///
/// # Safety
/// `datapath` is NULL or an open datapath; `operation` is NULL or a string; the arrays are NULL or have that many
/// elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn raypath_run(
    datapath: *const Datapath,
    operation: *const c_char,
    inputs: *const u64,
    count: usize,
    outputs: *mut u64,
) -> Status {
    status(|| {
        // SAFETY: by the contract of this function.
        let (datapath, operation) =
            unsafe { (reference("datapath", datapath)?, required_text("operation", operation)?) };
        let embedded = &datapath.embedded;
        let operation = embedded.operation(operation)?;
        let [given, room] =
            [embedded.inputs(operation).len(), embedded.outputs(operation).len()].map(|words| size(words, count));
        let (given, room) = (given?, room?);
        separate(("inputs", inputs, given), ("outputs", outputs.cast_const(), room))?;
        // SAFETY: by the contract of this function; the outputs overlap nothing.
        let (inputs, outputs) = unsafe { (array("inputs", inputs, given)?, results("outputs", outputs, room)?) };
        embedded.run(operation, inputs, outputs)?;
        Ok(RAYPATH_OK)
    })
}

fn size(each: usize, count: usize) -> Result<usize, Failure> {
    let problem = || Failure::argument(format!("{count} times {each} elements do not fit into memory"));
    each.checked_mul(count).ok_or_else(problem)
}
