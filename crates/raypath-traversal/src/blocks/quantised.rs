//! Quantised nodes: what their bounds mean, and how boxes become such a node.
//!
//! A bound is the sum, correctly rounded to binary32, of the node's base and an addend. The addend of a bound q, with
//! the biased exponent E of its axis, is the positive number with these fields in binary32: exponent E and fraction
//! q · 2¹⁵, that is 2^(E - 127) · (1 + q / 256). With E = 0 it is 0, and with E = 255 it is infinity. A child word of
//! kind 0 has the addends +∞ for its minima and -∞ for its maxima, so that no ray hits its box.

use super::{BOX_WORDS, NODE_KIND, Node, NodeKind, bounds, word};
use raypath_ops::{Aabb, Binary32, array_of};
use thiserror::Error;

/// The bytes of a block.
const BYTES: usize = NodeKind::Quantised.block_bytes() as usize;
/// The words of a node's block that its bounds need.
pub const WORDS: usize = 10;
/// The bounds of four boxes.
pub const BOUNDS: usize = 4 * BOX_WORDS;
/// The byte with the first bound.
pub(crate) const FIRST_BOUND: usize = 16;

/// Whether a child word is not of kind 0.
fn exists(child: u32) -> bool {
    !child.is_multiple_of(NodeKind::Quantised.block_bytes())
}

/// The axis of a bound, and whether it is a maximum.
pub const fn place(bound: usize) -> (usize, bool) {
    (bound % 3, bound % BOX_WORDS >= 3)
}

impl Node {
    /// The quantised node in a block.
    #[inline]
    pub fn of_quantised(block: &[u8; BYTES]) -> Self {
        let children = array_of!(child => word(block, NodeKind::Quantised.child_word() + child));
        Self { boxes: boxes_of(slabs(block)), children }
    }

    /// The bytes of a quantised node with these children. Its boxes contain those of this node.
    ///
    /// # Errors
    /// A box that cannot be contained: it is not finite or too large.
    pub fn to_quantised_bytes(&self) -> Result<[u8; BYTES], BoxError> {
        let mut block = [0; BYTES];
        let Self { boxes, children } = self;
        let exist = children.map(exists);
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

/// The bounds of the boxes of a quantised node: along each axis the minima, then the maxima.
#[inline(always)]
pub(crate) fn slabs(block: &[u8; BYTES]) -> [[[f32; 4]; 2]; 3] {
    let exist: [bool; 4] = array_of!(child => exists(word(block, NodeKind::Quantised.child_word() + child)));
    array_of!(axis => {
        let (base, power) = (f32::from_bits(word(block, axis)), power(block[12 + axis]));
        array_of!(side => array_of!(child => {
            let bound = block[FIRST_BOUND + BOX_WORDS * child + 3 * side + axis];
            base + if exist[child] { addend(power, bound.into()) } else { MISSING[side] }
        }))
    })
}

/// The bounds of a box that no ray hits.
pub(super) const MISSING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Boxes by their minima and maxima along each axis.
pub(super) fn boxes_of<const N: usize>(slabs: [[[f32; N]; 2]; 3]) -> [Aabb<Binary32>; N] {
    let corner = |side: usize, child: usize| slabs.map(|slab| slab[side][child]);
    array_of!(child => Aabb::new(corner(0, child), corner(1, child)))
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
