//! The operations, fast: over one candidate ([`pair`]), and over sixteen at once ([`block`]). All that knows how candidates
//! lie in memory and what computes on them is here. The order of the sums is that of `raypath_ops::Euclidean` and
//! `raypath_ops::Angular`: in a beat lane i takes in lane i + half, then the accumulator takes in the beat.

use crate::vectors::Vectors;

/// Candidates in a block.
pub(crate) const WIDTH: usize = 16;

/// A coordinate of each candidate in a block.
pub(crate) type Lane = [f32; WIDTH];

/// Vectors in blocks of [`WIDTH`], coordinate by coordinate. Coordinates beyond a vector's end, up to a multiple of the
/// lanes, are zero in base and query: they contribute +0.0, as lanes that are masked off do.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    lanes: Vec<Lane>,
    padded: usize,
}

impl Blocks {
    /// The vectors, with coordinates up to a multiple of `lanes`.
    pub(crate) fn new(vectors: &Vectors, lanes: usize) -> Self {
        let padded = vectors.dimensions().next_multiple_of(lanes);
        let mut blocks = vec![[0.0; WIDTH]; vectors.len().div_ceil(WIDTH) * padded];
        let rows = vectors.data().chunks(WIDTH * vectors.dimensions());
        for (block, rows) in blocks.chunks_exact_mut(padded).zip(rows) {
            for (candidate, row) in rows.chunks_exact(vectors.dimensions()).enumerate() {
                for (lane, &x) in block.iter_mut().zip(row) {
                    lane[candidate] = x;
                }
            }
        }
        Self { lanes: blocks, padded }
    }

    /// Block after block.
    pub(crate) fn iter(&self) -> std::slice::ChunksExact<'_, Lane> {
        self.lanes.chunks_exact(self.padded)
    }

    /// Coordinates of a vector with those beyond its end.
    pub(crate) fn padded(&self) -> usize {
        self.padded
    }
}

/// The term of a squared Euclidean distance.
#[inline(always)]
pub(crate) fn squared(a: f32, b: f32) -> f32 {
    (a - b) * (a - b)
}

/// The term of a dot product.
#[inline(always)]
pub(crate) fn product(a: f32, b: f32) -> f32 {
    a * b
}

/// The sum over a query and one candidate of as many coordinates, `N` a beat.
#[inline(always)]
pub(crate) fn pair<const N: usize>(query: &[f32], candidate: &[f32], term: impl Fn(f32, f32) -> f32) -> f32 {
    let beat = |a: &[f32; N], b: &[f32; N]| {
        let mut tree: [f32; N] = std::array::from_fn(|i| term(a[i], b[i]));
        let mut half = N / 2;
        while half > 0 {
            for i in 0..half {
                tree[i] += tree[i + half];
            }
            half /= 2;
        }
        tree[0]
    };
    let (queries, query_rest) = query.as_chunks::<N>();
    let (candidates, candidate_rest) = candidate.as_chunks::<N>();
    let sum = queries.iter().zip(candidates).fold(0.0, |sum, (a, b)| sum + beat(a, b));
    if query_rest.is_empty() { sum } else { sum + beat(&padded(query_rest), &padded(candidate_rest)) }
}

fn padded<const N: usize>(rest: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| rest.get(i).copied().unwrap_or(0.0))
}

/// Candidates at a time. Of 4, 8 and 16, this made the fastest code for the registers that every x86-64 has.
const SUB: usize = 8;

/// The sums over a query and the candidates of a block, both of a multiple of `N` coordinates, `N` a beat.
#[inline(always)]
pub(crate) fn block<const N: usize>(query: &[f32], block: &[Lane], term: impl Fn(f32, f32) -> f32) -> Lane {
    let mut sums = [0.0; WIDTH];
    for (part, sums) in sums.as_chunks_mut::<SUB>().0.iter_mut().enumerate() {
        for (query, lanes) in query.as_chunks::<N>().0.iter().zip(block.as_chunks::<N>().0) {
            let mut tree: [[f32; SUB]; N] = std::array::from_fn(|i| {
                let lane = &lanes[i].as_chunks::<SUB>().0[part];
                std::array::from_fn(|j| term(query[i], lane[j]))
            });
            let mut half = N / 2;
            while half > 0 {
                for i in 0..half {
                    tree[i] = plus(tree[i], tree[i + half]);
                }
                half /= 2;
            }
            *sums = plus(*sums, tree[0]);
        }
    }
    sums
}

#[inline(always)]
fn plus(a: [f32; SUB], b: [f32; SUB]) -> [f32; SUB] {
    std::array::from_fn(|i| a[i] + b[i])
}
