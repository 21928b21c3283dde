use crate::exact::norms;
use crate::hnsw::Hnsw;
use crate::{Layer, Metric, SearchError, Vectors, Work, cosine_distance, kernel};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_model::{Level, dispatch};
use raypath_timing::Progress;
use std::cell::Cell;

/// The parameters of a graph (Malkov and Yashunin, *Efficient and robust approximate nearest neighbor search using
/// Hierarchical Navigable Small World graphs*, 2018).
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

impl Layer {
    /// The lowest layer of a graph that is built with the distances of the datapath, and the work to build it. Vectors
    /// are inserted one after another, so equal bases, parameters and seeds give equal graphs, on any machine.
    /// `progress` gets the number of inserted vectors.
    ///
    /// # Errors
    /// A parameter out of range; [`Stopped`](SearchError::Stopped).
    pub fn build(
        base: &Vectors,
        metric: Metric,
        parameters: &GraphParameters,
        progress: Progress,
    ) -> Result<(Self, Work), SearchError> {
        let GraphParameters { connections, ef_construction, seed } = *parameters;
        in_range("connections", connections, 2, 255)?;
        in_range("ef_construction", ef_construction, 1, 65_536)?;

        let norms = norms(base, metric);
        let vector = |index: u32| base.get(index as usize).unwrap_or_default();
        let norm = |index: u32| norms.get(index as usize).copied().unwrap_or(0.0);
        let (mut random, mut graph) = (ChaCha8Rng::seed_from_u64(seed), Hnsw::new(base.len(), connections));
        let mut order: Vec<u32> = (0..base.len() as u32).collect();
        order.shuffle(&mut random);
        let evaluations = Cell::new(0);
        // Neither NaN nor negative.
        let distance = |a: u32, b: u32| {
            evaluations.set(evaluations.get() + 1);
            match metric {
                Metric::Euclidean => kernel::squared(vector(a), vector(b)),
                Metric::Angular => cosine_distance(kernel::dot_product(vector(a), vector(b)), norm(a), norm(b)) as f32,
            }
        };
        let level = Level::new();
        for (done, &vector) in (1..).zip(&order) {
            dispatch!(level, _simd => graph.insert(vector, ef_construction, &mut random, &distance));
            if !progress(done) {
                return Err(SearchError::Stopped);
            }
        }
        // Each vector is the query of its insertion, so its norm takes a run in addition to the pairs.
        let of_norms = if metric == Metric::Angular { base.len() as u64 } else { 0 };
        let work = Work::of(evaluations.get() + of_norms, metric, base.dimensions());
        let (degree, neighbours, entry) = graph.lowest_layer();
        Ok((Self::new(degree, neighbours, entry)?, work))
    }
}

fn in_range(name: &str, found: usize, least: usize, most: usize) -> Result<(), SearchError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(SearchError::Parameter(format!("{name} is {found}, expected {least} to {most}")))
}
