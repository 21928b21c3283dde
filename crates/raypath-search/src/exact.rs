use crate::kernel::{self, Blocks, Lane};
use crate::metric::LANES;
use crate::results::Nearest;
use crate::{Metric, Neighbour, SearchError, SearchResults, Vectors, Work, cosine_distance, euclidean_distance};
use rayon::prelude::*;
use raypath_model::{BLOCK, Level, Simd, dispatch};
use raypath_ops::{Angular, AngularState, Euclidean, EuclideanState, Rounding, array_of};
use raypath_timing::{Progress, ProgressCounter};
use std::time::Instant;

/// Exact search: it compares every query with every vector of the base, with the bits of the datapath's operations.
///
/// It holds a copy of the base in a layout for SIMD.
#[derive(Debug, Clone)]
pub struct Exact {
    metric: Metric,
    level: Level,
    dimensions: usize,
    len: usize,
    blocks: Blocks,
    /// The squared norms of the base for the angular metric. The datapath computes them with every dot product; here
    /// they are computed once, because they are the same for every query.
    norms: Vec<f32>,
}

/// The size of a tile of the base in bytes, half of a typical second-level cache. A group of queries shares a tile.
const TILE: usize = 256 << 10;

/// The maximum number of queries that share a tile.
const GROUP: usize = 32;

impl Exact {
    /// Prepares a base for search with the widest SIMD registers of the machine.
    pub fn new(base: &Vectors, metric: Metric) -> Self {
        Self::at(Level::new(), base, metric)
    }

    /// Prepares a base for search with the given SIMD instructions, which affect speed only.
    pub fn at(level: Level, base: &Vectors, metric: Metric) -> Self {
        let mut norms = norms(base, metric);
        norms.resize(norms.len().next_multiple_of(BLOCK), 0.0);
        let blocks = Blocks::new(base, metric.lanes());
        Self { metric, level, dimensions: base.dimensions(), len: base.len(), blocks, norms }
    }

    /// Searches the `count` nearest neighbours of each query on all threads of rayon. The result does not depend on the
    /// number of threads. `progress` gets the number of completed queries.
    ///
    /// # Errors
    /// Queries of another dimension; a `count` that is not 1 to the size of the base;
    /// [`Stopped`](SearchError::Stopped).
    pub fn search(&self, queries: &Vectors, count: usize, progress: Progress) -> Result<SearchResults, SearchError> {
        check(self.dimensions, self.len, queries.dimensions(), count)?;
        let began = Instant::now();
        let progress = ProgressCounter::new(progress);
        let group = queries.len().div_ceil(4 * rayon::current_num_threads()).clamp(1, GROUP);
        let rows: Vec<Vec<Neighbour>> = queries
            .data()
            .par_chunks(group * queries.dimensions())
            .flat_map_iter(|queries| self.group(queries, count, &progress))
            .collect();
        if progress.is_stopped() {
            return Err(SearchError::Stopped);
        }
        Ok(SearchResults { rows, work: self.work(queries.len()), seconds: began.elapsed().as_secs_f64() })
    }

    /// Measures the distances per second of a search on `threads` threads for the 10 nearest neighbours, or for all
    /// vectors if there are fewer.
    ///
    /// # Errors
    /// The errors of [`search`](Self::search); threads that the system cannot start.
    pub fn distances_per_second(&self, queries: &Vectors, threads: usize) -> Result<f64, SearchError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| SearchError::Parameter(format!("{threads} threads: {error}")))?;
        let results = pool.install(|| self.search(queries, self.len.min(10), &|_| true))?;
        Ok(results.work.evaluations as f64 / results.seconds)
    }

    /// The work of the datapath for a number of queries, each also compared with itself for the angular metric.
    pub fn work(&self, queries: usize) -> Work {
        let candidates = self.len as u64 + u64::from(self.metric == Metric::Angular);
        let evaluations = queries as u64 * candidates;
        Work::of(evaluations, self.metric, self.dimensions)
    }

    fn group(&self, queries: &[f32], count: usize, progress: &ProgressCounter) -> Vec<Vec<Neighbour>> {
        let mut queries: Vec<Query> =
            queries.chunks_exact(self.dimensions).map(|query| self.query(query, count)).collect();
        let tile = (TILE / (self.blocks.padded() * size_of::<Lane>())).max(1);
        for (number, blocks) in self.blocks.tiles(tile).enumerate() {
            let first = number * tile * BLOCK;
            dispatch!(self.level, simd => self.tile(simd, &mut queries, first, blocks));
            if !progress.add(0) {
                return Vec::new();
            }
        }
        progress.add(queries.len() as u64);
        queries.into_iter().map(|query| self.finish(query.nearest)).collect()
    }

    fn query(&self, query: &[f32], count: usize) -> Query {
        let norm = kernel::query_norm(self.metric, query);
        let mut padded = query.to_vec();
        padded.resize(self.blocks.padded(), 0.0);
        Query { padded, norm, nearest: Nearest::new(count) }
    }

    /// Compares each query with each of the blocks, whose first candidate has index `first`.
    #[inline(always)]
    fn tile<S: Simd>(&self, simd: S, queries: &mut [Query], first: usize, blocks: &[Lane]) {
        let firsts = || (first..).step_by(BLOCK);
        for query in queries {
            let blocks = firsts().zip(blocks.chunks_exact(self.blocks.padded()));
            match self.metric {
                Metric::Euclidean => {
                    for (first, block) in blocks {
                        let squared = kernel::block(
                            simd,
                            &Euclidean::<LANES> { rounding: Rounding::Unit },
                            EuclideanState::zero,
                            |sums| sums.accumulator,
                            &query.padded,
                            block,
                            self.dimensions,
                        );
                        self.offer(query, first, squared.map(f64::from));
                    }
                }
                Metric::Angular => {
                    for ((first, block), norms) in blocks.zip(self.norms[first..].as_chunks::<BLOCK>().0) {
                        let dots = kernel::block(
                            simd,
                            &Angular::<{ LANES / 2 }> { rounding: Rounding::Unit },
                            AngularState::zero,
                            |sums| sums.dot_product,
                            &query.padded,
                            block,
                            self.dimensions,
                        );
                        let keys = array_of!(i => cosine_distance(dots[i], query.norm, norms[i]));
                        self.offer(query, first, keys);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn offer(&self, query: &mut Query, first: usize, keys: [f64; BLOCK]) {
        // Candidates come in ascending order of index, so one at the distance of the farthest does not displace it.
        if query.nearest.bound().is_none_or(|bound| keys.iter().any(|&key| key < bound)) {
            for (index, &key) in (first..self.len).zip(&keys) {
                query.nearest.offer(Neighbour { index: index as u32, distance: key });
            }
        }
    }

    fn finish(&self, nearest: Nearest) -> Vec<Neighbour> {
        let mut neighbours = nearest.into_sorted();
        if self.metric == Metric::Euclidean {
            neighbours.iter_mut().for_each(|near| near.distance = euclidean_distance(near.distance as f32));
        }
        neighbours
    }
}

struct Query {
    padded: Vec<f32>,
    norm: f32,
    nearest: Nearest,
}

/// Checks the dimension of queries and the number of neighbours.
pub(crate) fn check(dimensions: usize, len: usize, queries: usize, count: usize) -> Result<(), SearchError> {
    if queries != dimensions {
        return Err(SearchError::Dimensions { base: dimensions, queries });
    }
    if !(1..=len).contains(&count) {
        return Err(SearchError::Neighbours { requested: count, available: len });
    }
    Ok(())
}

/// The squared norm of each vector for the angular metric, with the bits of the datapath; none for the other.
pub(crate) fn norms(vectors: &Vectors, metric: Metric) -> Vec<f32> {
    match metric {
        Metric::Euclidean => Vec::new(),
        Metric::Angular => {
            let rows = vectors.data().par_chunks(vectors.dimensions());
            rows.map(kernel::norm).collect()
        }
    }
}
