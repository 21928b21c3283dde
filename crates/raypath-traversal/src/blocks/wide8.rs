//! Nodes with eight children, in the 80 bytes of the crate `obvhs` and of others: the compressed wide nodes of Ylitie,
//! Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs" (HPG 2017).
//!
//! | bytes of a node | contents |
//! | --- | --- |
//! | 0 to 11 | the base: x, y, z, in binary32 |
//! | 12 to 14 | the biased exponents of x, y, z |
//! | 15 | bit i: child i is a node; the unit does not read it |
//! | 16 to 19 | the block of the first child that is a node |
//! | 20 to 23 | the block of the first other child |
//! | 24 + i | what child i (0 to 7) is, see below |
//! | 32 + 8 · k + i | bound k of child i: min x, max x, min y, max y, min z, max z |
//! | 80 to 127 | 0 |
//!
//! A bound q of an axis with the base b and the exponent E is the sum b + q · 2^(E - 127), rounded once to binary32. The
//! addend is 0 where q or E is 0.
//!
//! Children that are nodes have consecutive blocks, and the others too, in the order of their numbers. A number of a
//! block is its address divided by 128, below 2²⁵.
//!
//! | byte | child |
//! | --- | --- |
//! | 0 | none |
//! | 001 in bits 7 to 5, and 24 or more in the others | a node |
//! | 001, 011, 111 in bits 7 to 5 | a leaf of 1, 2, 3 opaque triangles; the other bits have the number of triangles of the leaves before it, which the unit does not read |
//! | 010, 100 in bits 7 to 5 | ours: bits 4 to 0 are the lower bits of a [kind](super::Child), whose bit 5 is 0 or 1 |

use super::quantised::{self, Contained};
use super::{KINDS, MAX_LEAF, NODE_KIND, NodeKind, word};
use crate::words::{WordCircuit, WordMethods, label};
use raypath_ops::{Aabb, Binary32, Bit, Flags, Num, SortEntry, Word, array_of, bundle};
use std::ops::RangeInclusive;
use thiserror::Error;

/// The bytes of a block.
const BYTES: usize = NodeKind::Wide8.block_bytes() as usize;
/// The children of a node.
pub const CHILDREN: usize = 8;
/// The byte with what child 0 is.
pub(crate) const FIRST_KIND: usize = 24;
/// The byte with the first bound.
const FIRST_BOUND: usize = 32;
/// The children of a node that a step takes, of those that are hit, near to far: the others are one more child, which
/// is the same node once more.
pub const WINDOW: u32 = 3;
/// The kind of a child word that is a node whose first [`WINDOW`] hits are left out; one more, twice as many. There is
/// none in memory.
pub const CONTINUATION: u32 = 97;
/// The kinds of children besides nodes and opaque triangles: other triangles, then boxes and instances.
const OTHER_KINDS: [RangeInclusive<u32>; 2] = [MAX_LEAF + 1..=MAX_LEAF + WINDOW, 2 * MAX_LEAF + 1..=63];
/// The byte of child 0 that is a node.
const NODE_BYTE: u8 = 1 << 5 | 24;
/// A kind that is not valid.
pub(crate) const INVALID: u32 = 127;

/// A node with eight children.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node8 {
    /// The boxes of the children.
    pub boxes: [Aabb<Binary32>; CHILDREN],
    /// The child words. Nodes have consecutive blocks, and so have other children.
    pub children: [u32; CHILDREN],
}

/// The reason why children make no node.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum Node8Error {
    /// A box that cannot be contained.
    #[error(transparent)]
    Box(#[from] quantised::BoxError),
    /// A child that is not in the block after that of the child before it, of its kind.
    #[error("child {number} has the word {word:#010x}, expected block {expected:#x} and 1 to 3 triangles in a leaf")]
    Child {
        /// Its number.
        number: usize,
        /// Its child word.
        word: u32,
        /// The block where it had to be.
        expected: u32,
    },
}

impl Node8 {
    /// The node in a block.
    #[inline]
    pub fn of(block: &[u8; BYTES]) -> Self {
        let word = children(block);
        let children = array_of!(i => if block[FIRST_KIND + i] == 0 { 0 } else { word(i) });
        Self { boxes: quantised::boxes_of(slabs(block)), children }
    }

    /// The bytes of the node's block. Its boxes contain those of this node.
    ///
    /// # Errors
    /// A box that cannot be contained, or children that are not consecutive.
    pub fn to_bytes(&self) -> Result<[u8; BYTES], Node8Error> {
        let Self { boxes, children } = self;
        let mut block = [0; BYTES];
        for axis in 0..3 {
            let contained = quantised::contain(boxes, &children.map(|word| word != 0), axis, addend)?;
            let Some(Contained { base, exponent, bounds }) = contained else { continue };
            block[4 * axis..][..4].copy_from_slice(&base.to_le_bytes());
            block[12 + axis] = exponent;
            for (child, [min, max]) in bounds.into_iter().enumerate() {
                (block[bound_byte(axis, 0, child)], block[bound_byte(axis, 1, child)]) = (min, max);
            }
        }
        // Of nodes and of other children: the block of the first, and how many there are so far.
        let (mut firsts, mut counts, mut triangles) = ([None; 2], [0; 2], 0);
        for (number, &word) in children.iter().enumerate().filter(|(_, word)| **word != 0) {
            let (index, kind) = (word / BYTES as u32, word % BYTES as u32);
            let is_other = usize::from(kind != NODE_KIND);
            let expected = firsts[is_other].unwrap_or(index) + counts[is_other];
            let Some(byte) = kind_byte(kind, number, triangles).filter(|_| index == expected) else {
                return Err(Node8Error::Child { number, word, expected });
            };
            triangles += if kind <= WINDOW { kind } else { 0 };
            firsts[is_other].get_or_insert(index);
            counts[is_other] += 1;
            block[FIRST_KIND + number] = byte;
            block[15] |= u8::from(kind == NODE_KIND) << number;
        }
        for (place, first) in firsts.into_iter().enumerate() {
            block[16 + 4 * place..][..4].copy_from_slice(&first.unwrap_or(0).to_le_bytes());
        }
        Ok(block)
    }
}

/// The bounds of the boxes of a node: along each axis the minima, then the maxima.
#[inline(always)]
pub(crate) fn slabs(block: &[u8; BYTES]) -> [[[f32; CHILDREN]; 2]; 3] {
    array_of!(axis => {
        let base = f32::from_le_bytes([0, 1, 2, 3].map(|byte| block[4 * axis + byte]));
        let power = quantised::power(block[12 + axis]);
        array_of!(side => array_of!(child => {
            let bound = block[bound_byte(axis, side, child)];
            let is_missing = block[FIRST_KIND + child] == 0;
            base + if is_missing { quantised::MISSING[side] } else { addend(power, bound.into()) }
        }))
    })
}

/// The child word of the child with this number, from the four words of a node that tell its children.
#[inline(always)]
pub fn child<C: WordCircuit>(c: C, words: [Word<C, 32>; 4], number: Word<C, 3>) -> Word<C, 32> {
    let [nodes, others, low, high] = words;
    let bytes =
        |word: Word<C, 32>| [word.part::<0, 8>(), word.part::<8, 8>(), word.part::<16, 8>(), word.part::<24, 8>()];
    let ([a, b, d, e], [f, g, h, i]) = (bytes(low), bytes(high));
    let all = [a, b, d, e, f, g, h, i];
    let [one, two, four] = [number.part::<0, 1>(), number.part::<1, 1>(), number.part::<2, 1>()].map(|bit| bit.is(1));
    let pairs: [Word<C, 8>; 4] = array_of!(i => one.select(all[2 * i + 1], all[2 * i]));
    let quads = [two.select(pairs[1], pairs[0]), two.select(pairs[3], pairs[2])];
    let kind_byte = four.select(quads[1], quads[0]);
    let is_node = |byte: Word<C, 8>| byte.part::<5, 3>().is(1) & byte.part::<3, 2>().is(3);
    let own = is_node(kind_byte);
    c.label(format_args!("child_is_node"), &own);
    // Those before it that are nodes as it is, or others as it is.
    let mut rank: Word<C, 3> = c.word(0);
    for (place, other) in all[..7].iter().enumerate() {
        let is_alike = own.select(is_node(*other), !other.is(0) & !is_node(*other));
        let counts = c.word::<3>(place as u32).less(number) & is_alike;
        rank = rank.plus(Word::<C, 1>::new(c, c.word_of_bit(counts.value)).widened());
        label!(c: is_alike, counts, rank);
    }
    let base = own.select(nodes, others);
    let (upper, kind_bits): (_, Word<C, 7>) = (kind_byte.part::<5, 3>(), kind_byte.part::<0, 5>().widened());
    label!(c: pairs, quads, kind_byte, base, kind_bits);
    let of_other: Word<C, 7> = upper.is(4).select(
        Word::new(c, c.word_or(7, kind_bits.value, c.constant_word(7, 32))),
        upper.is(2).select(kind_bits, KINDS.word(c, INVALID)),
    );
    let of_leaf = upper.is(7).select(c.word(3), upper.is(3).select(c.word(2), c.word(1)));
    let is_leaf = kind_byte.part::<5, 1>().is(1) & (!kind_byte.part::<6, 1>().is(0) | kind_byte.part::<7, 1>().is(0));
    let without_node = is_leaf.select(of_leaf, of_other);
    let kind = own.select(KINDS.word(c, NODE_KIND), without_node);
    let kind = base.part::<25, 7>().is(0).select(kind, KINDS.word(c, INVALID));
    label!(c: is_leaf, of_leaf, of_other, without_node, kind);
    let block = base.part::<0, 25>().plus(rank.widened());
    let child = joined(block, kind);
    label!(c: block, child);
    child
}

/// The child words of a node in native arithmetic, by the number of the child: as [`child`], for one block.
#[inline(always)]
pub(crate) fn children(block: &[u8; BYTES]) -> impl Fn(usize) -> u32 {
    let kinds: [u8; CHILDREN] = array_of!(i => block[FIRST_KIND + i]);
    let mask = |counts: fn(u8) -> bool| (0..CHILDREN).fold(0_u32, |mask, i| mask | u32::from(counts(kinds[i])) << i);
    let (nodes, all) = (mask(|kind| kind >> 3 == NODE_BYTE >> 3), mask(|kind| kind != 0));
    let bases = [word(block, 4), word(block, 5)];
    move |number| {
        let (kind, is_node) = (u32::from(kinds[number]), nodes >> number & 1 == 1);
        let (base, alike) = if is_node { (bases[0], nodes) } else { (bases[1], all & !nodes) };
        let of_leaf = [INVALID, 1, kind % 32, 2, 32 + kind % 32, INVALID, INVALID, 3];
        let kind = if is_node { NODE_KIND } else { of_leaf[kind as usize / 32] };
        let rank = (alike & ((1 << number) - 1)).count_ones();
        let kind = if base >> 25 == 0 { kind } else { INVALID };
        base.wrapping_add(rank) << 7 | kind
    }
}

/// The child word that leads to a node once more, for the hits after those of this window.
#[inline(always)]
pub fn continuation<C: WordCircuit>(c: C, address: Word<C, 32>, window: Word<C, 2>) -> Word<C, 32> {
    joined(address.part::<7, 25>(), window.widened::<7>().plus(c.word(CONTINUATION)))
}

/// A child word that comes from memory or from the user, where nothing continues.
#[inline(always)]
pub fn given<C: WordCircuit>(c: C, word: Word<C, 32>) -> Word<C, 32> {
    let is_continuation = word.part::<6, 1>().is(1);
    joined(word.part::<7, 25>(), is_continuation.select(KINDS.word(c, INVALID), word.part::<0, 7>()))
}

fn joined<C: WordCircuit>(block: Word<C, 25>, kind: Word<C, 7>) -> Word<C, 32> {
    Word::new(block.circuit, block.circuit.word_join((25, block.value), (7, kind.value)))
}

bundle! {
    /// The outcome of a box job: four children of a node, near to far.
    pub struct Half<C> {
        /// Whether the child at each place is hit. Hits come first.
        pub hit: Flags<C, 4>,
        /// The distances.
        pub tmin: [Num<C>; 4],
        /// The number of the child at each place.
        pub box_index: [Word<C, 2>; 4],
    }

    /// The children of a window, near to far. That at place 3 stands for all after it.
    pub struct Window<C> {
        /// Whether there is one at each place.
        pub hit: Flags<C, 4>,
        /// The distances at places 1 to 3.
        pub tmin: [Num<C>; 3],
        /// The two lower bits of the number of the child at each place, of places 0 to 2.
        pub box_index: [Word<C, 2>; 4],
        /// The upper bit of that number.
        pub box_upper: Flags<C, 4>,
    }
}

/// A child of a node after its box was tested.
type Tested<C> = SortEntry<C, 3>;

/// Whether a child comes after another: it is farther, or as far with a higher number. What is not hit comes last,
/// whatever its distance.
#[inline(always)]
fn is_after<C: WordCircuit>(child: Tested<C>, other: Tested<C>) -> Bit<C> {
    let distance = other.tmin.compare(child.tmin);
    let is_lower = other.index.less(child.index);
    other.hit & (!child.hit | distance.less() | (distance.equal() & is_lower))
}

/// The comparisons that merge two sorted halves, by Batcher's odd-even network.
pub(crate) const MERGE: [(usize, usize); 9] = [(0, 4), (1, 5), (2, 6), (3, 7), (2, 4), (3, 5), (1, 2), (3, 4), (5, 6)];

/// The children of window 0, 1 or 2 among the outcomes of both jobs of a node.
#[inline(always)]
pub fn window<C: WordCircuit>(c: C, halves: [Half<C>; 2], window: Word<C, 2>) -> Window<C> {
    let of = |half: usize, i: usize| {
        let Half { hit, tmin, box_index } = halves[half];
        let upper = (1, c.constant_word(1, half as u32));
        let index = Word::new(c, c.word_join(upper, (2, box_index[i].value)));
        label!(c: index);
        Tested { hit: hit.0[i], tmin: tmin[i], index }
    };
    let mut all: [Tested<C>; CHILDREN] = array_of!(i => of(i / 4, i % 4));
    for (a, b) in MERGE {
        let (first, second) = (all[a], all[b]);
        let swaps = is_after(first, second);
        let (near, far) = (swaps.select(second, first), swaps.select(first, second));
        label!(c: swaps, near, far);
        (all[a], all[b]) = (near, far);
    }
    let none = Tested { hit: c.bit(false), ..all[7] };
    let (is_second, is_third) = (window.is(1), window.is(2));
    let at = |i: usize| {
        let after = |rank: usize| all.get(rank).copied().unwrap_or(none);
        is_third.select(after(i + 6), is_second.select(after(i + 3), all[i]))
    };
    let places: [Tested<C>; 4] = array_of!(i => at(i));
    label!(c: is_second, is_third, places);
    Window {
        hit: Flags(places.map(|place| place.hit)),
        tmin: [places[1].tmin, places[2].tmin, places[3].tmin],
        box_index: places.map(|place| place.index.part::<0, 2>()),
        box_upper: Flags(places.map(|place| place.index.part::<2, 1>().is(1))),
    }
}

/// The byte of a child of this kind, after so many triangles.
pub(crate) fn kind_byte(kind: u32, number: usize, triangles: u32) -> Option<u8> {
    match kind {
        NODE_KIND => Some(NODE_BYTE | number as u8),
        1..=WINDOW => Some(((1 << kind) - 1) << 5 | triangles as u8),
        _ if OTHER_KINDS.iter().any(|kinds| kinds.contains(&kind)) => Some((2 << (kind / 32)) << 5 | (kind % 32) as u8),
        _ => None,
    }
}

/// The byte of a bound of a child.
pub const fn bound_byte(axis: usize, is_max: usize, child: usize) -> usize {
    FIRST_BOUND + CHILDREN * (2 * axis + is_max) + child
}

/// The addend of a bound: exact, or infinite.
#[inline]
fn addend(power: f32, bound: u32) -> f32 {
    if bound == 0 { 0.0 } else { power * bound as f32 }
}

const _: () = assert!(bound_byte(2, 1, 7) < 80);
