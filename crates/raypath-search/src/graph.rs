use crate::exact::{check, norms};
use crate::{
    LaneCount, Metric, Neighbour, SearchError, SearchResults, Vectors, Work, cosine_distance, euclidean_distance,
    kernel,
};
use hnsw_rs::prelude::{Distance, Hnsw};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use raypath_timing::{Progress, ProgressCounter};
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Approximate search, with the distances of the datapath, through a graph (Malkov and Yashunin, *Efficient and robust
/// approximate nearest neighbor search using Hierarchical Navigable Small World graphs*, 2018).
///
/// The graph is that of the crate `hnsw_rs`. Vectors are inserted one after another, so equal bases, parameters and
/// seeds give equal graphs, on any machine and with any number of threads.
pub struct Graph<'v> {
    index: Hnsw<'static, Item, DatapathDistance<'v>>,
    built: Work,
}

/// The trace of a graph search for one query, which a [`QueryAgent`](crate::QueryAgent) replays.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SearchTrace {
    /// The vectors whose distances were evaluated, in order. A vector can occur in several layers of the graph.
    pub candidates: Vec<u32>,
    /// The neighbours found, nearest first; candidates of upper layers, which only guide the search, may be nearer.
    pub found: Vec<u32>,
}

impl SearchTrace {
    /// The work for vectors of dimension `dimensions`, with the norm of the query for the angular metric.
    pub fn work(&self, metric: Metric, lanes: LaneCount, dimensions: usize) -> Work {
        let norms = u64::from(metric == Metric::Angular);
        Work::of(self.candidates.len() as u64 + norms, metric, lanes, dimensions)
    }
}

/// The parameters of a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraphParameters {
    /// M: the maximum number of connections of a vector in each layer, doubled in the lowest; 2 to 255.
    pub connections: usize,
    /// The number of candidates kept while connecting a vector; 1 to 65,536.
    pub ef_construction: usize,
    /// The seed of the order of insertion.
    pub seed: u64,
}

impl Default for GraphParameters {
    /// 16 connections, 200 candidates.
    fn default() -> Self {
        Self { connections: 16, ef_construction: 200, seed: 1 }
    }
}

/// The maximum number of layers. A vector is in the second with probability 1/M, in the third with 1/M², and so on.
const LAYERS: usize = 16;

const EF_MAX: usize = 1 << 16;

impl<'v> Graph<'v> {
    /// Builds the graph on one thread. `progress` gets the number of inserted vectors.
    ///
    /// # Errors
    /// A parameter out of range; [`Stopped`](SearchError::Stopped).
    pub fn build(
        base: &'v Vectors,
        metric: Metric,
        lanes: LaneCount,
        parameters: &GraphParameters,
        progress: Progress,
    ) -> Result<Self, SearchError> {
        let GraphParameters { connections, ef_construction, seed } = *parameters;
        in_range("connections", connections, 2..=255, "2 to 255")?;
        in_range("ef_construction", ef_construction, 1..=EF_MAX, "1 to 65536")?;

        let distance = DatapathDistance::new(base, metric, lanes);
        let index = Hnsw::new(connections, base.len(), LAYERS, ef_construction, distance);
        let mut order: Vec<u32> = (0..base.len() as u32).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        for (done, &vector) in (1..).zip(&order) {
            index.insert_slice((&[Item::Base(vector)], vector as usize));
            if !progress(done) {
                return Err(SearchError::Stopped);
            }
        }
        // Each vector is the query of its insertion, so its norm takes a run in addition to the pairs.
        let norms = if metric == Metric::Angular { base.len() as u64 } else { 0 };
        let built = index.get_distance().work(index.get_distance().evaluations.load(Ordering::Relaxed) + norms);
        Ok(Self { index, built })
    }

    /// The work of the datapath to build the graph.
    pub fn build_work(&self) -> Work {
        self.built
    }

    /// Searches approximately the `count` nearest neighbours of each query on all threads of rayon. `ef`, at least
    /// `count`, is the number of candidates kept: more give better neighbours and take more time. A query can have
    /// fewer than `count` results if the graph is not connected. `progress` gets the number of completed queries.
    ///
    /// # Errors
    /// Queries of another dimension; a `count` that is not 1 to the size of the base; an `ef` that is not `count` to
    /// 65,536; [`Stopped`](SearchError::Stopped).
    pub fn search(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        progress: Progress,
    ) -> Result<SearchResults, SearchError> {
        let base = self.distance().base;
        check(base.dimensions(), base.len(), queries.dimensions(), count)?;
        in_ef_range(ef, count)?;
        let began = Instant::now();
        let (progress, evaluations) = (ProgressCounter::new(progress), AtomicU64::new(0));
        let one = |query: &[f32]| {
            if progress.is_stopped() {
                return Vec::new();
            }
            let query = Arc::new(self.distance().query(query, None));
            let row = self.row(&query, count, ef);
            evaluations.fetch_add(query.evaluations.load(Ordering::Relaxed), Ordering::Relaxed);
            progress.add(1);
            row
        };
        let rows = queries.data().par_chunks_exact(queries.dimensions()).map(one).collect();
        if progress.is_stopped() {
            return Err(SearchError::Stopped);
        }
        let work = self.distance().work(evaluations.into_inner());
        Ok(SearchResults { rows, work, seconds: began.elapsed().as_secs_f64() })
    }

    /// The trace of a search for the `count` nearest neighbours of one query.
    ///
    /// # Errors
    /// The errors of [`search`](Self::search), and an invalid query vector.
    pub fn trace(&self, query: &[f32], count: usize, ef: usize) -> Result<SearchTrace, SearchError> {
        let query = Vectors::new(query.len(), query.to_vec())?;
        let mut traces = self.traces(&query, count, ef, u64::MAX, &|_| true)?;
        Ok(traces.pop().unwrap_or_default())
    }

    /// The traces of the first queries, as many as have at most `beats` beats in total. `progress` gets the number of
    /// traces.
    ///
    /// # Errors
    /// The errors of [`search`](Self::search).
    pub fn traces(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        beats: u64,
        progress: Progress,
    ) -> Result<Vec<SearchTrace>, SearchError> {
        let DatapathDistance { base, metric, lanes, .. } = *self.distance();
        check(base.dimensions(), base.len(), queries.dimensions(), count)?;
        in_ef_range(ef, count)?;
        let (mut traces, mut left) = (Vec::new(), beats);
        for query in queries.iter() {
            let query = Arc::new(self.distance().query(query, Some(Mutex::default())));
            let found = self.row(&query, count, ef).iter().map(|near| near.index).collect();
            let candidates = query.candidates.as_ref().map(|list| std::mem::take(&mut *lock(list)));
            let trace = SearchTrace { candidates: candidates.unwrap_or_default(), found };
            match left.checked_sub(trace.work(metric, lanes, base.dimensions()).beats) {
                Some(rest) => left = rest,
                None => break,
            }
            traces.push(trace);
            if !progress(traces.len() as u64) {
                return Err(SearchError::Stopped);
            }
        }
        Ok(traces)
    }

    fn row(&self, query: &Arc<Query>, count: usize, ef: usize) -> Vec<Neighbour> {
        let found = self.index.search(&[Item::Query(query.clone())], count, ef);
        let mut row: Vec<Neighbour> = found
            .iter()
            .map(|near| {
                let index = near.d_id as u32;
                Neighbour { index, distance: self.distance().exactly(query, index) }
            })
            .collect();
        row.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
        row
    }

    fn distance(&self) -> &DatapathDistance<'v> {
        self.index.get_distance()
    }
}

impl fmt::Debug for Graph<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Graph").field("built", &self.built).finish_non_exhaustive()
    }
}

fn in_ef_range(ef: usize, count: usize) -> Result<(), SearchError> {
    in_range("ef", ef, count..=EF_MAX, "at least the number of neighbours and at most 65536")
}

fn in_range(
    name: &str,
    found: usize,
    range: std::ops::RangeInclusive<usize>,
    expected: &str,
) -> Result<(), SearchError> {
    let problem = || SearchError::Parameter(format!("{name} is {found}, expected {expected}"));
    if range.contains(&found) { Ok(()) } else { Err(problem()) }
}

#[derive(Clone)]
enum Item {
    Base(u32),
    Query(Arc<Query>),
}

struct Query {
    vector: Vec<f32>,
    norm: f32,
    evaluations: AtomicU64,
    /// The candidates in order, if they are recorded.
    candidates: Option<Mutex<Vec<u32>>>,
}

struct DatapathDistance<'v> {
    base: &'v Vectors,
    metric: Metric,
    lanes: LaneCount,
    /// The squared norms of the base for the angular metric.
    norms: Vec<f32>,
    /// The number of evaluated pairs of vectors of the base.
    evaluations: AtomicU64,
}

impl<'v> DatapathDistance<'v> {
    fn new(base: &'v Vectors, metric: Metric, lanes: LaneCount) -> Self {
        let norms = norms(base, metric, lanes);
        Self { base, metric, lanes, norms, evaluations: AtomicU64::new(0) }
    }

    /// A query, with its norm for the angular metric.
    fn query(&self, vector: &[f32], candidates: Option<Mutex<Vec<u32>>>) -> Query {
        let (norm, evaluations) = match self.metric {
            Metric::Euclidean => (0.0, 0),
            Metric::Angular => (kernel::norm(self.lanes, vector), 1),
        };
        Query { vector: vector.to_vec(), norm, evaluations: AtomicU64::new(evaluations), candidates }
    }

    fn vector(&self, index: u32) -> (&[f32], f32) {
        let norm = self.norms.get(index as usize).copied().unwrap_or(0.0);
        (self.base.get(index as usize).unwrap_or_default(), norm)
    }

    /// The distance between a query and a vector of the base, without counting it.
    fn exactly(&self, query: &Query, index: u32) -> f64 {
        let (candidate, norm) = self.vector(index);
        match self.metric {
            Metric::Euclidean => euclidean_distance(kernel::squared(self.lanes, &query.vector, candidate)),
            Metric::Angular => {
                cosine_distance(kernel::dot_product(self.lanes, &query.vector, candidate), query.norm, norm)
            }
        }
    }

    fn work(&self, evaluations: u64) -> Work {
        Work::of(evaluations, self.metric, self.lanes, self.base.dimensions())
    }
}

impl Distance<Item> for DatapathDistance<'_> {
    /// The squared Euclidean or the cosine distance in binary32; neither NaN nor negative.
    fn eval(&self, a: &[Item], b: &[Item]) -> f32 {
        let ([a], [Item::Base(candidate)]) = (a, b) else { return f32::INFINITY };
        let (query, query_norm) = match a {
            Item::Base(index) => {
                self.evaluations.fetch_add(1, Ordering::Relaxed);
                self.vector(*index)
            }
            Item::Query(query) => {
                query.evaluations.fetch_add(1, Ordering::Relaxed);
                if let Some(list) = &query.candidates {
                    lock(list).push(*candidate);
                }
                (&query.vector[..], query.norm)
            }
        };
        let (candidate, norm) = self.vector(*candidate);
        match self.metric {
            Metric::Euclidean => kernel::squared(self.lanes, query, candidate),
            Metric::Angular => {
                cosine_distance(kernel::dot_product(self.lanes, query, candidate), query_norm, norm) as f32
            }
        }
    }
}

fn lock(list: &Mutex<Vec<u32>>) -> MutexGuard<'_, Vec<u32>> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}
