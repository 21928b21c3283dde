//! What the modules of searches share.

use super::super::queue::bits;
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Wire};

/// What a burst fetches, or which marker it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Burst {
    /// The block of a job.
    #[default]
    Job,
    /// The query, to be kept.
    Query,
    /// The query as a vector, for its norm.
    Norm,
    /// A block of a list of indices.
    List,
    /// A vector.
    Vector,
    /// A marker: the best candidate's neighbours come next.
    Expand,
    /// A marker: the search ends.
    Drain,
    /// A node of a tree.
    Node,
}

/// Bits of a burst's kind.
pub const BURST_BITS: u32 = 3;

/// Bits of the number of a block's address.
pub const BLOCK_SHIFT: u32 = 6;

/// Bits of the number of a block in the 4 GiB that a job reaches.
pub const BLOCK_BITS: u32 = 32 - BLOCK_SHIFT;

/// Words of a block.
pub const WORDS: u32 = 16;

impl Burst {
    /// Whether a word has this kind.
    pub fn is(self, kind: Wire<'_>) -> Wire<'_> {
        kind.is(self as u64)
    }

    /// The kind as a word.
    pub fn wire(self, m: &Builder) -> Wire<'_> {
        m.constant(BURST_BITS, self as u64)
    }

    /// Whether a word is that of a marker.
    pub fn marks(kind: Wire<'_>) -> Wire<'_> {
        Self::Expand.is(kind) | Self::Drain.is(kind)
    }

    /// Whether it is a marker.
    pub fn is_marker(self) -> bool {
        matches!(self, Self::Expand | Self::Drain)
    }

    /// Whether it is a vector, or the query as one.
    pub fn is_vector(self) -> bool {
        matches!(self, Self::Norm | Self::Vector)
    }
}

/// Bits of the number of a context.
pub fn context_bits(parameters: SearchParameters) -> u32 {
    bits(parameters.contexts)
}

/// Bits of the number of a block of a vector.
pub fn vector_block_bits(parameters: SearchParameters) -> u32 {
    bits(parameters.dimensions.div_ceil(WORDS).max(2))
}

/// The word in which only the bit of this number is set.
pub fn one_hot(number: Wire<'_>, count: u32) -> Wire<'_> {
    number.builder().constant(count, 1).shift_left(number)
}

/// The number of the only bit that is set.
pub fn number_of(one_hot: Wire<'_>) -> Wire<'_> {
    let (m, count) = (one_hot.builder(), one_hot.width());
    let bit = |place: u32| {
        let of: Vec<Wire<'_>> = (0..count).rev().filter(|k| k >> place & 1 == 1).map(|k| one_hot.bit(k)).collect();
        m.concat(&of).any()
    };
    m.concat(&(0..bits(count)).rev().map(bit).collect::<Vec<_>>())
}

/// The bit of this number.
pub fn bit_of<'m>(word: Wire<'m>, number: Wire<'m>) -> Wire<'m> {
    (word & one_hot(number, word.width())).any()
}

/// This word if the condition holds, else 0.
pub fn when<'m>(condition: Wire<'m>, word: Wire<'m>) -> Wire<'m> {
    word & condition.replicate(word.width())
}

/// A rank as a word that is the lower the lower the rank, and that is 0xff800000 at most. Numbers are not -0 or NaN.
pub fn key_of(rank: Wire<'_>) -> Wire<'_> {
    let sign = rank.top();
    let rest = rank.lower(31) ^ sign.replicate(31);
    rank.builder().concat(&[!sign, rest])
}

/// The rank of a key.
pub fn rank_of_key(key: Wire<'_>) -> Wire<'_> {
    let sign = !key.top();
    let rest = key.lower(31) ^ sign.replicate(31);
    key.builder().concat(&[sign, rest])
}
