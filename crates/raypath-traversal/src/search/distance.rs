//! Vectors in memory, and their distances by the operations of the datapath.

use super::SEARCH_BLOCK;
use super::job::SearchMetric;
use raypath_ops::{
    Angular, AngularState, Beat, BeatInput, Binary32, Circuit, Euclidean, EuclideanState, Flags, Num, Operation,
    Rounding, array_of,
};

/// The elements of vectors in memory. The unit widens them to binary32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Elements {
    /// binary32.
    Binary32,
    /// binary16, which is exact in binary32.
    Binary16,
    /// Signed integers of 8 bits.
    Int8 {
        /// Their unit: an element is the integer times this, rounded to nearest even.
        scale: f32,
    },
}

/// Where the elements of a vector are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorLayout {
    /// The elements, one behind the other, little-endian.
    pub elements: Elements,
    /// Their number.
    pub dimensions: u32,
}

/// Euclidean lanes of a beat, and angular ones.
const LANES: usize = 16;
const HALF: usize = LANES / 2;

impl Elements {
    pub(super) fn code(self) -> u32 {
        match self {
            Self::Binary32 => 0,
            Self::Binary16 => 1,
            Self::Int8 { .. } => 2,
        }
    }

    pub(super) fn from_code(code: u32, scale: f32) -> Option<Self> {
        Some(match code {
            0 => Self::Binary32,
            1 => Self::Binary16,
            2 => Self::Int8 { scale },
            _ => return None,
        })
    }

    pub(super) fn scale(self) -> f32 {
        if let Self::Int8 { scale } = self { scale } else { 0.0 }
    }

    /// Bytes of an element.
    pub fn bytes(self) -> u32 {
        4 >> self.code()
    }

    /// The elements of a block.
    fn of_block(self, block: &[u8]) -> impl Iterator<Item = f32> {
        block.chunks_exact(self.bytes() as usize).map(move |bytes| match (self, bytes) {
            (Self::Binary32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            (Self::Binary16, &[a, b]) => half::f16::from_le_bytes([a, b]).to_f32(),
            (Self::Int8 { scale }, &[a]) => f32::from(a.cast_signed()) * scale,
            _ => 0.0,
        })
    }
}

impl VectorLayout {
    /// Bytes of a vector, in whole blocks.
    pub fn bytes(self) -> u32 {
        (self.dimensions * self.elements.bytes()).next_multiple_of(SEARCH_BLOCK)
    }

    /// The elements of a vector in these blocks.
    pub(super) fn vector(self, blocks: &[u8]) -> Vec<f32> {
        self.elements.of_block(blocks).take(self.dimensions as usize).collect()
    }
}

/// The sums of a vector with the query: of squared differences, or of products, and of its squares.
#[derive(Debug, Clone, Copy)]
pub struct Sums {
    pub sum: f32,
    pub norm: f32,
}

/// The sums that the datapath accumulates, and the beats that they take.
pub fn sums(metric: SearchMetric, query: &[f32], vector: &[f32]) -> (Sums, u64) {
    let c = Binary32;
    if metric == SearchMetric::Euclidean {
        let operation = Euclidean::<LANES> { rounding: Rounding::Unit };
        let run = |state, euclidean| operation.run(c, BeatInput { euclidean }, state).1;
        let state: EuclideanState<Binary32> = beats(query, vector).fold(EuclideanState::zero(c), run);
        return (Sums { sum: state.accumulator.into(), norm: 0.0 }, query.len().div_ceil(LANES) as u64);
    }
    let operation = Angular::<HALF> { rounding: Rounding::Unit };
    let run = |state, euclidean| operation.run(c, BeatInput { euclidean }, state).1;
    let state: AngularState<Binary32> = beats(query, vector).fold(AngularState::zero(c), run);
    (Sums { sum: state.dot_product.into(), norm: state.norm.into() }, query.len().div_ceil(HALF) as u64)
}

/// The beats of a pair of vectors. The state after the last is taken before the accumulators restart.
fn beats<'v, const N: usize>(query: &'v [f32], vector: &'v [f32]) -> impl Iterator<Item = Beat<Binary32, N>> + 'v {
    query.chunks(N).zip(vector.chunks(N)).map(|(a, b)| {
        let lane = |lanes: &[f32], i: usize| -> Num<Binary32> { lanes.get(i).copied().unwrap_or(0.0).into() };
        Beat {
            a: array_of!(i => lane(a, i)),
            b: array_of!(i => lane(b, i)),
            mask: Flags(array_of!(i => Binary32.bit(i < a.len()))),
            reset_accum: Binary32.bit(false),
        }
    })
}
