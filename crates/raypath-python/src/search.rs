//! Nearest-neighbour search.

use crate::array::matrix;
use crate::datapath::Datapath;
use crate::error::value_error;
use crate::timing::plain;
use crate::watch::watched;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use raypath_search::{Exact, Graph, GraphParameters, LaneCount, Metric, Neighbour, SearchResults, Vectors};

/// The neighbours of m queries.
#[pyclass(module = "raypath", frozen)]
pub struct Search {
    results: SearchResults,
    k: usize,
}

#[pymethods]
impl Search {
    /// int64 array of shape (m, k): the indices of the neighbours of each query, nearest first. -1 if a search through
    /// a graph found fewer. Each access makes a new array.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |near| near.map_or(-1, |near| i64::from(near.index)))
    }

    /// float64 array of shape (m, k): their distances, infinity where there is no neighbour. Each access makes a new
    /// array.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |near| near.map_or(f64::INFINITY, |near| near.distance))
    }

    /// The number of pairs of vectors that were compared.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.results.work.evaluations
    }

    /// The number of beats of these pairs, each a job of the datapath.
    #[getter]
    fn beats(&self) -> u64 {
        self.results.work.beats
    }

    /// The wall-clock time of the search in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.results.seconds
    }

    fn __repr__(&self) -> String {
        format!("<raypath.Search: {} neighbours of {} queries>", self.k, self.results.rows.len())
    }
}

impl Search {
    fn each<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(Option<&Neighbour>) -> T,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = &self.results.rows;
        let items = rows.iter().flat_map(|row| (0..self.k).map(|rank| of(row.get(rank))));
        let array = PyArray1::from_vec(py, items.collect());
        Ok(array.reshape([rows.len(), self.k])?.into_any())
    }
}

/// Finds the nearest vectors of each query with the distance operations of a datapath.
///
/// The work is that of ``raypath search``: the sums of a distance are jobs of the datapath; square root, division and
/// selection are done in software. ``raypath.Unit.search`` does all in the unit.
///
/// Args:
///     vectors: float32 array of shape (n, k): finite coordinates of 1 to 65,536 dimensions.
///     queries: float32 array of shape (m, k).
///     k: the number of neighbours of each query, 1 to n.
///     metric: "euclidean", or "angular" for 1 minus the cosine of the angle.
///     index: None to compare each query with every vector, "hnsw" to search approximately through a graph.
///     connections: the maximum number of connections of a vector in the graph, 2 to 255.
///     ef_construction: the number of candidates kept during construction of the graph, 1 to 65,536.
///     ef: the number of candidates kept during a search of the graph, k to 65,536; 5 * k by default.
///     seed: the seed of the graph.
///     datapath: a datapath in fp32 without features; the preset ``paper`` by default.
///
/// Returns:
///     The neighbours (``ids``, ``distances``) and the work (``evaluations``, ``beats``, ``seconds``).
///
/// Raises:
///     ValueError: another type or shape; a coordinate that is not finite; an argument out of range; a datapath without
///         distances.
///     KeyboardInterrupt: after Ctrl-C.
///
/// Example:
///     >>> import numpy as np, raypath
///     >>> vectors = np.float32([[0, 0], [3, 4], [1, 0]])
///     >>> found = raypath.search(vectors, vectors[:1], k=3)
///     >>> found.ids, found.distances
///     (array([[0, 2, 1]]), array([[0., 1., 5.]]))
#[pyfunction]
#[pyo3(signature = (vectors, queries, k = 10, *, metric = "euclidean", index = None, connections = 16,
    ef_construction = 200, ef = None, seed = 1, datapath = None))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn search(
    py: Python<'_>,
    vectors: &Bound<'_, PyAny>,
    queries: &Bound<'_, PyAny>,
    k: usize,
    metric: &str,
    index: Option<&str>,
    connections: usize,
    ef_construction: usize,
    ef: Option<usize>,
    seed: u64,
    datapath: Option<&Bound<'_, Datapath>>,
) -> PyResult<Search> {
    let datapath = plain(datapath)?;
    let graph = match index {
        None => None,
        Some("hnsw") => Some(GraphParameters { connections, ef_construction, seed }),
        Some(other) => return Err(value_error(format!("index: found '{other}', expected None or 'hnsw'"))),
    };
    let lanes = LaneCount::of(datapath.lanes())
        .ok_or_else(|| value_error("datapath: found no lanes, expected a datapath with distances"))?;
    let work = Work {
        base: self::vectors(py, vectors, "vectors")?,
        queries: self::vectors(py, queries, "queries")?,
        k,
        metric: metric.parse().map_err(value_error)?,
        lanes,
        graph,
        ef: match ef {
            Some(ef) if !(k..=65_536).contains(&ef) => {
                return Err(value_error(format!("ef: found {ef}, expected {k} to 65,536")));
            }
            ef => ef.unwrap_or(5 * k),
        },
    };
    watched(py, |progress| work.run(progress))
}

struct Work {
    base: Vectors,
    queries: Vectors,
    k: usize,
    metric: Metric,
    lanes: LaneCount,
    graph: Option<GraphParameters>,
    ef: usize,
}

impl Work {
    fn run(self, progress: &(dyn Fn(u64) -> bool + Sync)) -> PyResult<Search> {
        let Self { base, queries, k, metric, lanes, graph, ef } = self;
        let graph = graph.map(|parameters| Graph::build(&base, metric, lanes, &parameters, progress));
        let graph = graph.transpose().map_err(value_error)?;
        let results = match &graph {
            None => Exact::new(&base, metric, lanes).search(&queries, k, progress),
            Some(graph) => graph.search(&queries, k, ef, progress),
        };
        let results = results.map_err(value_error)?;
        Ok(Search { results, k })
    }
}

pub fn vectors(py: Python<'_>, array: &Bound<'_, PyAny>, name: &str) -> PyResult<Vectors> {
    let (numbers, _, dimensions) = matrix(array, name)?;
    let numbers = &*numbers;
    py.detach(|| Vectors::new(dimensions, numbers.to_vec()))
        .map_err(|problem| value_error(format!("{name}: {problem}")))
}
