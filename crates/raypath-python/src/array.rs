//! Arrays of Python as slices of Rust. Arrays of another type or order are converted if every value stays what it is.

use crate::error::value_error;
use crate::hits::TraceHit;
use numpy::npyffi::{self, _PyArray_GET_ITEM_DATA, NpyTypes, PY_ARRAY_API};
use numpy::{PyArrayDescr, PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList};
use raypath_embed::{
    Bounds, QuadboxResult, Ray, TriangleResult, UnitCandidate, UnitHit, UnitRay, UnitVerdict, Vertices,
};
use std::marker::PhantomData;
use std::ops::Deref;

/// An item of an array: the numbers of one job.
///
/// # Safety
/// The type is `repr(C)` without padding, every bit pattern is a value of it, and its size is that of an element of
/// [`dtype`](Self::dtype) times the product of [`SHAPE`](Self::SHAPE).
#[allow(unsafe_code)] // The layout of NumPy's memory is known to NumPy alone.
pub unsafe trait Item: Copy + Send + Sync {
    /// The dimensions of an array after the first, which counts items.
    const SHAPE: &[usize] = &[];
    /// The type of the elements in words.
    const ELEMENT: &str = "float32";
    /// The type of the elements.
    fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        PyArrayDescr::new(py, "f4")
    }
}

/// The numbers of `SHAPE` in row-major order.
macro_rules! items {
    ($($type:ty: $shape:expr),*) => {$(
        #[allow(unsafe_code)]
        // SAFETY: a structure of as many f32 as `SHAPE` has elements.
        unsafe impl Item for $type {
            const SHAPE: &[usize] = &$shape;
        }
    )*};
}
items!(f32: [], [f32; 3]: [3], [f32; 16]: [16], Bounds: [2, 3], [Bounds; 4]: [4, 2, 3], Vertices: [3, 3]);

#[allow(unsafe_code)]
// SAFETY: a word of 64 bits.
unsafe impl Item for u64 {
    const ELEMENT: &str = "uint64";
    fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        PyArrayDescr::new(py, "u8")
    }
}

/// A truth value of NumPy: a byte, false if it is 0.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub struct Truth(pub u8);

#[allow(unsafe_code)]
// SAFETY: a byte.
unsafe impl Item for Truth {
    const ELEMENT: &str = "bool";
    fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        PyArrayDescr::new(py, "?")
    }
}

#[allow(unsafe_code)]
// SAFETY: three words of 32 bits.
unsafe impl Item for [u32; 3] {
    const SHAPE: &[usize] = &[3];
    const ELEMENT: &str = "uint32";
    fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        PyArrayDescr::new(py, "u4")
    }
}

#[allow(unsafe_code)]
// SAFETY: twelve f64.
unsafe impl Item for [[f64; 4]; 3] {
    const SHAPE: &[usize] = &[3, 4];
    const ELEMENT: &str = "float64";
    fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
        PyArrayDescr::new(py, "f8")
    }
}

/// A structure with a name, a type and an offset for each field.
macro_rules! structures {
    ($($type:ty: $name:literal, [$($field:literal: $format:literal @ $offset:expr),*];)*) => {$(
        #[allow(unsafe_code)]
        // SAFETY: a structure of numbers, with the size of the type of the elements.
        unsafe impl Item for $type {
            const ELEMENT: &str = $name;
            fn dtype(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
                // One object for all arrays, so that it is recognised at once.
                static DTYPE: PyOnceLock<Py<PyArrayDescr>> = PyOnceLock::new();
                let dtype = DTYPE.get_or_try_init(py, || {
                    let description = PyDict::new(py);
                    description.set_item("names", [$($field),*])?;
                    description.set_item("formats", [$($format),*])?;
                    description.set_item("offsets", [$($offset),*])?;
                    description.set_item("itemsize", size_of::<Self>())?;
                    PyResult::Ok(PyArrayDescr::new(py, description)?.unbind())
                });
                Ok(dtype?.bind(py).clone())
            }
        }
    )*};
}
structures! {
    Ray: "raypath.RAY", ["origin": "(3,)f4" @ 0, "direction": "(3,)f4" @ 12, "inverse": "(3,)f4" @ 24,
        "extent": "f4" @ 36, "shear": "(3,)f4" @ 40, "kx": "u4" @ 52, "ky": "u4" @ 56, "kz": "u4" @ 60];
    UnitRay: "raypath.UNIT_RAY", ["origin": "(3,)f4" @ 0, "direction": "(3,)f4" @ 12, "t_min": "f4" @ 24,
        "t_max": "f4" @ 28, "flags": "u4" @ 32, "cull_mask": "u4" @ 36, "root": "u4" @ 40, "base": "u4" @ 44];
    // A truth value is a word of 32 bits of value 0 or 1, shown as its least significant byte. Indices are signed, so
    // that -1 is none.
    TriangleResult: "triangle", ["t_num": "f4" @ 0, "t_denom": "f4" @ 4, "triangle_hit": "?" @ 8 + LEAST_BYTE];
    TraceHit: "trace", ["triangle": "i4" @ 0, "t": "f4" @ 4, "t_num": "f4" @ 8, "t_denom": "f4" @ 12,
        "back_face": "?" @ 16 + LEAST_BYTE];
    UnitHit: "hit", ["status": "u4" @ 0, "primitive": "i4" @ 4, "instance": "i4" @ 8, "t": "f4" @ 12, "t_num": "f4" @ 16,
        "t_denom": "f4" @ 20, "u": "f4" @ 24, "v": "f4" @ 28, "back_face": "?" @ 32 + LEAST_BYTE, "nodes": "u4" @ 36,
        "triangles": "u4" @ 40, "geometry": "i4" @ 44, "custom_index": "u4" @ 48, "shader_offset": "u4" @ 52];
    UnitCandidate: "candidate", ["is_box": "?" @ LEAST_BYTE, "is_opaque": "?" @ 4 + LEAST_BYTE, "primitive": "i4" @ 8,
        "geometry": "i4" @ 12, "instance": "i4" @ 16, "custom_index": "u4" @ 20, "shader_offset": "u4" @ 24,
        "t": "f4" @ 28, "t_num": "f4" @ 32, "t_denom": "f4" @ 36, "u": "f4" @ 40, "v": "f4" @ 44,
        "back_face": "?" @ 48 + LEAST_BYTE, "ray": "u4" @ 52, "origin": "(3,)f4" @ 56, "direction": "(3,)f4" @ 68];
    UnitVerdict: "verdict", ["accept": "?" @ LEAST_BYTE, "end": "?" @ 4 + LEAST_BYTE, "t": "f4" @ 8];
    QuadboxResult: "quadbox", ["tmin": "(4,)f4" @ 0, "is_intersect": "(4,)?" @ 16, "box_index": "(4,)u1" @ 20];
}

/// The least significant byte of a word of 32 bits.
const LEAST_BYTE: usize = if cfg!(target_endian = "little") { 0 } else { 3 };

/// The type of the elements of an array of `T`.
pub fn dtype<T: Item>(py: Python<'_>) -> PyResult<Bound<'_, PyArrayDescr>> {
    T::dtype(py)
}

/// The items of an array, which lives as long as they do.
pub struct Items<'py, T> {
    array: Bound<'py, PyUntypedArray>,
    count: usize,
    items: PhantomData<T>,
}

impl<'py, T: Item> Items<'py, T> {
    /// The first `count` items of an array that was checked.
    fn new(array: Bound<'py, PyUntypedArray>, count: usize) -> Self {
        Self { array, count, items: PhantomData }
    }
}

impl<T: Item> Deref for Items<'_, T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        if self.count == 0 {
            return &[];
        }
        #[allow(unsafe_code)]
        // SAFETY: `checked` found the type, the shape, the order and the alignment. The array lives as long as `self`.
        // Another thread of Python that writes to an input during a call changes the results, as with NumPy's
        // functions.
        unsafe {
            std::slice::from_raw_parts(data(&self.array).cast(), self.count)
        }
    }
}

/// The items of an array of the shape (n, *`T::SHAPE`).
///
/// # Errors
/// An object that is not an array; another shape; a type that cannot be converted without a loss.
pub fn items<'py, T: Item>(array: &Bound<'py, PyAny>, name: &str) -> PyResult<Items<'py, T>> {
    let checked = checked::<T>(array, name, 1, T::SHAPE)?;
    let count = checked.shape()[0];
    Ok(Items::new(checked, count))
}

/// As [`items`], for an array of `count` items, as many as the argument `like` has.
pub fn items_like<'py, T: Item>(
    array: &Bound<'py, PyAny>,
    name: &str,
    count: usize,
    like: &str,
) -> PyResult<Items<'py, T>> {
    let items = items::<T>(array, name)?;
    if items.len() == count {
        return Ok(items);
    }
    let (found, expected) = (shape(&[&[items.len()], T::SHAPE].concat()), shape(&[&[count], T::SHAPE].concat()));
    Err(value_error(format!("{name}: found shape {found}, expected {expected}, because {like} has {count} items")))
}

/// One item: an array of the shape `T::SHAPE`.
pub fn item<T: Item>(array: &Bound<'_, PyAny>, name: &str) -> PyResult<T> {
    let items = Items::<T>::new(checked::<T>(array, name, 0, T::SHAPE)?, 1);
    items.first().copied().ok_or_else(|| value_error("no item"))
}

/// An item of an array of structures, or an array of one item.
pub fn structure<T: Item>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<T> {
    let py = value.py();
    #[allow(unsafe_code)]
    // SAFETY: NumPy gives the address of a scalar whose type is that of `T`, all patterns of whose bytes are values.
    // With `tobytes` in place of it, `UnitModel.step(ray)` takes 2.4 µs, and 1.0 µs so.
    unsafe {
        let void = npyffi::get_type_object(py, NpyTypes::PyVoidArrType_Type);
        // Not a class derived from it, whose attribute may be anything.
        let dtype = (value.get_type().as_type_ptr() == void).then(|| value.getattr(intern!(py, "dtype")));
        if dtype.transpose()?.is_some_and(|dtype| T::dtype(py).is_ok_and(|own| dtype.is(&own))) {
            let mut bytes: *const T = std::ptr::null();
            PY_ARRAY_API.PyArray_ScalarAsCtype(py, value.as_ptr(), (&raw mut bytes).cast());
            return Ok(bytes.read_unaligned());
        }
    }
    match &*items::<T>(&py.import("numpy")?.call_method1("ravel", (value,))?, name)? {
        [item] => Ok(*item),
        items => Err(value_error(format!("{name}: found {} rays, expected 1", items.len()))),
    }
}

/// The numbers of an array of the shape (n, k) with n and k.
pub fn matrix<'py>(array: &Bound<'py, PyAny>, name: &str) -> PyResult<(Items<'py, f32>, usize, usize)> {
    let array = checked::<f32>(array, name, 2, &[])?;
    let (rows, columns) = (array.shape()[0], array.shape()[1]);
    Ok((Items::new(array, rows * columns), rows, columns))
}

/// The array, if it has `free` dimensions of any length, then those of `tail`, and elements of `T` or such that convert
/// to them without a loss; in C order.
fn checked<'py, T: Item>(
    array: &Bound<'py, PyAny>,
    name: &str,
    free: usize,
    tail: &[usize],
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let (py, element) = (array.py(), T::ELEMENT);
    let letters = ["n", "k"].into_iter().take(free).map(str::to_string);
    let lengths: Vec<String> = letters.chain(tail.iter().map(usize::to_string)).collect();
    let expected = format!("expected a {element} array of shape {}", tuple(&lengths));
    let Ok(array) = array.cast::<PyUntypedArray>() else {
        return Err(value_error(format!("{name}: found {}, {expected}", array.get_type().name()?)));
    };
    let (found, own, dtype) = (array.shape(), array.dtype(), T::dtype(py)?);
    let problem = |why: &str| {
        let found = format!("a {own} array of shape {}", shape(found));
        Err(value_error(format!("{name}: found {found}, {expected}{why}")))
    };
    if found.len() != free + tail.len() || found[free..] != *tail {
        return problem("");
    }
    if own.is_equiv_to(&dtype) && array.is_c_contiguous() && data(array).cast::<T>().is_aligned() {
        return Ok(array.clone());
    }
    let converted = py.import("raypath._arrays")?.call_method1("lossless", (array, dtype))?;
    if let Ok(converted) = converted.cast_into::<PyUntypedArray>() {
        return Ok(converted);
    }
    match element {
        "float32" | "float64" | "uint32" | "uint64" => {
            problem(&format!("; some values would change: {name}.astype(numpy.{element}) converts all the same"))
        }
        _ => problem(""),
    }
}

fn tuple(lengths: &[String]) -> String {
    if let [only] = lengths { format!("({only},)") } else { format!("({})", lengths.join(", ")) }
}

fn shape(lengths: &[usize]) -> String {
    tuple(&lengths.iter().map(usize::to_string).collect::<Vec<_>>())
}

fn data(array: &Bound<'_, PyUntypedArray>) -> *mut u8 {
    #[allow(unsafe_code)]
    // SAFETY: the pointer is that of an array, which has this field.
    unsafe {
        (*_PyArray_GET_ITEM_DATA(array.as_array_ptr())).data.cast()
    }
}

/// A new array of `count` items of zeros.
pub struct Output<'py> {
    array: Bound<'py, PyUntypedArray>,
}

impl<'py> Output<'py> {
    /// An array for items of `T`, which are scalars or structures.
    pub fn new<T: Item>(py: Python<'py>, count: usize) -> PyResult<Self> {
        let zeros = py.import("numpy")?.call_method1("zeros", (count, T::dtype(py)?))?;
        Ok(Self { array: zeros.cast_into()? })
    }

    /// The items, if the array was made for items of `T`.
    pub fn items<T: Item>(&mut self) -> PyResult<&mut [T]> {
        let count = checked::<T>(self.array.as_any(), "output", 1, &[])?.shape()[0];
        if count == 0 {
            return Ok(&mut []);
        }
        #[allow(unsafe_code)]
        // SAFETY: `checked` found the type, the shape, the order and the alignment. No other object refers to the array
        // before `into_array`, and the borrow is exclusive.
        Ok(unsafe { std::slice::from_raw_parts_mut(data(&self.array).cast(), count) })
    }

    /// The array for Python.
    pub fn into_array(self) -> Bound<'py, PyAny> {
        self.array.into_any()
    }
}

/// Rays as the datapath expects them, from origins, directions and extents.
///
/// A ray reaches the points ``origin + t * direction`` for ``0 < t <= extent``. Distances of all operations are in
/// units of the direction's length, which may be any except 0.
///
/// Args:
///     origins: float32 array of shape (n, 3).
///     directions: float32 array of shape (n, 3).
///     extent: a number of at least 0 for all rays, or a float32 array of shape (n,).
///
/// Returns:
///     A structured array of shape (n,) with 64 bytes per ray and the fields of the C structure ``raypath_ray``:
///     ``origin``, ``direction``, ``inverse``, ``extent``, ``shear``, ``kx``, ``ky``, ``kz``.
///
/// Raises:
///     ValueError: another type or shape; in a row, a direction that is zero, not finite or too short to invert, an
///         origin that is not finite, or an extent that is negative or NaN. The message names the row.
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> origins = np.array([[0, 0, -5]], np.float32)
///     >>> directions = np.array([[0, 0, 2]], np.float32)
///     >>> rays = raypath.rays(origins, directions, extent=10)
///     >>> rays["inverse"], rays["kz"]
///     (array([[inf, inf, 0.5]], dtype=float32), array([2], dtype=uint32))
#[pyfunction]
#[pyo3(signature = (origins, directions, extent = None))]
pub fn rays<'py>(
    py: Python<'py>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    extent: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let origins = items::<[f32; 3]>(origins, "origins")?;
    let directions = items_like::<[f32; 3]>(directions, "directions", origins.len(), "origins")?;
    let extents = match extent {
        None => Extents::All(f32::INFINITY),
        Some(array) if array.is_instance_of::<PyUntypedArray>() || array.is_instance_of::<PyList>() => {
            Extents::Each(items_like(array, "extent", origins.len(), "origins")?)
        }
        Some(number) => Extents::All(number.extract::<f64>().map_err(|_| {
            value_error(format!("extent: found {number}, expected a number or a float32 array of shape (n,)"))
        })? as f32),
    };
    let mut output = Output::new::<Ray>(py, origins.len())?;
    let rays = output.items::<Ray>()?;
    let (all, each) = match &extents {
        Extents::All(extent) => (*extent, None),
        Extents::Each(extents) => (0.0, Some(&**extents)),
    };
    let (origins, directions) = (&*origins, &*directions);
    py.detach(|| {
        for (row, ray) in rays.iter_mut().enumerate() {
            let extent = each.map_or(all, |extents| extents[row]);
            *ray = Ray::new(origins[row], directions[row], extent)
                .map_err(|problem| value_error(format!("row {row}: {problem}")))?;
        }
        PyResult::Ok(())
    })?;
    Ok(output.into_array())
}

enum Extents<'py> {
    All(f32),
    Each(Items<'py, f32>),
}
