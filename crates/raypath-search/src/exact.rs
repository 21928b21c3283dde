use crate::answers::{Answers, Neighbour, Work};
use crate::error::SearchError;
use crate::kernel::{self, Blocks, WIDTH};
use crate::metric::{Metric, cosine_distance, euclidean_distance};
use crate::nearest::{Candidate, Nearest};
use crate::vectors::Vectors;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Exact search: every query against every vector of the base, with the bits of [`Datapath`](crate::Datapath).
///
/// It holds a copy of the base, in the order in which it computes.
#[derive(Debug, Clone)]
pub struct Exact<const E: usize = 16, const A: usize = 8> {
    metric: Metric,
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
    /// Arranges the base for search.
    pub fn new(base: &Vectors, metric: Metric) -> Self {
        let (lanes, norms) = match metric {
            Metric::Euclidean => (E, Vec::new()),
            Metric::Angular => (A, norms::<A>(base)),
        };
        Self { metric, dimensions: base.dimensions(), len: base.len(), blocks: Blocks::new(base, lanes), norms }
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
        check(self.dimensions, self.len, queries, count)?;
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
        Work { evaluations, beats: evaluations * self.metric.beats::<E, A>(self.dimensions) }
    }

    /// A few queries, tile by tile, as long as `go_on` says so.
    fn group(&self, queries: &[f32], count: usize, go_on: &impl Fn(usize) -> bool) -> Vec<Vec<Neighbour>> {
        let mut queries: Vec<Query> =
            queries.chunks_exact(self.dimensions).map(|query| self.query(query, count)).collect();
        let tile = (TILE / (self.blocks.padded() * size_of::<kernel::Lane>())).max(1);
        let mut first = 0;
        let mut blocks = self.blocks.iter().peekable();
        while blocks.peek().is_some() {
            let tile = blocks.by_ref().take(tile).collect::<Vec<_>>();
            for query in &mut queries {
                for (index, block) in tile.iter().enumerate() {
                    self.block(query, first + index * WIDTH, block);
                }
            }
            first += tile.len() * WIDTH;
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
            Metric::Angular => kernel::pair::<A>(query, query, kernel::product),
        };
        let mut padded = query.to_vec();
        padded.resize(self.blocks.padded(), 0.0);
        Query { padded, norm, nearest: Nearest::new(count) }
    }

    /// One query against one block, whose first candidate is number `first`.
    #[inline]
    fn block(&self, query: &mut Query, first: usize, block: &[kernel::Lane]) {
        let there = WIDTH.min(self.len - first);
        let keys: [f64; WIDTH] = match self.metric {
            Metric::Euclidean => kernel::block::<E>(&query.padded, block, kernel::squared).map(f64::from),
            Metric::Angular => {
                let norms = &self.norms[first..first + there];
                let dots = kernel::block::<A>(&query.padded, block, kernel::product);
                std::array::from_fn(|i| {
                    cosine_distance(dots[i], query.norm, norms.get(i).copied().unwrap_or(f32::INFINITY))
                })
            }
        };
        // Candidates come by rising index, so one as far as the farthest does not displace it.
        if query.nearest.bound().is_none_or(|bound| keys.iter().any(|&key| key < bound)) {
            for (index, &key) in (first..).zip(&keys[..there]) {
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

/// Whether these queries can be asked for so many neighbours.
pub(crate) fn check(dimensions: usize, len: usize, queries: &Vectors, count: usize) -> Result<(), SearchError> {
    if queries.dimensions() != dimensions {
        return Err(SearchError::Dimensions { base: dimensions, queries: queries.dimensions() });
    }
    if !(1..=len).contains(&count) {
        return Err(SearchError::Neighbours { asked: count, there: len });
    }
    Ok(())
}

/// The squared norm of each vector, as the datapath gives it.
pub(crate) fn norms<const A: usize>(vectors: &Vectors) -> Vec<f32> {
    let rows = vectors.data().par_chunks(vectors.dimensions());
    rows.map(|row| kernel::pair::<A>(row, row, kernel::product)).collect()
}
