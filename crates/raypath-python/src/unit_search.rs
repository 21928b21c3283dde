//! Nearest-neighbour search by jobs of the unit.

use crate::array::matrix;
use crate::error::value_error;
use crate::tables::row;
use crate::unit::Unit;
use crate::watch::watched;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use raypath_search::{
    GraphParameters, Layer, MemoryLimit, Metric, SearchMemory, UnitJobs, UnitPlace, UnitSpec, UnitTiming, Vectors,
};
use raypath_traversal::search::{Elements, Neighbour, SearchMetric};
use std::path::PathBuf;
use std::sync::Arc;

/// Vectors with the lowest layer of an HNSW graph, which ``raypath.read_graph`` reads. It does not change.
#[pyclass(module = "raypath", frozen)]
pub struct SavedGraph {
    vectors: Vectors,
    layer: Layer,
}

#[pymethods]
impl SavedGraph {
    /// float32 array of shape (n, d): the vectors, in the order of their labels. Each access makes a new array.
    #[getter]
    fn vectors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers = PyArray1::from_slice(py, self.vectors.data());
        Ok(numbers.reshape([self.vectors.len(), self.vectors.dimensions()])?.into_any())
    }

    /// The indices of the vectors near each vector, a list for each.
    #[getter]
    fn neighbours(&self) -> Vec<Vec<u32>> {
        self.layer.neighbours().to_vec()
    }

    /// The most neighbours of a vector.
    #[getter]
    fn degree(&self) -> usize {
        self.layer.degree()
    }

    /// The index of the vector with which a search begins.
    #[getter]
    fn entry(&self) -> u32 {
        self.layer.entry()
    }

    fn __repr__(&self) -> String {
        let (count, dimensions, degree) = (self.vectors.len(), self.vectors.dimensions(), self.layer.degree());
        format!("<raypath.SavedGraph: {count} vectors of {dimensions} dimensions, {degree} neighbours>")
    }
}

/// Reads a graph that ``hnswlib`` saved (``save_index``, vectors of floats) or an ``IndexHNSWFlat`` of ``faiss``
/// (``write_index``). Labels are 0 to the number of vectors - 1, in any order.
///
/// Args:
///     path: the file.
///
/// Returns:
///     The graph, which ``Unit.search`` searches.
///
/// Raises:
///     ValueError: a file that cannot be read, is no such graph, or takes more than 2 GiB of memory.
#[pyfunction]
pub fn read_graph(py: Python<'_>, path: PathBuf) -> PyResult<SavedGraph> {
    let found = py.detach(|| raypath_search::read_graph(&path, MemoryLimit::DEFAULT)).map_err(value_error)?;
    Ok(SavedGraph { vectors: found.vectors, layer: found.layer })
}

/// The neighbours of m queries, as a unit finds them.
#[pyclass(module = "raypath", frozen)]
pub struct UnitSearch {
    jobs: UnitJobs,
    found: raypath_search::UnitSearch,
    k: usize,
    timing: Option<UnitTiming>,
}

#[pymethods]
impl UnitSearch {
    /// int64 array of shape (m, k): the indices of the neighbours of each query, the best first. -1 where there are
    /// fewer. Each access makes a new array.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |near| near.map_or(-1, |near| i64::from(near.index)))
    }

    /// float32 array of shape (m, k): their Euclidean distances, dot products, or cosines; NaN where there is no
    /// neighbour. Each access makes a new array.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |near| near.map_or(f32::NAN, |near| near.distance))
    }

    /// The number of vectors that were compared with queries.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.found.work.evaluations
    }

    /// The number of their beats, each a job of the datapath.
    #[getter]
    fn beats(&self) -> u64 {
        self.found.work.beats
    }

    /// The number of bytes that were read.
    #[getter]
    fn bytes(&self) -> u64 {
        self.found.bytes()
    }

    /// The number of candidates whose neighbours were read.
    #[getter]
    fn expansions(&self) -> u64 {
        self.found.expansions
    }

    /// The wall-clock time of the functional model in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.found.seconds
    }

    /// What the unit read: vectors, lists and jobs, the first byte at address 0. Each access makes a copy.
    #[getter]
    fn memory<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.jobs.image().bytes())
    }

    /// uint32 array of shape (m,): the addresses of the jobs in ``memory``. Each access makes a new array.
    #[getter]
    fn jobs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, self.jobs.addresses())
    }

    /// With ``latency``, what the cycle-exact model measured: ``cycles``, ``beats`` (of the datapath),
    /// ``memory_beats`` and ``beats_per_cycle``; otherwise None.
    #[getter]
    fn timing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(timing) = &self.timing else { return Ok(None) };
        let UnitTiming { cycles, beats, memory_beats, .. } = *timing;
        let rate = timing.beats_per_cycle();
        row!(py, "cycles": cycles, "beats": beats, "memory_beats": memory_beats, "beats_per_cycle": rate).map(Some)
    }

    fn __repr__(&self) -> String {
        format!("<raypath.UnitSearch: {} neighbours of {} queries>", self.k, self.found.rows.len())
    }
}

impl UnitSearch {
    fn each<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(Option<&Neighbour>) -> T,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = &self.found.rows;
        let items = rows.iter().flat_map(|row| (0..self.k).map(|rank| of(row.get(rank))));
        let array = PyArray1::from_vec(py, items.collect());
        Ok(array.reshape([rows.len(), self.k])?.into_any())
    }
}

/// The arguments of `Unit.search` besides arrays.
pub struct Options {
    pub k: usize,
    pub metric: String,
    pub graph: Option<GraphParameters>,
    pub tree: Option<UnitPlace<'static>>,
    pub ef: Option<usize>,
    pub scale: f32,
    pub bound: f32,
    pub latency: Option<u64>,
}

/// `Unit.search`.
pub fn search(
    unit: &Unit,
    base: &Bound<'_, PyAny>,
    queries: &Bound<'_, PyAny>,
    options: Options,
) -> PyResult<UnitSearch> {
    let (py, inner) = (base.py(), Arc::clone(&unit.inner));
    let Some(searches) = inner.parameters().search.0 else {
        return Err(value_error(
            "a unit without searches, expected one with them, as raypath.Unit(search=\"k=32,m=64\")",
        ));
    };
    let Options { k, metric, graph, tree, ef, scale, bound, latency } = options;
    let metric: SearchMetric = metric.parse().map_err(value_error)?;
    let (elements, queries) = elements(queries, "queries", scale)?;
    let saved = base.cast::<SavedGraph>().ok();
    let own;
    let base = match &saved {
        Some(saved) => &saved.get().vectors,
        None => {
            let (of_base, vectors) = self::elements(base, "base", scale)?;
            if of_base != elements {
                return Err(value_error("queries: found another type than that of base, expected the same"));
            }
            own = vectors;
            &own
        }
    };
    let built = match (&saved, graph) {
        (None, Some(graph)) => Some((graph, graph_metric(metric)?)),
        (Some(_), _) if graph.is_some() || tree.is_some() => {
            return Err(value_error("index: found one for a graph, expected None"));
        }
        _ => None,
    };
    let saved_layer = saved.as_ref().map(|saved| &saved.get().layer);
    let ef = ef.unwrap_or(k.saturating_mul(5).min(searches.candidates as usize)).max(k);
    watched(py, |progress| {
        let layer = built.map(|(graph, metric)| Layer::build(base, metric, &graph, progress).map(|(layer, _)| layer));
        let layer = layer.transpose().map_err(value_error)?;
        let graph = layer.as_ref().or(saved_layer).map(|layer| UnitPlace::Graph(layer, ef));
        let place = tree.or(graph).unwrap_or(UnitPlace::All);
        let spec = UnitSpec { base, queries: &queries, metric, elements, neighbours: k, bound, place, unit: searches };
        let jobs = UnitJobs::new(&spec).map_err(value_error)?;
        let found = jobs.search(progress).map_err(value_error)?;
        let time = |latency: u64| {
            let (shape, parameters) = (inner.netlist().shape(), inner.parameters());
            let memory = SearchMemory { width: parameters.memory_width, latency };
            jobs.time(&found, (&shape, parameters), memory, [usize::MAX, 0], progress)
        };
        let timing = latency.map(time).transpose().map_err(value_error)?;
        Ok(UnitSearch { jobs, found, k, timing })
    })
}

/// Vectors, and the elements of their array in memory.
fn elements(array: &Bound<'_, PyAny>, name: &str, scale: f32) -> PyResult<(Elements, Vectors)> {
    let dtype =
        array.getattr("dtype").and_then(|dtype| dtype.getattr("name")).and_then(|name| name.extract::<String>());
    let py = array.py();
    match dtype.unwrap_or_default().as_str() {
        "int8" => {
            if !(scale.is_finite() && scale > 0.0) {
                return Err(value_error(format!("scale: found {scale}, expected a finite number above 0")));
            }
            let (numbers, _, dimensions) = matrix(array, name)?;
            let numbers = numbers.iter().map(|number| number * scale).collect();
            let vectors =
                Vectors::new(dimensions, numbers).map_err(|problem| value_error(format!("{name}: {problem}")))?;
            Ok((Elements::Int8 { scale }, vectors))
        }
        "float16" => Ok((Elements::Binary16, vectors(py, array, name)?)),
        _ => Ok((Elements::Binary32, vectors(py, array, name)?)),
    }
}

/// The metric by which a graph is built.
fn graph_metric(metric: SearchMetric) -> PyResult<Metric> {
    match metric {
        SearchMetric::Euclidean => Ok(Metric::Euclidean),
        SearchMetric::Cosine => Ok(Metric::Angular),
        SearchMetric::Dot => {
            Err(value_error("index: found \"hnsw\" for dot products, expected the metric euclidean or cosine"))
        }
    }
}

fn vectors(py: Python<'_>, array: &Bound<'_, PyAny>, name: &str) -> PyResult<Vectors> {
    let (numbers, _, dimensions) = matrix(array, name)?;
    let numbers = &*numbers;
    py.detach(|| Vectors::new(dimensions, numbers.to_vec()))
        .map_err(|problem| value_error(format!("{name}: {problem}")))
}
