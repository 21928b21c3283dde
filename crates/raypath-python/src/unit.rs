//! The classes `Unit` and `UnitScene`.

use crate::array::{Output, item, items, items_like};
use crate::config::{Around, chosen, toml};
use crate::error::{exception, value_error};
use crate::hits::UnitHits;
use crate::query::{RayQuery, rays_of};
use crate::tables::row;
use crate::unit_search::{self, UnitSearch};
use crate::watch::{abandoned_at_signals, watched};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple};
use rayon::prelude::*;
use raypath_embed::{self as embed, SceneGeometry, SceneInput, SceneInstance, UnitHit, UnitRay, Vertices};
use raypath_render::Bounds;
use raypath_rtl::Config;
use raypath_rtl::report::picture;
use raypath_search::{GraphParameters, UnitPlace};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::state::{NO_INSTANCE, status};
use raypath_traversal::system::{CacheParameters, SystemParameters};
use raypath_traversal::{Queries, StepParameters, UnitParameters};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;

/// A traversal unit around a datapath: a ray goes in, its closest or any hit comes out.
///
/// It does not change, so that threads can share it. Its methods release the interpreter lock while they compute.
///
/// Args:
///     preset: the name of a configuration of the datapath, as for ``Datapath``. Distance operations are left out.
///     config: in place of a preset, the path of a TOML file, or its text, which contains "=".
///     flags: the options of ``raypath generate --unit``, with ``_`` in place of ``-``: ``contexts``, ``stack``,
///         ``node``, ``memory_width``, ``id_width``, ``address_width``, ``divider_latency``, ``ram_latency``, ``node_limit``,
///         ``front``, and those of the datapath. ``instances=True`` for scenes of two levels; ``queries="flags"`` for geometries that are opaque or not, and
///         masks and flags of instances; ``queries="full"`` for candidates and procedural boxes, too.
///
/// Raises:
///     ValueError: a value that a flag does not have; a datapath that the unit does not have.
///     TypeError: a keyword that is not a flag.
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> unit = raypath.Unit("compact", contexts=16)
///     >>> scene = unit.scene(np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
///     >>> rays = scene.rays(np.float32([[0, 0, 4], [9, 0, 4]]), np.float32([[0, 0, -2], [0, 0, -1]]))
///     >>> hits = unit.trace(scene, rays)
///     >>> hits.status, hits.t
///     (array([1, 0], dtype=uint32), array([ 2., inf], dtype=float32))
#[pyclass(module = "raypath", frozen)]
pub struct Unit {
    pub inner: Arc<embed::Unit>,
    /// The configuration of the datapath without what the unit adds.
    given: Config,
}

#[pymethods]
impl Unit {
    #[new]
    #[pyo3(signature = (preset = None, *, config = None, **flags))]
    fn new(
        py: Python<'_>,
        preset: Option<&str>,
        config: Option<&Bound<'_, PyAny>>,
        flags: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut parameters = UnitParameters::default();
        let set = &mut |name: &str, value: &str| parameters.set(name, value).unwrap_or(Ok(()));
        let around = Around { of: "a unit", names: UnitParameters::NAMES, set };
        let config = chosen(preset, config, flags, around)?;
        let inner = py.detach(|| embed::Unit::new(config, parameters)).map_err(exception)?;
        Ok(Self { inner: Arc::new(inner), given: config })
    }

    /// The parameters of the unit by their keywords, without those of the datapath.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let row = PyDict::new(py);
        let parameters = self.inner.parameters();
        for parameter in UnitParameters::TABLE {
            let (name, value) = (parameter.name.replace('-', "_"), parameter.get(&parameters));
            match (value.parse::<u32>(), value.parse::<bool>()) {
                (Ok(number), _) => row.set_item(name, number)?,
                (_, Ok(has)) => row.set_item(name, has)?,
                _ => row.set_item(name, value)?,
            }
        }
        Ok(row)
    }

    /// A scene of triangles in the layout that this unit reads, with its nodes, as ``raypath scene`` writes it.
    ///
    /// Args:
    ///     triangles: float32 array of shape (n, 3, 3): three vertices for each triangle, counter-clockwise as seen
    ///         from its front, with finite coordinates of magnitude at most 2**40. Or a list of ``raypath.Geometry``,
    ///         for a unit with ``queries``.
    ///     reach: with instances, the greatest distance, along any axis, between the origin of a ray and a vertex. Rays
    ///         from further away may lose hits at the edges of instances. 16 times the longest side by default.
    ///     instances: the places of the triangles in the scene, for a unit with ``instances``: a float64 array of shape
    ///         (m, 3, 4), an affine matrix from the triangles to the scene for each place. The last number of each row
    ///         is the translation, and numbers have a magnitude of at most 2**40. Or a list of ``raypath.Instance``.
    ///
    /// Raises:
    ///     ValueError: another type or shape; a coordinate out of range; no triangle, or too many; no instance, one
    ///         that is too far away, a matrix without an inverse, or a unit without ``instances`` or ``queries`` that
    ///         the scene needs.
    #[pyo3(signature = (triangles, *, reach = None, instances = None))]
    fn scene(
        &self,
        py: Python<'_>,
        triangles: &Bound<'_, PyAny>,
        reach: Option<f32>,
        instances: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<UnitScene> {
        let (mut vertices, mut boxes, mut geometries) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |triangles: &Bound<'_, PyAny>, name: &str| -> PyResult<u32> {
            let corners = items::<Vertices>(triangles, name)?;
            vertices.extend(corners.iter().flat_map(|&Vertices { a, b, c }| [a, b, c]));
            let most = u32::MAX / 3;
            let problem = || value_error(format!("{name}: found {}, expected at most {most}", vertices.len() / 3));
            u32::try_from(vertices.len()).map_err(|_| problem())?;
            Ok(corners.len() as u32)
        };
        if let Ok(list) = triangles.cast::<PyList>() {
            for (index, geometry) in list.iter().enumerate() {
                let geometry = of_class(&geometry, "Geometry", &format!("triangles: item {index}"))?;
                let non_opaque = (!geometry.getattr("opaque")?.is_truthy()?).into();
                let [triangles, own_boxes] = ["triangles", "boxes"].map(|field| geometry.getattr(field));
                let (triangles, own_boxes) = (triangles?, own_boxes?);
                geometries.push(if own_boxes.is_none() {
                    let triangles = add(&triangles, &format!("triangles of geometry {index}"))?;
                    SceneGeometry { triangles, boxes: 0, non_opaque }
                } else {
                    let own = items::<embed::Bounds>(&own_boxes, &format!("boxes of geometry {index}"))?;
                    boxes.extend_from_slice(&own);
                    SceneGeometry { triangles: 0, boxes: own.len() as u32, non_opaque }
                });
            }
        } else {
            add(triangles, "triangles")?;
        }
        let faces = vertices.len() as u32 / 3;
        let input = SceneInput {
            vertices,
            triangles: (0..faces).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
            boxes,
            geometries,
            instances: instances.map(|instances| instances_of(instances, false)).transpose()?,
            reach,
        };
        let unit = self.inner.clone();
        let inner = abandoned_at_signals(py, move || unit.scene(input).map_err(exception))?;
        Ok(self.scene_of(inner))
    }

    /// A scene of scenes of this unit, placed by instances. In a unit with ``nested_instances`` the scenes may have
    /// instances themselves, in any number of levels.
    ///
    /// Args:
    ///     instances: a list of ``raypath.Instance``, each with its ``scene``. Hits report the position in the list.
    ///     reach: as in ``scene``. A scene that has instances must have been built for the reach that it has at its
    ///         places.
    ///
    /// Raises:
    ///     ValueError: what ``scene`` raises; an instance without a scene, a scene of other nodes, or one that was built
    ///         for a smaller reach.
    #[pyo3(signature = (instances, *, reach = None))]
    fn group(&self, py: Python<'_>, instances: &Bound<'_, PyList>, reach: Option<f32>) -> PyResult<UnitScene> {
        let places = instances_of(instances, true)?;
        let (mut scenes, mut members): (Vec<Bound<'_, UnitScene>>, Vec<u32>) = (Vec::new(), Vec::new());
        for (index, instance) in instances.iter().enumerate() {
            let scene = instance.getattr("scene")?;
            let expected = || value_error(format!("instance {index} has the scene {scene}, expected a UnitScene"));
            let scene = scene.cast::<UnitScene>().map_err(|_| expected())?;
            scene.get().check(&self.inner)?;
            let known = scenes.iter().position(|known| known.is(scene));
            members.push(known.unwrap_or(scenes.len()) as u32);
            scenes.extend(known.is_none().then(|| scene.clone()));
        }
        let own = |scene: &Bound<'_, UnitScene>| {
            let UnitScene { data, root, within, queries, .. } = scene.get();
            let expected = "the scene of an instance is bytes from elsewhere, expected one of Unit.scene or Unit.group";
            let (min, max, reach) = within.ok_or_else(|| value_error(expected))?;
            let queries = queries.unwrap_or_default();
            Ok(embed::UnitScene { bytes: data.clone(), root: *root, bounds: [min, max], reach, queries })
        };
        let scenes = scenes.iter().map(own).collect::<PyResult<Vec<_>>>()?;
        let places: Vec<_> = members.into_iter().zip(places).collect();
        let unit = self.inner.clone();
        let inner = abandoned_at_signals(py, move || {
            unit.group(&scenes.iter().collect::<Vec<_>>(), &places, reach).map_err(exception)
        })?;
        Ok(self.scene_of(inner))
    }

    /// Traces rays by the functional model, without time. Of candidates, triangles are accepted and boxes ignored; see
    /// ``query``.
    ///
    /// Args:
    ///     scene: the memory that the unit reads. An address outside of it is an error of the memory.
    ///     rays: rays of ``scene.rays``.
    ///
    /// Returns:
    ///     n hits with the attributes ``status``, ``primitive``, ``t`` and others, each of shape (n,). They have the
    ///     bits of the hardware, for any memory and any number of contexts. All cores work on them.
    ///
    /// Raises:
    ///     ValueError: another type or shape; a ray with ``flags``, a ``cull_mask`` or a ``base`` out of range.
    ///     KeyboardInterrupt: after Ctrl-C.
    ///
    /// Warns:
    ///     UserWarning: a ray begins beyond the ``reach`` of the scene.
    fn trace(&self, py: Python<'_>, scene: &Bound<'_, UnitScene>, rays: &Bound<'_, PyAny>) -> PyResult<UnitHits> {
        let (scene, rays) = (scene.get(), items::<UnitRay>(rays, "rays")?);
        scene.check(&self.inner)?;
        scene.warn_beyond_reach(py, &rays)?;
        let mut output = Output::new::<UnitHit>(py, rays.len())?;
        let (unit, rays, hits) = (&self.inner, &*rays, output.items()?);
        unit.check(rays).map_err(exception)?;
        watched(py, |progress| {
            let pieces = rays.par_chunks(PIECE).zip(hits.par_chunks_mut(PIECE));
            pieces.try_for_each(|(rays, hits)| {
                if progress(0) { unit.trace(&scene.data, rays, hits).map_err(exception) } else { Ok(()) }
            })
        })?;
        hits_of(output)
    }

    /// Rays whose caller decides about candidates, for a unit with ``queries="full"``.
    ///
    /// Args:
    ///     scene: the memory that the unit reads.
    ///     rays: rays of ``scene.rays``.
    ///     flags: ``raypath.RayFlags`` beside those of the rays.
    ///
    /// Returns:
    ///     A ``raypath.Query``: iterate over it for candidates, and then take its ``hits``.
    ///
    /// Raises:
    ///     ValueError: another type or shape; a ray with ``flags``, a ``cull_mask`` or a ``base`` out of range.
    ///
    /// Warns:
    ///     UserWarning: a ray begins beyond the ``reach`` of the scene.
    #[pyo3(signature = (scene, rays, *, flags = 0))]
    fn query<'py>(
        &self,
        py: Python<'py>,
        scene: &Bound<'py, UnitScene>,
        rays: &Bound<'py, PyAny>,
        flags: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rays = rays_of(rays, word("flags", flags)?)?;
        scene.get().check(&self.inner)?;
        self.inner.check_queries(&rays).map_err(exception)?;
        scene.get().warn_beyond_reach(py, &rays)?;
        let query = Bound::new(py, RayQuery::new(&self.inner, scene, rays))?;
        py.import("raypath._queries")?.getattr("Query")?.call1((query,))
    }

    /// Traces rays by the cycle-exact model with a memory, and measures. Rays are offered in order as soon as the unit
    /// is ready, and hits are taken at once.
    ///
    /// Args:
    ///     scene: the memory that the unit reads.
    ///     rays: rays of ``scene.rays``.
    ///     latency: cycles from a request to the first beat of its block, 1 to 1,000,000; with a cache, of a miss.
    ///     bandwidth: the bytes that arrive from the memory in a cycle, 1 to 65,536; as many as the unit takes by
    ///         default.
    ///     cache: the bytes of the cache of each unit; none by default.
    ///     shared_cache: the bytes of a cache that all units share, behind those of the units; none by default.
    ///     cache_ways: the ways of the caches: 1, 2, 4 or 8.
    ///     cache_line: the bytes of a line of the caches: a block, or 2 or 4; a block by default.
    ///     cache_misses: the lines that a cache fetches at a time: a power of two from 2 to 64.
    ///     units: the units that share the memory, 1 to 64.
    ///
    /// Returns:
    ///     The hits, as those of ``trace``, and a dictionary of what was measured: ``cycles``, ``rays``, ``boxes`` and
    ///     ``triangles`` (jobs of the datapath), ``steps``, ``fetches``, ``beats`` (of the memory), ``cache_hits``,
    ///     ``cache_merges`` (requests that joined a miss), ``cache_misses``, ``rays_in_flight`` (the mean) and
    ///     ``jobs_per_cycle``.
    ///
    /// Raises:
    ///     ValueError: another type or shape; an argument out of range.
    ///     KeyboardInterrupt: after Ctrl-C.
    #[pyo3(signature = (scene, rays, *, latency = 100, bandwidth = None, cache = None, cache_ways = 4, cache_line = None,
        cache_misses = 32, units = 1, shared_cache = None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        scene: &Bound<'py, UnitScene>,
        rays: &Bound<'py, PyAny>,
        latency: u64,
        bandwidth: Option<u32>,
        cache: Option<u32>,
        cache_ways: u32,
        cache_line: Option<u32>,
        cache_misses: u32,
        units: u32,
        shared_cache: Option<u32>,
    ) -> PyResult<(UnitHits, Bound<'py, PyDict>)> {
        let (scene, rays) = (scene.get(), items::<UnitRay>(rays, "rays")?);
        scene.check(&self.inner)?;
        scene.warn_beyond_reach(py, &rays)?;
        let line = cache_line.unwrap_or(self.inner.parameters().step.node.block_bytes());
        let of_bytes = |bytes: Option<u32>| {
            let cache = bytes.map(|bytes| CacheParameters::of_bytes(bytes, cache_ways, line, cache_misses));
            cache.transpose().map_err(value_error)
        };
        let (cache, shared) = (of_bytes(cache)?, of_bytes(shared_cache)?);
        let system = SystemParameters { units, cache, shared, latency, bandwidth };
        let mut output = Output::new::<UnitHit>(py, rays.len())?;
        let (unit, rays, hits) = (&self.inner, &*rays, output.items()?);
        let found = watched(py, |progress| {
            unit.simulate(&scene.data, rays, &system, hits, &|done| progress(done)).map_err(exception)
        })?;
        let counts = found.unit;
        let row = row!(py,
            "cycles": counts.cycles,
            "rays": counts.rays,
            "boxes": counts.boxes,
            "triangles": counts.triangles,
            "steps": counts.steps,
            "fetches": counts.fetches,
            "beats": found.beats,
            "cache_hits": found.cache.hits,
            "cache_merges": found.cache.merges,
            "cache_misses": found.cache.misses,
            "rays_in_flight": found.ray_cycles as f64 / counts.cycles.max(1) as f64,
            "jobs_per_cycle": found.jobs_per_cycle(),
        )?;
        Ok((hits_of(output)?, row))
    }

    /// Finds the nearest vectors of each query by jobs of the unit, which needs ``search`` among its parameters, as
    /// ``raypath.Unit(search="k=32,m=64")``.
    ///
    /// Without a graph, a query is compared with all vectors. A graph is searched best-first, from its lowest layer on.
    ///
    /// Args:
    ///     base: the vectors: an array of shape (n, d) of float32, float16, or int8 with a ``scale``, as they are in
    ///         memory; or a ``raypath.SavedGraph``.
    ///     queries: an array of shape (m, d), of the same type. With a ``SavedGraph``, their type is that of the elements in
    ///         memory, to which its vectors are rounded.
    ///     k: the most neighbours of a query, 1 to n and to the ``k`` of the unit.
    ///     metric: "euclidean", "dot" or "cosine". Dot products and cosines are ordered from the greatest.
    ///     index: None, "hnsw" to build a graph of an array, or, for float32 and a unit with ``trees=1`` in ``search``, a
    ///         tree: of "boxes" around vectors of 1 to 3 dimensions, of which those within ``radius`` are found; or of
    ///         "keys" (d = 1), of which the first k in each range are found in ascending order: a query is the least and
    ///         the greatest key, so queries have the shape (m, 2), and distances are the keys.
    ///     ef: the candidates that are kept in a graph, k to the ``m`` of the unit; 5 * k, if the unit has as many.
    ///     connections: the connections of a vector in the graph, 2 to 255; twice as many in its lowest layer.
    ///     ef_construction: the candidates that are kept during construction, 1 to 65,536.
    ///     seed: the seed of the graph.
    ///     scale: an integer of int8 stands for as many times this.
    ///     bound: only vectors are neighbours whose rank is at most this: the squared distance of the elements, minus
    ///         the dot product, or the rank of the cosine. Trees have their own.
    ///     radius: the greatest distance of a neighbour in a tree of boxes.
    ///     latency: cycles of the memory, with which the jobs run through the cycle-exact model, too; None for the
    ///         functional model alone.
    ///
    /// Returns:
    ///     The neighbours (``ids``, ``distances``), the work (``evaluations``, ``beats``, ``bytes``, ``expansions``,
    ///     ``seconds``), the ``timing``, and what hardware reads (``memory``, ``jobs``).
    ///
    /// Raises:
    ///     ValueError: another type or shape; a number that is not finite; an argument out of range; a unit without
    ///         searches.
    ///     KeyboardInterrupt: after Ctrl-C.
    ///
    /// Example:
    ///     >>> import numpy as np, raypath
    ///     >>> unit = raypath.Unit(search="k=8,m=16,dimensions=64")
    ///     >>> base = np.float16([[0, 0], [3, 4], [1, 0]])
    ///     >>> found = unit.search(base, base[:1], k=3)
    ///     >>> found.ids, found.distances
    ///     (array([[0, 2, 1]]), array([[0., 1., 5.]], dtype=float32))
    #[pyo3(signature = (base, queries, k = 10, *, metric = "euclidean", index = None, ef = None, connections = 16,
        ef_construction = 200, seed = 1, scale = 1.0, bound = f32::INFINITY, radius = None, latency = None))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn search(
        &self,
        base: &Bound<'_, PyAny>,
        queries: &Bound<'_, PyAny>,
        k: usize,
        metric: &str,
        index: Option<&str>,
        ef: Option<usize>,
        connections: usize,
        ef_construction: usize,
        seed: u64,
        scale: f32,
        bound: f32,
        radius: Option<f32>,
        latency: Option<u64>,
    ) -> PyResult<UnitSearch> {
        let (graph, tree) = match (index, radius) {
            (None, None) => (None, None),
            (Some("hnsw"), None) => (Some(GraphParameters { connections, ef_construction, seed }), None),
            (Some("boxes"), Some(radius)) => (None, Some(UnitPlace::Boxes(radius))),
            (Some("boxes"), None) => return Err(value_error("radius: found None, expected a number for boxes")),
            (Some("keys"), None) => (None, Some(UnitPlace::Keys)),
            (None | Some("hnsw" | "keys"), Some(radius)) => {
                return Err(value_error(format!("radius: found {radius}, expected None without boxes")));
            }
            (Some(other), _) => {
                let problem = format!("index: found '{other}', expected None, 'hnsw', 'boxes' or 'keys'");
                return Err(value_error(problem));
            }
        };
        let metric = metric.to_string();
        let options = unit_search::Options { k, metric, graph, tree, ef, scale, bound, latency };
        unit_search::search(self, base, queries, options)
    }

    /// Writes SystemVerilog, assertions, the AXI4 wrapper and manifests, as ``raypath generate --unit`` does.
    ///
    /// Args:
    ///     folder: the folder to write to, which is created if it does not exist.
    ///
    /// Returns:
    ///     The number of files.
    ///
    /// Raises:
    ///     OSError: a file or folder that cannot be written; then no file is changed.
    fn generate(&self, py: Python<'_>, folder: PathBuf) -> PyResult<usize> {
        py.detach(|| self.inner.generate(&folder)).map_err(exception)
    }

    /// The figures for architecture simulators, as ``Datapath.card`` has them.
    fn card<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::tables::card(py, &self.inner.card())
    }

    /// The latency of the datapath inside in cycles.
    #[getter]
    fn latency(&self) -> u32 {
        self.inner.netlist().datapath.latency()
    }

    /// The number of flip-flops of the unit, with its datapath.
    #[getter]
    fn flip_flops(&self) -> u64 {
        self.inner.netlist().top.register_bits()
    }

    /// The picture of the unit's pipeline as SVG, which notebooks show.
    fn _repr_svg_(&self) -> String {
        picture::pipeline(&self.inner.netlist().datapath, self.inner.config())
    }

    fn __repr__(&self) -> String {
        format!("<raypath.Unit: {}>", self.inner.description())
    }

    /// The arguments that make an equal unit, for ``pickle``.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let arguments = self.parameters(py)?;
        arguments.set_item("config", toml(&self.given))?;
        Ok((PyTuple::empty(py), arguments))
    }
}

impl Unit {
    /// A scene of this unit.
    fn scene_of(
        &self,
        embed::UnitScene { bytes, root, bounds: [min, max], reach, queries }: embed::UnitScene,
    ) -> UnitScene {
        let node = Some(self.inner.parameters().step.node);
        UnitScene { data: bytes, root, within: Some((min, max, reach)), node, queries: Some(queries) }
    }
}

/// The object, if it is of this class of the package.
fn of_class<'py>(object: &Bound<'py, PyAny>, class: &str, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = object.py();
    if object.is_instance(&py.import("raypath")?.getattr(class)?)? {
        return Ok(object.clone());
    }
    Err(value_error(format!("{name}: found {}, expected a raypath.{class}", object.get_type().name()?)))
}

/// Instances from matrices, or from objects with their fields, which may have scenes of their own.
fn instances_of(instances: &Bound<'_, PyAny>, have_scenes: bool) -> PyResult<Vec<SceneInstance>> {
    let Ok(list) = instances.cast::<PyList>() else {
        return Ok(items(instances, "instances")?.iter().copied().map(SceneInstance::of).collect());
    };
    let instance = |(index, instance): (usize, Bound<'_, PyAny>)| {
        let instance = of_class(&instance, "Instance", &format!("instances: item {index}"))?;
        let number = |field: &str| -> PyResult<u32> {
            let value = instance.getattr(field)?;
            let expected =
                || value_error(format!("instance {index}: {field} is {value}, expected a number of 32 bits"));
            value.extract().map_err(|_| expected())
        };
        if !have_scenes && !instance.getattr("scene")?.is_none() {
            return Err(value_error(format!("instance {index} has a scene, expected none: Unit.group places scenes")));
        }
        Ok(SceneInstance {
            matrix: item(&instance.getattr("matrix")?, &format!("matrix of instance {index}"))?,
            custom_index: number("custom_index")?,
            mask: number("mask")?,
            shader_offset: number("shader_offset")?,
            flags: number("flags")?,
        })
    };
    list.iter().enumerate().map(instance).collect()
}

/// A word of 32 bits.
fn word(name: &str, value: i64) -> PyResult<u32> {
    u32::try_from(value).map_err(|_| value_error(format!("{name} is {value}, expected 0 to {}", u32::MAX)))
}

/// The rays that a core traces at once.
const PIECE: usize = 1 << 8;

/// The hits with Python's values of a miss.
fn hits_of(mut output: Output<'_>) -> PyResult<UnitHits> {
    output.items::<UnitHit>()?.iter_mut().for_each(|hit| *hit = shown(*hit));
    Ok(UnitHits::of(output.into_array(), None))
}

/// A hit as Python shows it: without one, the indices are -1 and the distance is infinity.
pub fn shown(hit: UnitHit) -> UnitHit {
    if status::is_hit(hit.status) {
        return hit;
    }
    UnitHit { primitive: u32::MAX, geometry: u32::MAX, instance: NO_INSTANCE, t: f32::INFINITY, ..hit }
}

/// A scene in memory, as a ``Unit`` reads it.
///
/// Args:
///     data: the bytes, the first of which has the address 0; ``Unit.scene`` and ``raypath scene`` make them.
///     root: the child word of the root, which ``raypath scene`` prints.
///     within: the corners of the scene's box and its reach, for warnings of rays from further away.
///     node: the kind of its nodes, ``"wide4"``, ``"quantised"`` or ``"wide8"``; a unit that reads others refuses it.
///     queries: those that it needs, ``"none"``, ``"flags"`` or ``"full"``; a unit that has less refuses it.
///
/// Raises:
///     ValueError: a root of more than 32 bits; another node or queries.
#[pyclass(module = "raypath", frozen)]
pub struct UnitScene {
    pub data: Box<[u8]>,
    root: u32,
    within: Option<Within>,
    node: Option<NodeKind>,
    queries: Option<Queries>,
}

/// What makes a scene: data, root, box and reach, nodes, queries.
type SceneArguments<'py> = (Bound<'py, PyBytes>, u32, Option<Within>, Option<String>, Option<String>);

/// The corners of a scene's box, and its reach.
type Within = ([f32; 3], [f32; 3], f32);

impl UnitScene {
    /// An error for a unit that reads other nodes, or that has less than the scene needs.
    pub fn check(&self, unit: &embed::Unit) -> PyResult<()> {
        let StepParameters { node, features, .. } = unit.parameters().step;
        let problem = match (self.node, self.queries) {
            (Some(found), _) if found != node => format!("found nodes {found}, expected {node}, which the unit reads"),
            (_, Some(needs)) if needs > features.queries => {
                format!("it needs a unit with queries {needs}, found {}", features.queries)
            }
            _ => return Ok(()),
        };
        Err(value_error(format!("scene: {problem}")))
    }

    fn warn_beyond_reach(&self, py: Python<'_>, rays: &[UnitRay]) -> PyResult<()> {
        let Some((min, max, reach)) = self.within else { return Ok(()) };
        let bounds = Bounds { min, max };
        warn_beyond(py, reach, rays.iter().map(|ray| bounds.reach_from(ray.origin)))
    }
}

/// Warns of ray origins at these distances from the furthest point of a scene, if some are beyond its reach.
///
/// # Errors
/// The warning, if warnings are errors.
pub fn warn_beyond(py: Python<'_>, reach: f32, distances: impl Iterator<Item = f32>) -> PyResult<()> {
    let (mut count, mut farthest) = (0, reach);
    for distance in distances.filter(|distance| *distance > reach) {
        (count, farthest) = (count + 1, distance.max(farthest));
    }
    if count == 0 {
        return Ok(());
    }
    let problem = format!(
        "{count} rays begin {farthest} away from a point of the scene, which was built for a reach of {reach}: hits at \
         edges can be lost; expected a scene with reach={farthest}"
    );
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(problem)?, 1)
}

#[pymethods]
impl UnitScene {
    #[new]
    #[pyo3(signature = (data, root, within = None, node = None, queries = None))]
    fn new(
        data: &Bound<'_, PyBytes>,
        root: i64,
        within: Option<Within>,
        node: Option<&str>,
        queries: Option<&str>,
    ) -> PyResult<Self> {
        let root = word("root", root)?;
        let node = node.map(str::parse).transpose().map_err(value_error)?;
        let queries = queries.map(str::parse).transpose().map_err(value_error)?;
        Ok(Self { data: data.as_bytes().into(), root, within, node, queries })
    }

    /// The arguments that make an equal scene, for ``pickle``.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> SceneArguments<'py> {
        let (node, queries) = (self.node.map(|node| node.to_string()), self.queries.map(|queries| queries.to_string()));
        (self.data(py), self.root, self.within, node, queries)
    }

    /// The greatest distance, along any axis, between the origin of a ray and a vertex; None for bytes from elsewhere.
    #[getter]
    fn reach(&self) -> Option<f32> {
        self.within.map(|(.., reach)| reach)
    }

    /// The bytes, from address 0 on. Each access makes a copy.
    #[getter]
    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.data)
    }

    /// The child word of the root, with which each ray begins.
    #[getter]
    fn root(&self) -> u32 {
        self.root
    }

    /// Rays as the unit takes them, for this scene.
    ///
    /// Directions of any length are allowed, and distances are in units of it. The unit refuses a ray with a direction
    /// that cannot be inverted, a value that is not finite, or a negative ``t_min``: its hit has the status 3, as has
    /// that of a ray whose flags have no meaning together.
    ///
    /// Args:
    ///     origins: float32 array of shape (n, 3).
    ///     directions: float32 array of shape (n, 3).
    ///     t_min: hits count beyond this distance.
    ///     t_max: hits count below this distance; infinity reaches everything.
    ///     flags: ``raypath.RayFlags``.
    ///     cull_mask: 8 bits; with ``instances`` and ``queries``, instances count whose mask has one of them.
    ///     base: with ``address_width`` above 32, the bits of every address above its lower 32. The memory of
    ///         ``trace`` has the addresses of base 0.
    ///
    /// Returns:
    ///     A structured array of shape (n,) with the fields of the C structure ``raypath_unit_ray``: ``origin``,
    ///     ``direction``, ``t_min``, ``t_max``, ``flags``, ``cull_mask``, ``root`` and ``base``. A field can be changed
    ///     for each ray.
    ///
    /// Raises:
    ///     ValueError: another type or shape, or a word of more than 32 bits.
    #[pyo3(signature = (origins, directions, *, t_min = 0.0, t_max = f64::INFINITY, flags = 0, cull_mask = 255,
        base = 0))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn rays<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: f64,
        t_max: f64,
        flags: i64,
        cull_mask: i64,
        base: i64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (flags, cull_mask, base) = (word("flags", flags)?, word("cull_mask", cull_mask)?, word("base", base)?);
        let distance = |name: &str, value: f64| match value as f32 {
            rounded if rounded.is_infinite() && value.is_finite() => {
                Err(value_error(format!("{name} is {value:e}, expected a number of binary32 or infinity")))
            }
            rounded => Ok(rounded),
        };
        let (t_min, t_max) = (distance("t_min", t_min)?, distance("t_max", t_max)?);
        let origins = items::<[f32; 3]>(origins, "origins")?;
        let directions = items_like::<[f32; 3]>(directions, "directions", origins.len(), "origins")?;
        let root = self.root;
        let mut output = Output::new::<UnitRay>(py, origins.len())?;
        for (ray, (&origin, &direction)) in output.items()?.iter_mut().zip(origins.iter().zip(directions.iter())) {
            *ray = UnitRay { origin, direction, t_min, t_max, flags, cull_mask, root, base };
        }
        Ok(output.into_array())
    }

    fn __len__(&self) -> usize {
        self.data.len()
    }

    fn __repr__(&self) -> String {
        format!("<raypath.UnitScene: {} bytes, root {:#010x}>", self.data.len(), self.root)
    }
}
