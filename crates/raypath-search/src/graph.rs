use crate::exact::{check, norms};
use crate::hnsw::{Hnsw, Scratch};
use crate::{
    LaneCount, Layer, Metric, Neighbour, SearchError, SearchResults, Vectors, Work, cosine_distance,
    euclidean_distance, kernel,
};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use raypath_model::{Level, dispatch};
use raypath_timing::{Progress, ProgressCounter};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Approximate search, with the distances of the datapath, through a graph (Malkov and Yashunin, *Efficient and robust
/// approximate nearest neighbor search using Hierarchical Navigable Small World graphs*, 2018).
///
/// Vectors are inserted one after another, so equal bases, parameters and seeds give equal graphs, on any machine and
/// with any number of threads.
#[derive(Debug)]
pub struct Graph<'v> {
    graph: Hnsw,
    distances: Distances<'v>,
    built: Work,
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

        let distances = Distances::new(base, metric, lanes);
        let (mut random, mut graph) = (ChaCha8Rng::seed_from_u64(seed), Hnsw::new(base.len(), connections));
        let mut order: Vec<u32> = (0..base.len() as u32).collect();
        order.shuffle(&mut random);
        let evaluations = Cell::new(0);
        let distance = |a: u32, b: u32| {
            evaluations.set(evaluations.get() + 1);
            let (vector, norm) = distances.vector(a);
            distances.eval(vector, norm, b)
        };
        for (done, &vector) in (1..).zip(&order) {
            dispatch!(distances.level, _simd => graph.insert(vector, ef_construction, &mut random, &distance));
            if !progress(done) {
                return Err(SearchError::Stopped);
            }
        }
        // Each vector is the query of its insertion, so its norm takes a run in addition to the pairs.
        let norms = if metric == Metric::Angular { base.len() as u64 } else { 0 };
        let built = distances.work(evaluations.get() + norms);
        Ok(Self { graph, distances, built })
    }

    /// The work of the datapath to build the graph.
    pub fn build_work(&self) -> Work {
        self.built
    }

    /// The lowest layer.
    ///
    /// # Errors
    /// A graph without vectors.
    pub fn lowest_layer(&self) -> Result<Layer, SearchError> {
        let (degree, neighbours, entry) = self.graph.lowest_layer();
        Layer::new(degree, neighbours, entry)
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
        let base = self.distances.base;
        check(base.dimensions(), base.len(), queries.dimensions(), count)?;
        in_ef_range(ef, count)?;
        let began = Instant::now();
        let (progress, evaluations) = (ProgressCounter::new(progress), AtomicU64::new(0));
        let one = |scratch: &mut Scratch, query: &[f32]| {
            if progress.is_stopped() {
                return Vec::new();
            }
            let (row, own) = self.row(query, count, ef, scratch);
            evaluations.fetch_add(own, Ordering::Relaxed);
            progress.add(1);
            row
        };
        let queries = queries.data().par_chunks_exact(queries.dimensions());
        let rows = queries.map_init(|| Scratch::new(base.len()), one).collect();
        if progress.is_stopped() {
            return Err(SearchError::Stopped);
        }
        let work = self.distances.work(evaluations.into_inner());
        Ok(SearchResults { rows, work, seconds: began.elapsed().as_secs_f64() })
    }

    /// The neighbours of a query, and the number of distances that were computed.
    fn row(&self, query: &[f32], count: usize, ef: usize, scratch: &mut Scratch) -> (Vec<Neighbour>, u64) {
        let norm = kernel::query_norm(self.distances.metric, self.distances.lanes, query);
        let mut evaluations = self.distances.norm_evaluations();
        let mut distance = |candidate| {
            evaluations += 1;
            self.distances.eval(query, norm, candidate)
        };
        let found = dispatch!(self.distances.level, _simd => self.graph.search(ef, scratch, &mut distance));
        let exactly = |index| Neighbour { index, distance: self.distances.exactly(query, norm, index) };
        let mut row: Vec<Neighbour> = found.iter().take(count).map(|near| exactly(near.item())).collect();
        row.sort();
        (row, evaluations)
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

/// The distances of a base, as the datapath computes them.
#[derive(Debug)]
struct Distances<'v> {
    base: &'v Vectors,
    metric: Metric,
    lanes: LaneCount,
    level: Level,
    /// The squared norms of the base for the angular metric.
    norms: Vec<f32>,
}

impl<'v> Distances<'v> {
    fn new(base: &'v Vectors, metric: Metric, lanes: LaneCount) -> Self {
        Self { base, metric, lanes, level: Level::new(), norms: norms(base, metric, lanes) }
    }

    /// The runs of the datapath for the norm of a query.
    fn norm_evaluations(&self) -> u64 {
        u64::from(self.metric == Metric::Angular)
    }

    /// A vector of the base, and its squared norm.
    #[inline(always)]
    fn vector(&self, index: u32) -> (&[f32], f32) {
        let norm = self.norms.get(index as usize).copied().unwrap_or(0.0);
        (self.base.get(index as usize).unwrap_or_default(), norm)
    }

    /// The squared Euclidean or the cosine distance in binary32; neither NaN nor negative. Call it inside
    /// [`dispatch`].
    #[inline(always)]
    fn eval(&self, query: &[f32], query_norm: f32, index: u32) -> f32 {
        let ((candidate, norm), lanes) = (self.vector(index), self.lanes);
        match self.metric {
            Metric::Euclidean => kernel::squared(lanes, query, candidate),
            Metric::Angular => cosine_distance(kernel::dot_product(lanes, query, candidate), query_norm, norm) as f32,
        }
    }

    /// The distance between a query and a vector of the base.
    fn exactly(&self, query: &[f32], query_norm: f32, index: u32) -> f64 {
        let (candidate, norm) = self.vector(index);
        match self.metric {
            Metric::Euclidean => euclidean_distance(kernel::squared(self.lanes, query, candidate)),
            Metric::Angular => cosine_distance(kernel::dot_product(self.lanes, query, candidate), query_norm, norm),
        }
    }

    fn work(&self, evaluations: u64) -> Work {
        Work::of(evaluations, self.metric, self.lanes, self.base.dimensions())
    }
}
