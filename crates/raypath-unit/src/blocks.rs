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
//! A leaf of n triangles (1 to 8) is ⌈n / 3⌉ consecutive blocks. Triangle k is in block ⌊k / 3⌋, from byte
//! 40 · (k mod 3) on:
//!
//! | bytes of a triangle | contents |
//! | --- | --- |
//! | 0 to 35 | the vertices a, b, c, each as x, y, z in binary32 |
//! | 36 to 39 | its index, which the hit reports |

use raypath_ops::{Aabb, Binary32, Triangle};
use thiserror::Error;

/// The bytes of a block.
pub const BLOCK_BYTES: u32 = 128;
/// The triangles of a full block of a leaf.
pub const TRIANGLES_PER_BLOCK: u32 = 3;
/// The triangles of the largest leaf.
pub const MAX_LEAF: u32 = 8;
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
    pub fn of(block: &[u8; BLOCK_BYTES as usize]) -> Self {
        let number = |index: usize| f32::from_bits(word(block, index));
        let corner = |index: usize| std::array::from_fn(|axis| number(index + axis));
        Self {
            boxes: std::array::from_fn(|child| Aabb::new(corner(6 * child), corner(6 * child + 3))),
            children: std::array::from_fn(|child| word(block, 24 + child)),
        }
    }
}

impl LeafTriangle {
    /// The bytes of the blocks of a leaf of these triangles.
    pub fn to_bytes(leaf: &[Self]) -> Vec<u8> {
        let mut blocks = Vec::new();
        for triangles in leaf.chunks(TRIANGLES_PER_BLOCK as usize) {
            for LeafTriangle { triangle: Triangle { a, b, c }, index } in triangles {
                let numbers = [a, b, c].into_iter().flat_map(|vertex| <[f32; 3]>::from(*vertex));
                let words = numbers.map(f32::to_bits).chain([*index]);
                blocks.extend(words.flat_map(u32::to_le_bytes));
            }
            blocks.resize(blocks.len().next_multiple_of(BLOCK_BYTES as usize), 0);
        }
        blocks
    }

    /// A triangle of a leaf's block, by its place: 0 to 2.
    pub fn of(block: &[u8; BLOCK_BYTES as usize], place: usize) -> Self {
        let vertex = |index: usize| std::array::from_fn(|axis| f32::from_bits(word(block, 10 * place + index + axis)));
        Self { triangle: Triangle::new(vertex(0), vertex(3), vertex(6)), index: word(block, 10 * place + 9) }
    }
}

/// A word of a block; 0 beyond its end.
fn word(block: &[u8; BLOCK_BYTES as usize], index: usize) -> u32 {
    block.as_chunks().0.get(index).copied().map_or(0, u32::from_le_bytes)
}
