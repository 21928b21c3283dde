//! Rendering and tracing.

use crate::array::{Output, items};
use crate::datapath::Datapath;
use crate::error::value_error;
use crate::hits::{Trace, TraceHit};
use crate::tables::{list, row};
use crate::timing::{figures, plain, system};
use crate::watch::{abandoned_at_signals, watched};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple};
use raypath_embed::Ray;
use raypath_ops as ops;
use raypath_render::{
    Camera, Hit, Mesh, PictureSpec, RayBatch, Rendering as Rendered, Scene, Shading, Tracing, render as render_scene,
    time_picture, time_rays, to_png, trace_closest,
};
use raypath_timing::{Sample, System, Timing};
use std::sync::Arc;

/// A rendered picture with its cost and its simulated timing.
#[pyclass(module = "raypath", frozen)]
pub struct Rendering {
    rendered: Rendered,
    timing: Option<(Timing, System)>,
}

#[pymethods]
impl Rendering {
    /// uint8 array of shape (height, width, 3): sRGB pixels, rows from the top. Each access makes a new array.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let picture = &self.rendered.picture;
        let pixels = PyArray1::from_slice(py, picture.as_raw());
        Ok(pixels.reshape([picture.height() as usize, picture.width() as usize, 3])?.into_any())
    }

    /// uint32 array of shape (height, width): the number of jobs of each pixel, with its secondary rays. Each access
    /// makes a new array.
    #[getter]
    fn jobs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let picture = &self.rendered.picture;
        let jobs = PyArray1::from_slice(py, &self.rendered.jobs);
        Ok(jobs.reshape([picture.height() as usize, picture.width() as usize])?.into_any())
    }

    /// A row for each kind of rays ("primary", "shadow", "occlusion") that were traced: ``kind``, ``rays``, ``hits``,
    /// the jobs ``quadbox``, ``triangle`` and ``behind`` (second jobs of triangles, for hits from behind), and the
    /// fetches ``nodes`` and ``leaves``.
    #[getter]
    fn rays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let Rendered { primary, shadow, occlusion, .. } = &self.rendered;
        let kinds = [("primary", primary), ("shadow", shadow), ("occlusion", occlusion)];
        let rows = kinds.into_iter().filter(|(_, costs)| costs.rays > 0).map(|(kind, costs)| {
            let counts = costs.counts;
            row!(py, "kind": kind, "rays": costs.rays, "hits": costs.hits, "quadbox": counts.quadbox,
                "triangle": counts.triangle, "behind": counts.behind, "nodes": counts.nodes, "leaves": counts.leaves)
        });
        list(py, rows)
    }

    /// The figures of the simulation (see ``raypath.render``), or None without ``timed``. An agent is a pixel.
    #[getter]
    fn timing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.timing.as_ref().map(|(timing, system)| figures(py, timing, system)).transpose()
    }

    /// The picture as a PNG file, which notebooks show.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &to_png(&self.rendered.picture).map_err(value_error)?))
    }

    fn __repr__(&self) -> String {
        let (picture, costs) = (&self.rendered.picture, &self.rendered.primary);
        let (width, height) = picture.dimensions();
        format!("<raypath.Rendering: {width} x {height} pixels, {} of {} primary rays hit>", costs.hits, costs.rays)
    }
}

/// A mesh with the tree of its boxes, which ``render`` and ``trace`` take.
///
/// It does not change, so that threads can share it. A scene that was pickled builds its tree again.
///
/// Args:
///     vertices: float32 array of shape (n, 3): finite coordinates of magnitude at most 2**40.
///     faces: uint32 array of shape (n, 3): the vertices of each triangle, counter-clockwise as seen from its front.
///
/// Raises:
///     ValueError: another type or shape; a face of a vertex that does not exist; a coordinate out of range.
///     KeyboardInterrupt: after Ctrl-C. The building of a tree then ends in a thread of its own.
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> scene = raypath.Scene(np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
///     >>> rays = raypath.rays(np.float32([[0, 0, 4], [9, 0, 4]]), np.float32([[0, 0, -1], [0, 0, -1]]))
///     >>> hits = raypath.trace(scene, rays)
///     >>> hits.triangle, hits.t
///     (array([ 0, -1], dtype=int32), array([ 4., inf], dtype=float32))
#[pyclass(name = "Scene", module = "raypath", frozen)]
pub struct PyScene {
    inner: Arc<Scene>,
}

#[pymethods]
impl PyScene {
    #[new]
    fn new(py: Python<'_>, vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Self> {
        let vertices = items::<[f32; 3]>(vertices, "vertices")?.to_vec();
        let faces = items::<[u32; 3]>(faces, "faces")?.to_vec();
        abandoned_at_signals(py, move || {
            let mesh = Mesh::new(vertices, faces).map_err(value_error)?;
            Ok(Self { inner: Arc::new(Scene::new(mesh).map_err(value_error)?) })
        })
    }

    /// The number of triangles.
    fn __len__(&self) -> usize {
        self.inner.mesh().triangles().len()
    }

    fn __repr__(&self) -> String {
        format!("<raypath.Scene: {} triangles>", self.__len__())
    }

    /// The arguments that make an equal scene, for ``pickle``.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let mesh = self.inner.mesh();
        let vertices = PyArray1::from_slice(py, mesh.positions().as_flattened());
        let faces = PyArray1::from_slice(py, mesh.triangles().as_flattened());
        let rows = |array: Bound<'py, PyAny>| array.call_method1("reshape", (-1, 3));
        let arrays = [rows(vertices.into_any())?, rows(faces.into_any())?];
        PyTuple::new(py, arrays)
    }
}

/// Renders a scene with the operations of a datapath; with ``timed``, also simulates the timing.
///
/// The work is that of ``raypath render``: the box and triangle tests are jobs of the datapath; the stack of a ray, the
/// division and the shading are done in software and take no time in the simulation. The simulation keeps
/// ``rays_in_flight`` pixels before the pipeline, and every fetch of a node or leaf takes ``memory_latency`` cycles.
///
/// Args:
///     scene: the mesh.
///     eye: the position of the camera; without it, the camera sees the whole mesh, and ``target``, ``up`` and ``fov``
///         count for nothing.
///     target: the point at which the camera looks; the origin by default.
///     up: the direction that is upwards in the picture.
///     fov: the vertical field of view in degrees, more than 0 and less than 180.
///     size: width and height in pixels.
///     shadows: whether to trace a ray from each hit towards the sun.
///     ao: the number of ambient-occlusion rays from each hit, 0 to 4096.
///     samples: samples per pixel along each axis, 1 to 64.
///     two_sided: whether triangles are hit from behind too.
///     seed: the seed of ambient-occlusion rays.
///     datapath: a datapath in fp32 without features; the preset ``paper`` by default.
///     rays_in_flight: the number of pixels in flight in the simulation, at least 1.
///     memory_latency: cycles of a fetch in the simulation.
///     timed: the number of evenly spread pixels that are simulated; none by default.
///
/// Returns:
///     The picture (``image``, also shown by notebooks), the jobs of each pixel (``jobs``), the rays with their hits
///     and jobs by kind (``rays``) and the ``timing``. The latter has ``in_flight``, ``memory_latency``, ``agents``
///     (simulated pixels), ``cycles``, ``jobs`` and the jobs of each operation, ``jobs_per_cycle``,
///     ``agents_per_cycle``, ``mean_latency`` (of a job, in cycles), ``fetches``, and the use of the cycles: a job was
///     ``accepted`` or ``refused``, or none was offered because all agents waited for memory (``starved_memory``), all
///     for outcomes (``starved_outcomes``), or some for each (``starved_both``).
///
/// Raises:
///     ValueError: an argument out of range.
///     KeyboardInterrupt: after Ctrl-C.
///
/// Warns:
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> scene = raypath.Scene(np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
///     >>> picture = raypath.render(scene, eye=(0, 0, 4), size=(64, 48), timed=4000)
///     >>> picture.image.shape, picture.timing["quadbox"]
///     ((48, 64, 3), 3072)
#[pyfunction]
#[pyo3(signature = (scene, *, eye = None, target = [0.0; 3], up = [0.0, 1.0, 0.0], fov = 36.0,
    size = (640, 480), shadows = false, ao = 0, samples = 1, two_sided = false, seed = 1, datapath = None,
    rays_in_flight = 256, memory_latency = 100, timed = 0))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn render(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    eye: Option<[f32; 3]>,
    target: [f32; 3],
    up: [f32; 3],
    fov: f32,
    size: (u32, u32),
    shadows: bool,
    ao: u32,
    samples: u32,
    two_sided: bool,
    seed: u64,
    datapath: Option<&Bound<'_, Datapath>>,
    rays_in_flight: usize,
    memory_latency: u64,
    timed: usize,
) -> PyResult<Rendering> {
    let datapath = plain(datapath)?;
    if size.0 == 0 || size.1 == 0 {
        return Err(value_error(format!("size: found {} x {} pixels, expected at least 1 x 1", size.0, size.1)));
    }
    if ao > 4096 {
        return Err(value_error(format!("ao: found {ao} rays, expected 0 to 4096")));
    }
    let camera = match eye {
        None => Camera::framing(scene.get().inner.mesh(), size.0 as f32 / size.1 as f32),
        Some(eye) => Camera::new(eye, target, up, fov).map_err(|problem| value_error(format!("camera: {problem}")))?,
    };
    let tracing = Tracing { rules: datapath.config().semantics.rules_in_full(), two_sided };
    let shading = Shading { tracing, shadows, ambient_occlusion: ao, samples, seed };
    let system = system(&datapath, rays_in_flight, memory_latency);
    let scene = &*scene.get().inner;
    watched(py, move |progress| {
        let rendered = render_scene(scene, &camera, size, &shading, progress).map_err(value_error)?;
        let timing = match timed {
            0 => None,
            most => {
                let spec = PictureSpec { scene, camera, size, shading };
                let sample = Sample::spread(rendered.jobs.len(), most);
                let timing = time_picture(&spec, sample, &system, &mut (), progress).map_err(value_error)?.0;
                Some((timing, system))
            }
        };
        Ok(Rendering { rendered, timing })
    })
}

/// Traces rays to their closest hits with the operations of a datapath; with ``timed``, also simulates the timing.
///
/// Args:
///     scene: the mesh.
///     rays: rays of ``raypath.rays``.
///     two_sided: whether triangles are hit from behind too.
///     datapath: a datapath in fp32 without features; the preset ``paper`` by default.
///     rays_in_flight: the number of rays in flight in the simulation, at least 1.
///     memory_latency: cycles of a fetch in the simulation.
///     timed: the number of evenly spread rays that are simulated; none by default.
///
/// Returns:
///     The hits (``triangle``, ``t``, ``t_num``, ``t_denom``, ``back_face``) and the ``timing``, as that of
///     ``raypath.render``.
///
/// Raises:
///     ValueError: another type or shape; an argument out of range.
///     KeyboardInterrupt: after Ctrl-C.
///
/// Warns:
///
/// Example:
///     See ``raypath.Scene``.
#[pyfunction]
#[pyo3(signature = (scene, rays, *, two_sided = false, datapath = None, rays_in_flight = 256, memory_latency = 100,
    timed = 0))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn trace(
    py: Python<'_>,
    scene: &Bound<'_, PyScene>,
    rays: &Bound<'_, PyAny>,
    two_sided: bool,
    datapath: Option<&Bound<'_, Datapath>>,
    rays_in_flight: usize,
    memory_latency: u64,
    timed: usize,
) -> PyResult<Trace> {
    let datapath = plain(datapath)?;
    let rays: Vec<ops::Ray<ops::Binary32>> = items::<Ray>(rays, "rays")?.iter().map(Into::into).collect();
    let tracing = Tracing { rules: datapath.config().semantics.rules_in_full(), two_sided };
    let system = system(&datapath, rays_in_flight, memory_latency);
    let scene = &*scene.get().inner;
    let mut output = Output::new::<TraceHit>(py, rays.len())?;
    let rows = output.items()?;
    let timing = watched(py, |progress| {
        let (hits, _) = trace_closest(scene, &rays, tracing, progress).map_err(value_error)?;
        rows.iter_mut().zip(&hits).for_each(|(row, hit)| *row = trace_hit(hit.as_ref()));
        if timed == 0 {
            return Ok(None);
        }
        let batch = RayBatch { scene, rays: &rays, tracing };
        let sample = Sample::spread(rays.len(), timed);
        Ok(Some(time_rays(&batch, sample, &system, &mut (), progress).map_err(value_error)?.0))
    })?;
    let timing = timing.map(|timing| figures(py, &timing, &system)).transpose()?;
    Ok(Trace::of(output.into_array(), timing))
}

fn trace_hit(hit: Option<&Hit>) -> TraceHit {
    let Some(hit) = hit else { return TraceHit { triangle: -1, t: f32::INFINITY, ..TraceHit::default() } };
    let Hit { triangle, from_behind, t_num, t_denom, t, .. } = *hit;
    TraceHit { triangle: triangle.cast_signed(), t, t_num, t_denom, back_face: from_behind.into() }
}
