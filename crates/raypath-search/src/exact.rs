use crate::answers::{Answers, Neighbour, Work};
use crate::error::SearchError;
use crate::kernel::{self, Blocks, Lane};
use crate::metric::{Metric, cosine_distance, euclidean_distance};
use crate::nearest::{Candidate, Nearest};
use crate::vectors::Vectors;
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use raypath_model::BLOCK;
use raypath_ops::{Angular, Euclidean, array_of};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Exact search: every query against every vector of the base, with the bits of [`Datapath`](crate::Datapath).
///
/// It holds a copy of the base, in the order in which it computes.
#[derive(Debug, Clone)]
pub struct Exact<const E: usize = 16, const A: usize = 8> {
    metric: Metric,
    level: Level,
    dimensions: usize,
    len: usize,
    blocks: Blocks,
    /// Squared norms of the base where the metric is angular. The datapath gives them along with every dot product; as
    /// they are the same for every query, they are computed once here.
    norms: Vec<f32>,
}

/// Bytes of the base that are searched for several queries before the next: half of a usual second-level cache.
const TILE: usize = 256 << 10;

/// The most queries that share a tile.
const GROUP: usize = 32;

impl<const E: usize, const A: usize> Exact<E, A> {
    /// Arranges the base for search, in the widest registers that this machine has.
    pub fn new(base: &Vectors, metric: Metric) -> Self {
        Self::at(Level::new(), base, metric)
    }

    /// The same with given instructions. They change the speed alone.
    pub fn at(level: Level, base: &Vectors, metric: Metric) -> Self {
        let (lanes, norms) = match metric {
            Metric::Euclidean => (E, Vec::new()),
            Metric::Angular => {
                let mut norms = norms::<A>(base);
                norms.resize(base.len().next_multiple_of(BLOCK), 0.0);
                (A, norms)
            }
        };
        Self { metric, level, dimensions: base.dimensions(), len: base.len(), blocks: Blocks::new(base, lanes), norms }
    }

    /// The `count` nearest of each query, on all of rayon's threads, whose number does not change the answer.
    ///
    /// `watch` is told now and then how many queries are done; where it answers false, the search stops.
    ///
    /// # Errors
    /// Queries of another dimension; a `count` that is not 1 to the size of the base;
    /// [`Stopped`](SearchError::Stopped).
    pub fn search(
        &self,
        queries: &Vectors,
        count: usize,
        watch: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Answers, SearchError> {
        check(self.dimensions, self.len, queries.dimensions(), count)?;
        let began = Instant::now();
        let (done, stopped) = (AtomicU64::new(0), AtomicBool::new(false));
        let go_on = |more: usize| {
            let done = done.fetch_add(more as u64, Ordering::Relaxed) + more as u64;
            if !watch(done) {
                stopped.store(true, Ordering::Relaxed);
            }
            !stopped.load(Ordering::Relaxed)
        };
        let group = queries.len().div_ceil(4 * rayon::current_num_threads()).clamp(1, GROUP);
        let rows: Vec<Vec<Neighbour>> = queries
            .data()
            .par_chunks(group * queries.dimensions())
            .flat_map_iter(|queries| self.group(queries, count, &go_on))
            .collect();
        if stopped.into_inner() {
            return Err(SearchError::Stopped);
        }
        Ok(Answers { rows, work: self.work(queries.len()), seconds: began.elapsed().as_secs_f64() })
    }

    /// What the datapath does for so many queries: each with every vector of the base, and angular with itself.
    pub fn work(&self, queries: usize) -> Work {
        let candidates = self.len as u64 + u64::from(self.metric == Metric::Angular);
        let evaluations = queries as u64 * candidates;
        Work::of::<E, A>(evaluations, self.metric, self.dimensions)
    }

    /// A few queries, tile by tile, as long as `go_on` says so.
    fn group(&self, queries: &[f32], count: usize, go_on: &impl Fn(usize) -> bool) -> Vec<Vec<Neighbour>> {
        let mut queries: Vec<Query> =
            queries.chunks_exact(self.dimensions).map(|query| self.query(query, count)).collect();
        let tile = (TILE / (self.blocks.padded() * size_of::<Lane>())).max(1);
        for (number, blocks) in self.blocks.tiles(tile).enumerate() {
            dispatch!(self.level, simd => self.tile(simd, &mut queries, number * tile * BLOCK, blocks));
            if !go_on(0) {
                return Vec::new();
            }
        }
        go_on(queries.len());
        queries.into_iter().map(|query| self.finish(query.nearest)).collect()
    }

    fn query(&self, query: &[f32], count: usize) -> Query {
        let norm = match self.metric {
            Metric::Euclidean => 0.0,
            Metric::Angular => kernel::norm::<A>(query),
        };
        let mut padded = query.to_vec();
        padded.resize(self.blocks.padded(), 0.0);
        Query { padded, norm, nearest: Nearest::new(count) }
    }

    /// Each query against each of some blocks, whose first candidate is number `first`.
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
                            &Euclidean::<E>,
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
                            &Angular::<A>,
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
        // Candidates come by rising index, so one as far as the farthest does not displace it.
        if query.nearest.bound().is_none_or(|bound| keys.iter().any(|&key| key < bound)) {
            for (index, &key) in (first..self.len).zip(&keys) {
                query.nearest.offer(Candidate { key, index: index as u32 });
            }
        }
    }

    fn finish(&self, nearest: Nearest) -> Vec<Neighbour> {
        let neighbours = nearest.into_sorted().into_iter();
        neighbours
            .map(|Candidate { key, index }| {
                let distance = match self.metric {
                    Metric::Euclidean => euclidean_distance(key as f32),
                    Metric::Angular => key,
                };
                Neighbour { index, distance }
            })
            .collect()
    }
}

/// A query on its way through the base.
struct Query {
    padded: Vec<f32>,
    norm: f32,
    nearest: Nearest,
}

/// Whether queries of so many dimensions can be asked for so many neighbours.
pub(crate) fn check(dimensions: usize, len: usize, queries: usize, count: usize) -> Result<(), SearchError> {
    if queries != dimensions {
        return Err(SearchError::Dimensions { base: dimensions, queries });
    }
    if !(1..=len).contains(&count) {
        return Err(SearchError::Neighbours { asked: count, there: len });
    }
    Ok(())
}

/// The squared norm of each vector, as the datapath gives it.
pub(crate) fn norms<const A: usize>(vectors: &Vectors) -> Vec<f32> {
    let rows = vectors.data().par_chunks(vectors.dimensions());
    rows.map(kernel::norm::<A>).collect()
}
