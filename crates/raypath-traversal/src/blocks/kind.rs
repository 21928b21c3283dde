//! The kinds of nodes that a scene may have.

use super::MAX_LEAF;
use super::wide8::WINDOW;
use crate::query::names;

/// How the nodes of a scene are laid out, and with them the blocks of its leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum NodeKind {
    /// Four boxes in binary32, in blocks of 128 bytes.
    #[default]
    Wide4,
    /// Four boxes of 8 bits a bound, in blocks of 64 bytes.
    Quantised,
    /// Eight boxes of 8 bits a bound, in blocks of 128 bytes: see [`wide8`](super::wide8).
    Wide8,
}

impl NodeKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Wide4, Self::Quantised, Self::Wide8];

    /// The bytes of a block.
    pub const fn block_bytes(self) -> u32 {
        match self {
            Self::Wide4 | Self::Wide8 => 128,
            Self::Quantised => 64,
        }
    }

    /// The bits of an address inside of a block.
    pub const fn offset_bits(self) -> u32 {
        self.block_bytes().trailing_zeros()
    }

    /// The triangles of a full block of a leaf.
    pub const fn triangles_per_block(self) -> u32 {
        match self {
            Self::Wide4 | Self::Wide8 => 3,
            Self::Quantised => 2,
        }
    }

    /// The most triangles of a leaf, if none of them share vertices.
    pub const fn max_leaf(self) -> u32 {
        match self {
            Self::Wide4 => MAX_LEAF,
            Self::Quantised => MAX_LEAF / 2,
            Self::Wide8 => WINDOW,
        }
    }

    /// The most children of a node.
    pub const fn children(self) -> usize {
        match self {
            Self::Wide4 | Self::Quantised => 4,
            Self::Wide8 => 8,
        }
    }

    /// The levels that a node with so many children takes at most of the [`LEVELS`](crate::LEVELS) of the unit.
    pub fn node_levels(self, children: usize) -> u32 {
        match self {
            Self::Wide4 | Self::Quantised => 1,
            Self::Wide8 => (children as u32).div_ceil(WINDOW).max(1),
        }
    }

    /// The word of a node's block with the first of the four that tell its children: child words, or with wide8 two
    /// bases and eight bytes.
    pub const fn child_word(self) -> usize {
        match self {
            Self::Wide4 => 24,
            Self::Quantised => 10,
            Self::Wide8 => 4,
        }
    }

    /// The word of an instance's block with a number of its matrix, 0 to 11: the words that are no child words, in order.
    pub const fn matrix_word(self, number: usize) -> usize {
        if number < self.child_word() { number } else { number + 4 }
    }

    /// The word of a leaf's block with the index of its geometry.
    pub const fn geometry_word(self) -> usize {
        match self {
            Self::Wide4 | Self::Wide8 => 27,
            Self::Quantised => 14,
        }
    }

    /// The word of a leaf's block with the index of its first triangle.
    pub const fn index_word(self) -> usize {
        match self {
            Self::Wide4 | Self::Wide8 => 28,
            Self::Quantised => 12,
        }
    }
}

names! { NodeKind { Wide4 = "wide4", Quantised = "quantised", Wide8 = "wide8" } }
