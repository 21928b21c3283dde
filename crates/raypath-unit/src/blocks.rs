//! The layout of a scene in memory: blocks of 128 bytes, which are nodes or parts of leaves.
//!
//! All numbers are little-endian. A **child word** refers to a node or a leaf: bits 31 to 7 are bits 31 to 7 of its
//! address, bit 6 is 0, and bits 5 to 0 are its [`kind`](Child).
//!
//! | bytes of a node | contents |
//! | --- | --- |
//! | 24 · i to 24 · i + 23 | box i (0 to 3): min x, min y, min z, max x, max y, max z, in binary32 |
//! | 96 + 4 · i to 99 + 4 · i | the child word of box i |
//! | 112 to 127 | 0 |
//!
//! A leaf of n triangles (1 to 8) is ⌈n / 3⌉ consecutive blocks, with up to three triangles each:
//!
//! | bytes of a leaf's block | contents |
//! | --- | --- |
//! | 36 · k to 36 · k + 35 | the vertices a, b, c of triangle k (0 to 2) of the block, each as x, y, z in binary32 |
//! | 108 to 111 | 0 |
//! | 112 + 4 · k to 115 + 4 · k | the index of triangle k, which its hit reports |
//! | 124 to 127 | 0 |
//!
//! Bytes of triangles that a block does not have are 0.

use raypath_ops::{Aabb, Binary32, Slab, Triangle, array_of};
use thiserror::Error;

/// The bytes of a block.
pub const BLOCK_BYTES: u32 = 128;
/// The triangles of a full block of a leaf.
pub const TRIANGLES_PER_BLOCK: u32 = 3;
/// The triangles of the largest leaf.
pub const MAX_LEAF: u32 = 8;
/// The words of 32 bits that a triangle's vertices take.
pub const VERTEX_WORDS: usize = 9;
/// The word of a leaf's block with the index of its first triangle.
pub const INDEX_WORD: usize = 28;
/// The words of 32 bits that a box takes.
pub const BOX_WORDS: usize = 6;
/// The word of a node's block with its first child word.
pub const CHILD_WORD: usize = 24;
/// The kind of a child word that refers to a node.
pub const NODE_KIND: u32 = 32;

/// What a child word refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// Nothing, kind 0: the child is missing, and its box is never hit.
    None,
    /// A node, kind 32.
    Node {
        /// Its address.
        address: u32,
    },
    /// A leaf; its kind is the number of triangles, 1 to 8.
    Leaf {
        /// The address of its first block.
        address: u32,
        /// The number of triangles.
        count: u32,
    },
}

/// A triangle of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafTriangle {
    /// The vertices.
    pub triangle: Triangle<Binary32>,
    /// The index that a hit reports.
    pub index: u32,
}

/// A node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// The boxes of the children.
    pub boxes: [Aabb<Binary32>; 4],
    /// The child words.
    pub children: [u32; 4],
}

/// The error of a child word that is not valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("child word {0:#010x} has no valid kind, expected 0, 1 to 8 or 32 in bits 5 to 0, and 0 in bit 6")]
pub struct InvalidChild(pub u32);

impl Child {
    /// The child word.
    ///
    /// # Errors
    /// The address is no multiple of 128, or a leaf has no triangle or more than 8.
    pub fn word(self) -> Result<u32, InvalidChild> {
        let word = match self {
            Self::None => 0,
            Self::Node { address } => address | NODE_KIND,
            Self::Leaf { address, count } => address | count,
        };
        if Self::of(word) == Ok(self) { Ok(word) } else { Err(InvalidChild(word)) }
    }

    /// What a child word refers to.
    ///
    /// # Errors
    /// Its kind is not valid.
    pub fn of(word: u32) -> Result<Self, InvalidChild> {
        let address = word & !(BLOCK_BYTES - 1);
        match word & (BLOCK_BYTES - 1) {
            0 if address == 0 => Ok(Self::None),
            NODE_KIND => Ok(Self::Node { address }),
            count @ 1..=MAX_LEAF => Ok(Self::Leaf { address, count }),
            _ => Err(InvalidChild(word)),
        }
    }
}

/// The number of blocks of a leaf.
pub fn leaf_blocks(count: u32) -> u32 {
    count.div_ceil(TRIANGLES_PER_BLOCK)
}

impl Node {
    /// The bytes of the node's block.
    pub fn to_bytes(&self) -> [u8; BLOCK_BYTES as usize] {
        let mut block = [0; BLOCK_BYTES as usize];
        let bounds = self.boxes.iter().flat_map(|aabb| {
            let slabs = [aabb.x, aabb.y, aabb.z];
            slabs.map(|slab| slab.min).into_iter().chain(slabs.map(|slab| slab.max))
        });
        let words = bounds.map(|bound| f32::from(bound).to_bits()).chain(self.children);
        block.as_chunks_mut().0.iter_mut().zip(words).for_each(|(bytes, word)| *bytes = word.to_le_bytes());
        block
    }

    /// The node in a block.
    #[inline(always)]
    pub fn of(block: &[u8; BLOCK_BYTES as usize]) -> Self {
        let number = |index: usize| f32::from_bits(word(block, index)).into();
        let slab = |index: usize| Slab { min: number(index), max: number(index + 3) };
        let aabb = |index: usize| Aabb { x: slab(index), y: slab(index + 1), z: slab(index + 2) };
        Self {
            boxes: array_of!(child => aabb(BOX_WORDS * child)),
            children: array_of!(child => word(block, CHILD_WORD + child)),
        }
    }
}

impl LeafTriangle {
    /// The bytes of the blocks of a leaf of these triangles.
    pub fn to_bytes(leaf: &[Self]) -> Vec<u8> {
        let mut blocks = Vec::new();
        for triangles in leaf.chunks(TRIANGLES_PER_BLOCK as usize) {
            let mut words = [0; BLOCK_BYTES as usize / 4];
            for (place, LeafTriangle { triangle: Triangle { a, b, c }, index }) in triangles.iter().enumerate() {
                let numbers = [a, b, c].into_iter().flat_map(|vertex| <[f32; 3]>::from(*vertex));
                words[VERTEX_WORDS * place..].iter_mut().zip(numbers).for_each(|(word, x)| *word = x.to_bits());
                words[INDEX_WORD + place] = *index;
            }
            blocks.extend(words.into_iter().flat_map(u32::to_le_bytes));
        }
        blocks
    }

    /// A triangle of a leaf's block, by its place: 0 to 2.
    pub fn of(block: &[u8; BLOCK_BYTES as usize], place: usize) -> Self {
        let vertex =
            |index: usize| std::array::from_fn(|axis| f32::from_bits(word(block, VERTEX_WORDS * place + index + axis)));
        Self { triangle: Triangle::new(vertex(0), vertex(3), vertex(6)), index: word(block, INDEX_WORD + place) }
    }
}

/// A word of a block; 0 beyond its end.
#[inline(always)]
fn word(block: &[u8; BLOCK_BYTES as usize], index: usize) -> u32 {
    block.as_chunks().0.get(index).copied().map_or(0, u32::from_le_bytes)
}
