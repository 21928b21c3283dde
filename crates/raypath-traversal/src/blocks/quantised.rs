//! Quantised nodes: what their bounds mean, and how boxes become such a node.
//!
//! A bound is the sum, correctly rounded to binary32, of the node's base and an addend. The addend of a bound q, with
//! the biased exponent E of its axis, is the positive number with these fields in binary32: exponent E and fraction
//! q · 2¹⁵, that is 2^(E - 127) · (1 + q / 256). With E = 0 it is 0, and with E = 255 it is infinity. A child word of
//! kind 0 has the addends +∞ for its minima and -∞ for its maxima, so that no ray hits its box.
//!
//! [`operands`] takes a node apart, as a function over an abstract circuit: the models add the operands by the
//! machine's binary32, the hardware by its adders. Decoding takes no other arithmetic.

use super::{BOX_WORDS, NODE_KIND, Node, NodeKind, bounds, word};
use crate::words::{WordCircuit, WordMethods};
use raypath_ops::{Aabb, Binary32, Bit, Flags, Num, Word};
use thiserror::Error;

/// The bytes of a block.
const BYTES: usize = NodeKind::Quantised.block_bytes() as usize;
/// The words of a node's block that its bounds need.
pub const WORDS: usize = 10;
/// The bounds of four boxes.
pub const BOUNDS: usize = 4 * BOX_WORDS;
/// The byte with the first bound.
const FIRST_BOUND: usize = 16;

/// The operands of the additions that decode a node. The bounds are in the order of memory: for each child the minima,
/// then the maxima.
pub struct Operands<C: WordCircuit> {
    /// The base of each axis.
    pub base: [Num<C>; 3],
    /// The addend of each axis for a bound of 0.
    pub power: [Num<C>; 3],
    /// The leading bits of the fraction of each addend.
    pub fraction: [Word<C, 8>; BOUNDS],
    /// Whether each child exists.
    pub exists: Flags<C, 4>,
}

/// The operands in the first words of a node's block, of which `exists` children exist.
#[inline]
pub fn operands<C: WordCircuit>(c: C, words: [Word<C, 32>; WORDS], exists: Flags<C, 4>) -> Operands<C> {
    let number = |word: Word<C, 32>| Num::new(c, c.number_of_bits(word.value));
    let exponents = [words[3].part::<0, 8>(), words[3].part::<8, 8>(), words[3].part::<16, 8>()];
    let power = |exponent: Word<C, 8>| {
        let low = (23, c.constant_word(23, 0));
        let high = (9, c.word_join((1, c.constant_word(1, 0)), (8, exponent.value)));
        number(Word::new(c, c.word_join(high, low)))
    };
    let byte = |place: usize| {
        let word = words[place / 4];
        match place % 4 {
            0 => word.part::<0, 8>(),
            1 => word.part::<8, 8>(),
            2 => word.part::<16, 8>(),
            _ => word.part::<24, 8>(),
        }
    };
    Operands {
        base: [number(words[0]), number(words[1]), number(words[2])],
        power: exponents.map(power),
        fraction: std::array::from_fn(|bound| byte(FIRST_BOUND + bound)),
        exists,
    }
}

/// Whether a child word is not of kind 0.
#[inline]
pub fn exists<C: WordCircuit>(child: Word<C, 32>) -> Bit<C> {
    let (c, kind) = (child.circuit, NodeKind::Quantised.block_bytes() - 1);
    !Word::<C, 32>::new(c, c.word_and(32, child.value, c.constant_word(32, kind))).is(0)
}

/// The axis of a bound, and whether it is a maximum.
pub const fn place(bound: usize) -> (usize, bool) {
    (bound % 3, bound % BOX_WORDS >= 3)
}

impl Node {
    /// The quantised node in a block.
    #[inline]
    pub fn of_quantised(block: &[u8; BYTES]) -> Self {
        let children = std::array::from_fn(|child| word(block, NodeKind::Quantised.child_word() + child));
        let exist = Flags(children.map(|child| exists(Word::<Binary32, 32>::truncate(child))));
        let words = std::array::from_fn(|index| Word::truncate(word(block, index)));
        let Operands { base, power, fraction, exists: Flags(exists) } = operands(Binary32, words, exist);
        let bound = |number: usize| {
            let (axis, is_max) = place(number);
            let infinite = if is_max { f32::NEG_INFINITY } else { f32::INFINITY };
            let exists = bool::from(exists[number / BOX_WORDS]);
            f32::from(base[axis]) + if exists { addend(power[axis].into(), fraction[number].value) } else { infinite }
        };
        let corner = |first: usize| std::array::from_fn(|axis| bound(first + axis));
        let boxes = std::array::from_fn(|child| Aabb::new(corner(BOX_WORDS * child), corner(BOX_WORDS * child + 3)));
        Self { boxes, children }
    }

    /// The bytes of a quantised node with these children. Its boxes contain those of this node.
    ///
    /// # Errors
    /// A box that cannot be contained: it is not finite or too large.
    pub fn to_quantised_bytes(&self) -> Result<[u8; BYTES], BoxError> {
        let mut block = [0; BYTES];
        let Self { boxes, children } = self;
        let exist = children.map(|child| bool::from(exists(Word::<Binary32, 32>::truncate(child))));
        for axis in 0..3 {
            let Some(Contained { base, exponent, bounds }) = contain(boxes, &exist, axis, addend)? else { continue };
            block[4 * axis..][..4].copy_from_slice(&base.to_le_bytes());
            block[12 + axis] = exponent;
            for (child, [min, max]) in bounds.into_iter().enumerate().take(boxes.len()) {
                let place = FIRST_BOUND + BOX_WORDS * child + axis;
                (block[place], block[place + 3]) = (min, max);
            }
        }
        let words = block[4 * NodeKind::Quantised.child_word()..].as_chunks_mut().0;
        words.iter_mut().zip(children).for_each(|(bytes, child)| *bytes = child.to_le_bytes());
        Ok(block)
    }
}

/// The bounds of up to eight boxes along an axis.
pub(super) struct Contained {
    pub base: f32,
    pub exponent: u8,
    /// The lesser and the greater bound of each box; 0 for one that does not exist.
    pub bounds: [[u8; 2]; 8],
}

/// The addend of a bound: of a power of two, and the 8 bits of the bound.
pub(super) type Addend = fn(f32, u32) -> f32;

/// The bounds with the least exponent that contain the boxes that exist along an axis; none if none exists.
pub(super) fn contain(
    boxes: &[Aabb<Binary32>],
    exist: &[bool],
    axis: usize,
    addend: Addend,
) -> Result<Option<Contained>, BoxError> {
    let slab = |child: usize| (child, bounds(&boxes[child])[axis], bounds(&boxes[child])[axis + 3]);
    let slabs = || (0..boxes.len()).filter(|child| exist[*child]).map(slab);
    let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
    for (child, min, max) in slabs() {
        if !(min.is_finite() && max.is_finite() && min <= max) {
            return Err(BoxError { child, axis, min, max });
        }
        (least, greatest) = (least.min(min), greatest.max(max));
    }
    if least > greatest {
        return Ok(None);
    }
    let farthest = || slabs().max_by(|a, b| a.2.abs().max(a.1.abs()).total_cmp(&b.2.abs().max(b.1.abs())));
    let Some(scale) = Scale::of(least, greatest, addend) else {
        return farthest().map_or(Ok(None), |(child, min, max)| Err(BoxError { child, axis, min, max }));
    };
    let mut bounds = [[0; 2]; 8];
    for (child, min, max) in slabs() {
        bounds[child] = [scale.greatest_at_most(min), scale.least_at_least(max)];
    }
    Ok(Some(Contained { base: scale.base, exponent: scale.exponent, bounds }))
}

/// The error of a box that no quantised node can contain.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "box {child} from {min:e} to {max:e} along axis {axis}, expected finite bounds, and boxes of a node that lie \
     within 2^127 of each other"
)]
pub struct BoxError {
    /// The number of the child.
    pub child: usize,
    /// The axis: 0, 1 or 2.
    pub axis: usize,
    /// Its lesser bound.
    pub min: f32,
    /// Its greater bound.
    pub max: f32,
}

/// An axis of a node.
#[derive(Clone, Copy)]
struct Scale {
    base: f32,
    exponent: u8,
    addend: Addend,
}

impl Scale {
    /// The scale with the least exponent by which bounds from `least` to `greatest` can be contained.
    fn of(least: f32, greatest: f32, addend: Addend) -> Option<Self> {
        let extent = f64::from(greatest) - f64::from(least);
        // 255 steps of this exponent are less than the extent, if it is normal, whatever the addend.
        let first = ((extent.to_bits() >> 52) as i32 - 1023 + 127 - 8).clamp(1, 254) as u8;
        (first..=254).find_map(|exponent| {
            let nearest = Self { base: least - addend(power(exponent), 0), exponent, addend };
            let lower = Self { base: nearest.base.next_down(), ..nearest };
            let fits = |scale: &Self| scale.bound(0) <= least && scale.bound(255) >= greatest && scale.base.is_finite();
            [nearest, lower].into_iter().find(fits)
        })
    }

    fn bound(self, q: u8) -> f32 {
        self.base + (self.addend)(power(self.exponent), q.into())
    }

    /// The greatest bound that is at most `min`. Bound 0 is.
    fn greatest_at_most(self, min: f32) -> u8 {
        (0..8).rev().map(|bit| 1 << bit).fold(0, |q, bit| if self.bound(q | bit) <= min { q | bit } else { q })
    }

    /// The least bound that is at least `max`. Bound 255 is.
    fn least_at_least(self, max: f32) -> u8 {
        (0..8).rev().map(|bit| 1 << bit).fold(255, |q, bit| if self.bound(q & !bit) >= max { q & !bit } else { q })
    }
}

/// The number with this biased exponent and without a fraction.
pub(super) fn power(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << 23)
}

/// The addend with these leading bits of its fraction.
#[inline]
fn addend(power: f32, fraction: u32) -> f32 {
    if power == 0.0 || power == f32::INFINITY { power } else { f32::from_bits(power.to_bits() | fraction << 15) }
}

const _: () = assert!(NODE_KIND < NodeKind::Quantised.block_bytes() && 4 * WORDS == FIRST_BOUND + BOUNDS);
