//! Vectors in memory, and their distances by the operations of the datapath.

use super::SEARCH_BLOCK;
use super::job::SearchMetric;

/// The elements of vectors in memory. The unit widens them to binary32, which is exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Elements {
    /// binary32.
    Binary32,
    /// binary16, which is exact in binary32.
    Binary16,
    /// Signed integers of 8 bits.
    Int8 {
        /// Their unit, above 0 and finite. Vectors are ranked by their integers; it multiplies the distances that are
        /// returned, and dot products twice.
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
        if let Self::Int8 { scale } = self { scale } else { 1.0 }
    }

    /// Bytes of an element.
    pub fn bytes(self) -> u32 {
        4 >> self.code()
    }

    /// Their number in a block.
    pub(crate) fn per_block(self) -> u32 {
        SEARCH_BLOCK / self.bytes()
    }

    /// The elements of a block.
    pub(crate) fn of_block(self, block: &[u8]) -> impl Iterator<Item = f32> {
        block.chunks_exact(self.bytes() as usize).map(move |bytes| match (self, bytes) {
            (Self::Binary32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            (Self::Binary16, &[a, b]) => half::f16::from_le_bytes([a, b]).to_f32(),
            (Self::Int8 { .. }, &[a]) => f32::from(a.cast_signed()),
            _ => 0.0,
        })
    }
}

impl VectorLayout {
    /// Bytes of a vector, in whole blocks.
    pub fn bytes(self) -> u32 {
        (self.dimensions * self.elements.bytes()).next_multiple_of(SEARCH_BLOCK)
    }
}

/// What the hardware keeps of the vectors of a job.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    pub metric: SearchMetric,
    pub elements: Elements,
    /// Elements in the last block of a vector.
    pub tail: u32,
    /// A tree is one of keys.
    pub is_keys: bool,
}

impl Shape {
    /// Of the words of a job, which may be one that is refused.
    pub fn of_words(words: &[u32; 16]) -> Self {
        let elements = Elements::from_code((words[0] >> 8 & 3).min(2), 1.0).unwrap_or(Elements::Binary32);
        let tail = words[1].wrapping_sub(1) % elements.per_block() + 1;
        Self { metric: SearchMetric::of_words(words), elements, tail, is_keys: words[0] & 1 == 0 }
    }

    /// The lanes of a beat.
    pub fn lanes(&self) -> u32 {
        if self.metric == SearchMetric::Euclidean { LANES as u32 } else { HALF as u32 }
    }
}

/// The sums of a vector with the query: of squared differences, or of products, and of its squares.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    pub sum: f32,
    pub norm: f32,
}

/// The sums that the datapath accumulates, and the beats that they take. The vectors have the same dimensions.
pub fn sums(metric: SearchMetric, query: &[f32], vector: &[f32]) -> (Sums, u64) {
    let beats = |lanes: usize| query.len().div_ceil(lanes) as u64;
    match metric {
        SearchMetric::Euclidean => (Sums { sum: squared(query, vector), norm: 0.0 }, beats(LANES)),
        SearchMetric::Dot | SearchMetric::Cosine => {
            (Sums { sum: dot_product(query, vector), norm: dot_product(vector, vector) }, beats(HALF))
        }
    }
}

/// The squared Euclidean distance of two vectors of the same dimensions, with the bits of the datapath's beats.
#[inline(always)]
pub fn squared(a: &[f32], b: &[f32]) -> f32 {
    sum_of_beats::<LANES>(a, b, |a, b| (a - b) * (a - b))
}

/// Their dot product, in the same way.
#[inline(always)]
pub fn dot_product(a: &[f32], b: &[f32]) -> f32 {
    sum_of_beats::<HALF>(a, b, |a, b| a * b)
}

/// The sum of a term of each pair of coordinates, in the order of the operations: beats of `N` terms, each added up as
/// term i and term i + half. It is in plain `f32`, which compilers turn into SIMD instructions of any width.
#[inline(always)]
fn sum_of_beats<const N: usize>(query: &[f32], candidate: &[f32], term: impl Fn(f32, f32) -> f32) -> f32 {
    let ((query, query_end), (candidate, candidate_end)) = (query.as_chunks::<N>(), candidate.as_chunks::<N>());
    let beat = |a: &[f32; N], b: &[f32; N]| {
        let mut terms: [f32; N] = std::array::from_fn(|i| term(a[i], b[i]));
        let mut half = N / 2;
        while half > 0 {
            for i in 0..half {
                terms[i] += terms[i + half];
            }
            half /= 2;
        }
        terms[0]
    };
    let mut sum = 0.0;
    for (a, b) in query.iter().zip(candidate) {
        sum += beat(a, b);
    }
    if !query_end.is_empty() {
        // A lane that is masked off adds +0.0, as a term of zeros does.
        let padded = |end: &[f32]| std::array::from_fn(|i| end.get(i).copied().unwrap_or(0.0));
        sum += beat(&padded(query_end), &padded(candidate_end));
    }
    sum
}
