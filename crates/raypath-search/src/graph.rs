use crate::answers::{Answers, Neighbour, Work};
use crate::error::SearchError;
use crate::exact::{check, norms};
use crate::kernel;
use crate::metric::{Metric, cosine_distance, euclidean_distance};
use crate::vectors::Vectors;
use hnsw_rs::prelude::{Distance, Hnsw};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Approximate search through a hierarchical navigable small world (Malkov and Yashunin, *Efficient and robust approximate
/// nearest neighbor search using Hierarchical Navigable Small World graphs*, 2018), with the datapath's distances.
///
/// The graph is that of the crate `hnsw_rs`. Vectors are inserted one after another, so it is the same for the same base,
/// parameters and seed, on any machine and with any number of threads.
pub struct Graph<'v, const E: usize = 16, const A: usize = 8> {
    index: Hnsw<'static, Item, Beats<'v, E, A>>,
    built: Work,
}

/// What a search through a graph did for one query: what a [`Walk`](crate::Walk) replays.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Log {
    /// The vectors of the base that it asked the datapath about, in order. One may come again, as the layers of the graph
    /// do not know of each other.
    pub candidates: Vec<u32>,
    /// Those of them that it answered, nearest first. They are not always the nearest of all candidates: what is seen in
    /// a higher layer counts for finding the way only.
    pub found: Vec<u32>,
}

impl Log {
    /// What it costs with vectors of so many dimensions; angular the query's own norm is part of it.
    pub fn work<const E: usize, const A: usize>(&self, metric: Metric, dimensions: usize) -> Work {
        let norms = u64::from(metric == Metric::Angular);
        Work::of::<E, A>(self.candidates.len() as u64 + norms, metric, dimensions)
    }
}

/// What a graph is built with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraphParameters {
    /// M: the most connections of a vector in each layer, twice as many in the lowest. 2 to 255.
    pub connections: usize,
    /// Candidates that are kept while a vector finds its connections. 1 to 65,536.
    pub ef_construction: usize,
    /// What the order of insertion follows from.
    pub seed: u64,
}

impl Default for GraphParameters {
    /// 16 connections, 200 candidates.
    fn default() -> Self {
        Self { connections: 16, ef_construction: 200, seed: 1 }
    }
}

/// The most layers; a vector is in the second with probability 1/M, in the third with 1/M², and so on.
const LAYERS: usize = 16;

/// The greatest ef.
const EF_MAX: usize = 1 << 16;

impl<'v, const E: usize, const A: usize> Graph<'v, E, A> {
    /// Builds the graph, on one thread. `watch` is told how many vectors are in; where it answers false, the work stops.
    ///
    /// # Errors
    /// A parameter out of its range; [`Stopped`](SearchError::Stopped).
    pub fn build(
        base: &'v Vectors,
        metric: Metric,
        parameters: &GraphParameters,
        watch: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Self, SearchError> {
        let GraphParameters { connections, ef_construction, seed } = *parameters;
        in_range("connections", connections, 2..=255, "2 to 255")?;
        in_range("ef_construction", ef_construction, 1..=EF_MAX, "1 to 65536")?;

        let distance = Beats::<E, A>::new(base, metric);
        let index = Hnsw::new(connections, base.len(), LAYERS, ef_construction, distance);
        let mut order: Vec<u32> = (0..base.len() as u32).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        for (done, &vector) in (1..).zip(&order) {
            index.insert_slice((&[Item::Base(vector)], vector as usize));
            if !watch(done) {
                return Err(SearchError::Stopped);
            }
        }
        // Besides the pairs, each vector's norm takes a run of its own: it is the query of its insertion.
        let norms = if metric == Metric::Angular { base.len() as u64 } else { 0 };
        let built = index.get_distance().work(index.get_distance().evaluations.load(Ordering::Relaxed) + norms);
        Ok(Self { index, built })
    }

    /// What the datapath did to build it.
    pub fn build_work(&self) -> Work {
        self.built
    }

    /// About the `count` nearest of each query, on all of rayon's threads. `ef`, at least `count`, is how many candidates
    /// are kept: more find better neighbours in more time. A row is shorter than `count` where the graph does not lead on.
    ///
    /// `watch` is told how many queries are done; where it answers false, the search stops.
    ///
    /// # Errors
    /// Queries of another dimension; a `count` that is not 1 to the size of the base; an `ef` that is not `count` to
    /// 65,536; [`Stopped`](SearchError::Stopped).
    pub fn search(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        watch: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Answers, SearchError> {
        let base = self.distance().base;
        check(base.dimensions(), base.len(), queries.dimensions(), count)?;
        in_ef_range(ef, count)?;
        let began = Instant::now();
        let (done, stopped, evaluations) = (AtomicU64::new(0), AtomicBool::new(false), AtomicU64::new(0));
        let one = |query: &[f32]| {
            if stopped.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let query = Arc::new(self.distance().query(query, None));
            let row = self.row(&query, count, ef);
            evaluations.fetch_add(query.evaluations.load(Ordering::Relaxed), Ordering::Relaxed);
            if !watch(done.fetch_add(1, Ordering::Relaxed) + 1) {
                stopped.store(true, Ordering::Relaxed);
            }
            row
        };
        let rows = queries.data().par_chunks_exact(queries.dimensions()).map(one).collect();
        if stopped.into_inner() {
            return Err(SearchError::Stopped);
        }
        let work = self.distance().work(evaluations.into_inner());
        Ok(Answers { rows, work, seconds: began.elapsed().as_secs_f64() })
    }

    /// What a search for one query's `count` nearest does.
    ///
    /// # Errors
    /// As those of [`search`](Self::search); a query that is no vector.
    pub fn log(&self, query: &[f32], count: usize, ef: usize) -> Result<Log, SearchError> {
        let query = Vectors::new(query.len(), query.to_vec())?;
        let mut logs = self.logs(&query, count, ef, u64::MAX, &|_| true)?;
        Ok(logs.pop().unwrap_or_default())
    }

    /// The logs of the first queries: as many as have, together, at most `beats` beats. `watch` is told how many there
    /// are; where it answers false, the work stops.
    ///
    /// # Errors
    /// As those of [`search`](Self::search).
    pub fn logs(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        beats: u64,
        watch: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Vec<Log>, SearchError> {
        let Beats { base, metric, .. } = *self.distance();
        check(base.dimensions(), base.len(), queries.dimensions(), count)?;
        in_ef_range(ef, count)?;
        let (mut logs, mut left) = (Vec::new(), beats);
        for query in queries.iter() {
            let query = Arc::new(self.distance().query(query, Some(Mutex::default())));
            let found = self.row(&query, count, ef).iter().map(|near| near.index).collect();
            let candidates = query.log.as_ref().map(|log| std::mem::take(&mut *candidates_of(log)));
            let log = Log { candidates: candidates.unwrap_or_default(), found };
            match left.checked_sub(log.work::<E, A>(metric, base.dimensions()).beats) {
                Some(rest) => left = rest,
                None => break,
            }
            logs.push(log);
            if !watch(logs.len() as u64) {
                return Err(SearchError::Stopped);
            }
        }
        Ok(logs)
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

    fn distance(&self) -> &Beats<'v, E, A> {
        self.index.get_distance()
    }
}

impl<const E: usize, const A: usize> fmt::Debug for Graph<'_, E, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Graph").field("built", &self.built).finish_non_exhaustive()
    }
}

fn in_ef_range(ef: usize, count: usize) -> Result<(), SearchError> {
    in_range("ef", ef, count..=EF_MAX, "as many as neighbours asked for, to 65536")
}

fn in_range(
    name: &'static str,
    found: usize,
    range: std::ops::RangeInclusive<usize>,
    expected: &'static str,
) -> Result<(), SearchError> {
    if range.contains(&found) { Ok(()) } else { Err(SearchError::Parameter { name, found, expected }) }
}

/// What the graph holds: a name of a vector instead of the vector.
#[derive(Clone)]
enum Item {
    Base(u32),
    Query(Arc<Query>),
}

struct Query {
    vector: Vec<f32>,
    norm: f32,
    evaluations: AtomicU64,
    /// The candidates in order, where they are asked for.
    log: Option<Mutex<Vec<u32>>>,
}

/// The distance that the graph is given.
struct Beats<'v, const E: usize, const A: usize> {
    base: &'v Vectors,
    metric: Metric,
    /// Squared norms of the base where the metric is angular.
    norms: Vec<f32>,
    /// Pairs of vectors of the base that were evaluated.
    evaluations: AtomicU64,
}

impl<'v, const E: usize, const A: usize> Beats<'v, E, A> {
    fn new(base: &'v Vectors, metric: Metric) -> Self {
        let norms = if metric == Metric::Angular { norms::<A>(base) } else { Vec::new() };
        Self { base, metric, norms, evaluations: AtomicU64::new(0) }
    }

    /// A query; angular it goes through the datapath once to have its norm.
    fn query(&self, vector: &[f32], log: Option<Mutex<Vec<u32>>>) -> Query {
        let (norm, evaluations) = match self.metric {
            Metric::Euclidean => (0.0, 0),
            Metric::Angular => (kernel::norm::<A>(vector), 1),
        };
        Query { vector: vector.to_vec(), norm, evaluations: AtomicU64::new(evaluations), log }
    }

    fn vector(&self, index: u32) -> (&[f32], f32) {
        let norm = self.norms.get(index as usize).copied().unwrap_or(0.0);
        (self.base.get(index as usize).unwrap_or_default(), norm)
    }

    /// The distance between a query and a vector of the base, uncounted.
    fn exactly(&self, query: &Query, index: u32) -> f64 {
        let (candidate, norm) = self.vector(index);
        match self.metric {
            Metric::Euclidean => euclidean_distance(kernel::squared::<E>(&query.vector, candidate)),
            Metric::Angular => cosine_distance(kernel::dot_product::<A>(&query.vector, candidate), query.norm, norm),
        }
    }

    fn work(&self, evaluations: u64) -> Work {
        Work::of::<E, A>(evaluations, self.metric, self.base.dimensions())
    }
}

impl<const E: usize, const A: usize> Distance<Item> for Beats<'_, E, A> {
    /// Squared Euclidean or cosine distance, in binary32 as the graph wants it; never a NaN, never negative.
    fn eval(&self, a: &[Item], b: &[Item]) -> f32 {
        let ([a], [Item::Base(candidate)]) = (a, b) else { return f32::INFINITY };
        let (query, query_norm) = match a {
            Item::Base(index) => {
                self.evaluations.fetch_add(1, Ordering::Relaxed);
                self.vector(*index)
            }
            Item::Query(query) => {
                query.evaluations.fetch_add(1, Ordering::Relaxed);
                if let Some(log) = &query.log {
                    candidates_of(log).push(*candidate);
                }
                (&query.vector[..], query.norm)
            }
        };
        let (candidate, norm) = self.vector(*candidate);
        match self.metric {
            Metric::Euclidean => kernel::squared::<E>(query, candidate),
            Metric::Angular => cosine_distance(kernel::dot_product::<A>(query, candidate), query_norm, norm) as f32,
        }
    }
}

fn candidates_of(log: &Mutex<Vec<u32>>) -> MutexGuard<'_, Vec<u32>> {
    log.lock().unwrap_or_else(PoisonError::into_inner)
}
