//! Evaluation of the distance operations of `raypath_ops` for searches: one candidate in the order of their sums
//! ([`squared`], [`dot_product`]), or sixteen in parallel by the operations over [`Lanes`] ([`block`]).

use crate::vectors::Vectors;
use crate::{Metric, cosine_distance, euclidean_distance};
use raypath_model::{BLOCK, BlockSlice, BlockValue, Lanes, Packed, Simd, SimdKernels};
use raypath_ops::{Beat, BeatInput, Binary32, Circuit, Family, Flags, Kernels, Num, Operation, array_of};
pub(crate) use raypath_traversal::search::{dot_product, squared};

/// One coordinate of all candidates of a block.
pub(crate) type Lane = Num<Packed>;

/// Vectors in blocks of sixteen, coordinate by coordinate, with masked zeros up to a multiple of the lanes.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    lanes: Vec<Lane>,
    padded: usize,
}

impl Blocks {
    /// The blocks of `vectors`, padded to a multiple of `lanes`.
    pub(crate) fn new(vectors: &Vectors, lanes: usize) -> Self {
        let padded = vectors.dimensions().next_multiple_of(lanes);
        let mut blocks = Vec::with_capacity(vectors.len().div_ceil(BLOCK) * padded);
        for rows in vectors.data().chunks(BLOCK * vectors.dimensions()) {
            blocks.extend((0..padded).map(|coordinate| {
                let mut lane = [0.0; BLOCK];
                for (x, row) in lane.iter_mut().zip(rows.chunks_exact(vectors.dimensions())) {
                    *x = row.get(coordinate).copied().unwrap_or(0.0);
                }
                Num::new(Packed, BlockValue(lane))
            }));
        }
        Self { lanes: blocks, padded }
    }

    /// The blocks in tiles of `count`; the last may be shorter.
    pub(crate) fn tiles(&self, count: usize) -> std::slice::Chunks<'_, Lane> {
        self.lanes.chunks(count * self.padded)
    }

    /// The number of coordinates of a vector with padding.
    pub(crate) fn padded(&self) -> usize {
        self.padded
    }
}

#[inline(always)]
pub(crate) fn norm(vector: &[f32]) -> f32 {
    dot_product(vector, vector)
}

/// The squared norm of a query for the angular metric, 0 for the other.
pub(crate) fn query_norm(metric: Metric, query: &[f32]) -> f32 {
    match metric {
        Metric::Euclidean => 0.0,
        Metric::Angular => norm(query),
    }
}

/// The distance of a query and one candidate.
pub(crate) fn distance(metric: Metric, query: &[f32], candidate: &[f32]) -> f64 {
    match metric {
        Metric::Euclidean => euclidean_distance(squared(query, candidate)),
        Metric::Angular => {
            let dot = dot_product(query, candidate);
            cosine_distance(dot, norm(query), norm(candidate))
        }
    }
}

/// The sums, selected by `sum`, of a query and the candidates of a block. Both are padded to a multiple of `N`; the
/// first `dimensions` coordinates count.
#[inline(always)]
pub(crate) fn block<S: Simd, O: Operation<Input<Lanes<S>> = BeatInput<Lanes<S>, N>>, const N: usize>(
    simd: S,
    op: &O,
    zero: impl Fn(Lanes<S>) -> O::State<Lanes<S>>,
    sum: impl Fn(O::State<Lanes<S>>) -> Num<Lanes<S>>,
    query: &[f32],
    block: &[Lane],
    dimensions: usize,
) -> [f32; BLOCK] {
    let (queries, candidates) = (query.as_chunks::<N>().0, block.as_chunks::<N>().0);
    let whole = (dimensions / N).min(queries.len()).min(candidates.len());
    let ((queries, query_end), (candidates, candidate_end)) = (queries.split_at(whole), candidates.split_at(whole));
    let mut sums = Packed.zero();
    for first in (0..BLOCK).step_by(Lanes::<S>::COUNT) {
        let part = BlockSlice { lanes: Lanes::new(simd), first };
        let whole = queries.iter().zip(candidates).map(
            #[inline(always)]
            |(a, b)| registers(&part, a, b),
        );
        let end = match (query_end, candidate_end) {
            ([a, ..], [b, ..]) => Some(registers(&part, a, b)),
            _ => None,
        };
        let state = run(part.lanes, SimdKernels, op, zero(part.lanes), whole, end, dimensions % N);
        Num::<Binary32>::put(&sum(state), &mut sums, &part);
    }
    sums.value.0
}

/// The coordinates of a query, each in all lanes, and those of a part of the candidates.
#[inline(always)]
fn registers<S: Simd, const N: usize>(part: &BlockSlice<S>, a: &[f32; N], b: &[Lane; N]) -> [[Num<Lanes<S>>; N]; 2] {
    let lanes = part.lanes;
    [array_of!(i => Num::new(lanes, lanes.constant(a[i]))), <[Num<Binary32>; N]>::gather([b], part)]
}

/// Runs the beats of a pair of vectors from accumulators `state`: the whole beats, then `end` with `width` enabled
/// lanes, if present. No beat resets the accumulators, so the final state has the sums.
#[inline(always)]
fn run<C: Circuit, O: Operation<Input<C> = BeatInput<C, N>>, const N: usize>(
    c: C,
    kernels: impl Kernels<C>,
    op: &O,
    mut state: O::State<C>,
    whole: impl Iterator<Item = [[Num<C>; N]; 2]>,
    end: Option<[[Num<C>; N]; 2]>,
    width: usize,
) -> O::State<C> {
    let (all, reset_accum) = (Flags(array_of!(_ => c.bit(true))), c.bit(false));
    for [a, b] in whole {
        state = op.run_with(c, kernels, BeatInput { euclidean: Beat { a, b, mask: all, reset_accum } }, state).1;
    }
    if let Some([a, b]) = end {
        let mask = Flags(array_of!(i => c.bit(i < width)));
        state = op.run_with(c, kernels, BeatInput { euclidean: Beat { a, b, mask, reset_accum } }, state).1;
    }
    state
}
