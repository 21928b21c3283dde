//! The layout of a scene in memory: blocks, which are nodes, parts of leaves, or instances.
//!
//! All numbers are little-endian. All blocks of a scene have the size that its [`NodeKind`] gives, and addresses that
//! are multiples of it. A **child word** refers to a node, a leaf or an instance: its low bits, as many as an address
//! has inside of a block, are its [`kind`](Child), and the others are those of its address.
//!
//! # Wide nodes: blocks of 128 bytes
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
//! | 108 to 111 | the index of their geometry |
//! | 112 + 4 · k to 115 + 4 · k | the index of triangle k, which its hit reports |
//! | 124 to 127 | 0 |
//!
//! Bytes of triangles that a block does not have are 0.
//!
//! # Quantised nodes: blocks of 64 bytes
//!
//! [`quantised`] says what the bounds mean.
//!
//! | bytes of a node | contents |
//! | --- | --- |
//! | 0 to 11 | the base: x, y, z, in binary32 |
//! | 12 to 14 | the biased exponents of x, y, z |
//! | 15 | 0 |
//! | 16 + 6 · i to 21 + 6 · i | box i (0 to 3): min x, min y, min z, max x, max y, max z, a byte each |
//! | 40 + 4 · i to 43 + 4 · i | the child word of box i |
//! | 56 to 63 | 0 |
//!
//! A leaf with n places is ⌈n / 2⌉ consecutive blocks, with a triangle or two that share vertices each:
//!
//! | bytes of a leaf's block | contents |
//! | --- | --- |
//! | 12 · k to 12 · k + 11 | vertex k (0 to 3) of the block, as x, y, z in binary32; the first triangle has vertices 0, 1, 2 |
//! | 48 to 51, 52 to 55 | the indices of the first triangle and of the second |
//! | 56 to 59 | the index of their geometry |
//! | 60 | the vertices a, b, c of the second triangle: bits 1 to 0, 3 to 2, 5 to 4 |
//! | 61 to 63 | 0 |
//!
//! A second triangle with the vertices 0, 0, 0 is none: no ray hits it. It has a place all the same, if it is not the
//! last of its leaf.

mod kind;
pub mod quantised;
pub mod wide8;

pub use kind::NodeKind;

use crate::codes::Codes;
use crate::instance::INSTANCE_KIND;
use raypath_ops::{Aabb, Binary32, Slab, Triangle, array_of};
use thiserror::Error;
use wide8::Node8;

/// The bytes of the largest block: that of wide nodes.
pub const BLOCK_BYTES: u32 = NodeKind::Wide4.block_bytes();
/// The triangles of the largest leaf.
pub const MAX_LEAF: u32 = 8;
/// The last kind of a leaf.
const LAST_LEAF: u32 = 2 * MAX_LEAF;
/// The kinds of a leaf of a procedural box: of an opaque geometry, and of another.
pub const BOX_KINDS: [u32; 2] = [17, 25];
/// The kinds of a child word with names. Those of leaves of triangles begin with the first of each opacity; there are
/// [`MAX_LEAF`] of them, one for each number of triangles.
pub(crate) const KINDS: Codes = Codes {
    stem: "Child",
    doc: "What the lower bits of a child word say that it leads to.",
    first_bit: None,
    all: &[
        ("NONE", 0),
        ("OPAQUE_LEAF", 1),
        ("OTHER_LEAF", MAX_LEAF + 1),
        ("OPAQUE_BOX", BOX_KINDS[0]),
        ("OTHER_BOX", BOX_KINDS[1]),
        ("NODE", NODE_KIND),
        ("INSTANCE", INSTANCE_KIND),
        ("SECOND_WINDOW", wide8::CONTINUATION),
        ("THIRD_WINDOW", wide8::CONTINUATION + 1),
        ("INVALID", wide8::INVALID),
    ],
};
/// The words of 32 bits that a triangle's vertices take.
pub const VERTEX_WORDS: usize = 9;
/// The word of a quantised leaf's block with the numbers of the second triangle's vertices.
pub const VERTEX_NUMBERS: usize = 15;
/// The bounds of a box.
pub const BOX_WORDS: usize = 6;
/// The kind of a child word that refers to a node.
pub const NODE_KIND: u32 = 32;

/// What a child word refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Child {
    /// Nothing, the word 0.
    None,
    /// A node, kind 32.
    Node {
        /// Its address.
        address: u32,
    },
    /// An instance, kind 33: see [`Instance`](crate::Instance).
    Instance {
        /// Its address.
        address: u32,
    },
    /// A leaf; its kind is the number of its places for triangles, 1 to 8, and 8 more if they are not opaque.
    Leaf {
        /// The address of its first block.
        address: u32,
        /// The number of places for triangles.
        count: u32,
        /// Its geometry is opaque, as all are in a unit of [`Queries::None`](crate::Queries::None).
        is_opaque: bool,
    },
    /// A procedural box, kind 17 or 25, in a unit of [`Queries::Full`](crate::Queries::Full). Its block has indices where
    /// that of a triangle has them, and the box is that of the node above.
    Box {
        /// The address of its block.
        address: u32,
        /// Its geometry is opaque.
        is_opaque: bool,
    },
}

/// A triangle of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafTriangle {
    /// The vertices.
    pub triangle: Triangle<Binary32>,
    /// The index in its geometry.
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
#[error(
    "child word {word:#010x} has no valid kind, expected 0, 1 to 17, 25, 32 or 33 in its low {} bits",
    nodes.offset_bits()
)]
pub struct InvalidChild {
    /// The word.
    pub word: u32,
    /// The nodes of the scene.
    pub nodes: NodeKind,
}

impl Child {
    /// The child word in a scene with these nodes.
    ///
    /// # Errors
    /// The address is no multiple of a block, or a leaf has no triangle or more than 8.
    pub fn word(self, nodes: NodeKind) -> Result<u32, InvalidChild> {
        let word = match self {
            Self::None => 0,
            Self::Node { address } => address | NODE_KIND,
            Self::Instance { address } => address | INSTANCE_KIND,
            Self::Box { address, is_opaque } => address | BOX_KINDS[usize::from(!is_opaque)],
            Self::Leaf { address, count, is_opaque } => address | (count + if is_opaque { 0 } else { MAX_LEAF }),
        };
        if Self::of(word, nodes) == Ok(self) { Ok(word) } else { Err(InvalidChild { word, nodes }) }
    }

    /// What a child word refers to in a scene with these nodes.
    ///
    /// # Errors
    /// Its kind is not valid.
    pub fn of(word: u32, nodes: NodeKind) -> Result<Self, InvalidChild> {
        let inside = nodes.block_bytes() - 1;
        let address = word & !inside;
        match word & inside {
            0 if address == 0 => Ok(Self::None),
            NODE_KIND => Ok(Self::Node { address }),
            INSTANCE_KIND => Ok(Self::Instance { address }),
            kind if BOX_KINDS.contains(&kind) => Ok(Self::Box { address, is_opaque: kind == BOX_KINDS[0] }),
            kind @ 1..=LAST_LEAF => {
                Ok(Self::Leaf { address, count: (kind - 1) % MAX_LEAF + 1, is_opaque: kind <= MAX_LEAF })
            }
            _ => Err(InvalidChild { word, nodes }),
        }
    }
}

impl Node {
    /// The bytes of the wide node's block.
    pub fn to_bytes(&self) -> [u8; BLOCK_BYTES as usize] {
        let mut block = [0; BLOCK_BYTES as usize];
        let words = self.boxes.iter().flat_map(bounds).map(f32::to_bits).chain(self.children);
        block.as_chunks_mut().0.iter_mut().zip(words).for_each(|(bytes, word)| *bytes = word.to_le_bytes());
        block
    }

    /// The wide node in a block.
    #[inline(always)]
    pub fn of(block: &[u8; BLOCK_BYTES as usize]) -> Self {
        let number = |index: usize| f32::from_bits(word(block, index)).into();
        let slab = |index: usize| Slab { min: number(index), max: number(index + 3) };
        let aabb = |index: usize| Aabb { x: slab(index), y: slab(index + 1), z: slab(index + 2) };
        Self { boxes: array_of!(child => aabb(BOX_WORDS * child)), children: child_words(block, NodeKind::Wide4) }
    }
}

impl LeafTriangle {
    /// The bytes of the blocks of a leaf of these triangles, of the geometry with this index, in a scene with these
    /// nodes, and the number of its places, which is the count of its child word. Quantised leaves have the triangles
    /// in another order, and places without a triangle.
    pub fn to_blocks(leaf: &[Self], geometry: u32, nodes: NodeKind) -> (Vec<u8>, u32) {
        let of_block = nodes.triangles_per_block() as usize;
        let shared: Vec<Vec<Self>> = match nodes {
            NodeKind::Wide4 | NodeKind::Wide8 => leaf.chunks(of_block).map(<[Self]>::to_vec).collect(),
            NodeKind::Quantised => pairs(leaf),
        };
        let places = shared.last().map_or(0, |last| of_block * (shared.len() - 1) + last.len());
        let mut blocks = vec![0; shared.len() * nodes.block_bytes() as usize];
        for (block, triangles) in blocks.chunks_mut(nodes.block_bytes() as usize).zip(shared) {
            let words = block.as_chunks_mut().0;
            words[nodes.geometry_word()] = geometry.to_le_bytes();
            for (place, Self { index, .. }) in triangles.iter().enumerate() {
                words[nodes.index_word() + place] = index.to_le_bytes();
            }
            if let (NodeKind::Quantised, [first, second]) = (nodes, &triangles[..]) {
                let numbers = second.numbers_in(first);
                block[4 * VERTEX_NUMBERS] = numbers.map_or(0, |[a, b, c]| a | b << 2 | c << 4);
            }
            for (place, triangle) in triangles.iter().enumerate() {
                Self::put_vertices(block, place, triangle.corners(), nodes);
            }
        }
        (blocks, places as u32)
    }

    /// Puts the vertices of a triangle into a leaf's block, at its place, in a scene with these nodes. Of another
    /// triangle of the block, vertices that both have change.
    pub fn put_vertices(block: &mut [u8], place: usize, corners: [[f32; 3]; 3], nodes: NodeKind) {
        let words = block.as_chunks_mut().0;
        for (vertex, corner) in Self::vertices(words.as_flattened(), place, nodes).into_iter().zip(corners) {
            words.iter_mut().skip(3 * vertex).zip(corner).for_each(|(word, x)| *word = x.to_le_bytes());
        }
    }

    /// The numbers in a leaf's block of the vertices of a triangle, by its place, in a scene with these nodes.
    #[inline(always)]
    pub fn vertices(block: &[u8], place: usize, nodes: NodeKind) -> [usize; 3] {
        match nodes {
            NodeKind::Quantised if place > 0 => {
                let numbers = word(block, VERTEX_NUMBERS) as usize;
                [numbers % 4, numbers / 4 % 4, numbers / 16 % 4]
            }
            _ => [3 * place, 3 * place + 1, 3 * place + 2],
        }
    }

    /// Whether there is no triangle at a place of a leaf's block, which a quantised leaf may have.
    pub fn is_empty_place(block: &[u8], place: usize, nodes: NodeKind) -> bool {
        Self::vertices(block, place, nodes) == [0; 3]
    }

    /// The index of the geometry of a leaf's block, in a scene with these nodes.
    pub fn geometry(block: &[u8], nodes: NodeKind) -> u32 {
        word(block, nodes.geometry_word())
    }

    /// A triangle of a leaf's block, by its place, in a scene with these nodes.
    pub fn of(block: &[u8], place: usize, nodes: NodeKind) -> Self {
        let vertex = |number: usize| std::array::from_fn(|axis| f32::from_bits(word(block, 3 * number + axis)));
        let [a, b, c] = Self::vertices(block, place, nodes).map(vertex);
        Self { triangle: Triangle::new(a, b, c), index: word(block, nodes.index_word() + place) }
    }

    /// Its vertices.
    pub fn corners(&self) -> [[f32; 3]; 3] {
        let Triangle { a, b, c } = self.triangle;
        [a, b, c].map(Into::into)
    }

    /// The numbers of its vertices in a block whose first three are those of another triangle; none if they need more
    /// than one vertex besides.
    fn numbers_in(&self, first: &Self) -> Option<[u8; 3]> {
        let bits = |triangle: &Self| triangle.corners().map(|corner| corner.map(f32::to_bits));
        let (known, own) = (bits(first), bits(self));
        let number = |corner| known.iter().position(|vertex| *vertex == corner);
        let others = own.iter().filter(|corner| number(**corner).is_none());
        (others.count() < 2).then(|| own.map(|corner| number(corner).unwrap_or(3) as u8))
    }
}

/// The triangles of a leaf in pairs that fit into a block, then those that are left.
fn pairs(leaf: &[LeafTriangle]) -> Vec<Vec<LeafTriangle>> {
    let (mut rest, mut pairs): (Vec<usize>, Vec<_>) = ((0..leaf.len()).collect(), Vec::new());
    let shares = |a: usize, b: usize| a != b && leaf[b].numbers_in(&leaf[a]).is_some();
    loop {
        // That with the fewest partners comes first, so that others keep theirs.
        let partners = |place: &usize| rest.iter().filter(|other| shares(*place, **other)).count();
        let fewest = |places: &mut dyn Iterator<Item = usize>| places.min_by_key(partners);
        let Some(first) = fewest(&mut rest.iter().copied().filter(|place| partners(place) > 0)) else { break };
        let Some(second) = fewest(&mut rest.iter().copied().filter(|place| shares(first, *place))) else { break };
        pairs.push(vec![leaf[first], leaf[second]]);
        rest.retain(|place| ![first, second].contains(place));
    }
    pairs.extend(rest.into_iter().map(|place| vec![leaf[place]]));
    pairs
}

/// The child words in the block of a node or of an instance.
pub fn children(block: &[u8], of: Child, nodes: NodeKind) -> Vec<u32> {
    match (of, nodes) {
        (Child::Node { .. }, NodeKind::Wide8) => {
            block.first_chunk().map_or(Vec::new(), |block| Node8::of(block).children.to_vec())
        }
        (Child::Node { .. }, NodeKind::Wide4 | NodeKind::Quantised) => child_words(block, nodes).to_vec(),
        (Child::Instance { .. }, _) => child_words(block, nodes)[..1].to_vec(),
        (Child::None | Child::Leaf { .. } | Child::Box { .. }, _) => Vec::new(),
    }
}

/// Moves the children in the block of a node or of an instance by so many bytes.
pub fn move_children(block: &mut [u8], of: Child, nodes: NodeKind, offset: u32) {
    let (count, offset) = match (of, nodes) {
        (Child::Node { .. }, NodeKind::Wide8) => (2, offset / nodes.block_bytes()),
        (Child::Node { .. }, NodeKind::Wide4 | NodeKind::Quantised) => (4, offset),
        (Child::Instance { .. }, _) => (1, offset),
        (Child::None | Child::Leaf { .. } | Child::Box { .. }, _) => (0, 0),
    };
    for bytes in block.as_chunks_mut().0.iter_mut().skip(nodes.child_word()).take(count) {
        let word = u32::from_le_bytes(*bytes);
        // Of four child words 0 is none. Of two bases 0 is a block.
        let is_none = word == 0 && count != 2;
        *bytes = if is_none { 0 } else { word.wrapping_add(offset) }.to_le_bytes();
    }
}

/// The child words of a node's block, or the words of an instance's at their places.
#[inline]
pub(crate) fn child_words(block: &[u8], nodes: NodeKind) -> [u32; 4] {
    array_of!(i => word(block, nodes.child_word() + i))
}

/// The bounds of a box in the order of memory: the minima, then the maxima.
fn bounds(aabb: &Aabb<Binary32>) -> [f32; BOX_WORDS] {
    let Aabb { x, y, z } = *aabb;
    [x.min.into(), y.min.into(), z.min.into(), x.max.into(), y.max.into(), z.max.into()]
}

/// A word of a block; 0 beyond its end.
#[inline(always)]
pub(crate) fn word(block: &[u8], index: usize) -> u32 {
    block.as_chunks().0.get(index).copied().map_or(0, u32::from_le_bytes)
}
