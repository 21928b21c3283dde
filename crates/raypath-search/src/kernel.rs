//! The operations over sixteen candidates at once. All that knows how candidates lie in memory and what computes on
//! them is here: [`Blocks`] and the two functions that take one of them.

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

/// Squared distances of a query and the candidates of a block, both of a multiple of `E` coordinates.
#[inline]
pub(crate) fn squared<const E: usize>(query: &[f32], block: &[Lane]) -> Lane {
    sums::<E>(query, block, |a, b| (a - b) * (a - b))
}

/// Dot products of a query and the candidates of a block, both of a multiple of `A` coordinates. The norms, which do not
/// depend on the query, are left out.
#[inline]
pub(crate) fn dot_products<const A: usize>(query: &[f32], block: &[Lane]) -> Lane {
    sums::<A>(query, block, |a, b| a * b)
}

/// Candidates at a time. Of 4, 8 and 16, this made the fastest code for the registers that every x86-64 has.
const SUB: usize = 8;

#[inline(always)]
fn sums<const N: usize>(query: &[f32], block: &[Lane], term: impl Fn(f32, f32) -> f32) -> Lane {
    let mut sums = [0.0; WIDTH];
    for (part, sums) in sums.as_chunks_mut::<SUB>().0.iter_mut().enumerate() {
        for (query, lanes) in query.as_chunks::<N>().0.iter().zip(block.as_chunks::<N>().0) {
            let term = |i: usize| -> [f32; SUB] {
                let lane = &lanes[i].as_chunks::<SUB>().0[part];
                std::array::from_fn(|j| term(query[i], lane[j]))
            };
            let mut tree: [_; N] = std::array::from_fn(term);
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
