//! Compressed nodes, and the encoding of boxes.

use crate::{Aabb, Binary32, Flags, Vec3, Word, bundle};
use thiserror::Error;

bundle! {
    /// A compressed node with up to four children.
    pub struct QuantisedNode<C> {
        /// The point at which all offsets are 0.
        pub origin: Vec3<C>,
        /// The distance of an offset of 1 along each axis: a power of two, so that products with it are exact. Other
        /// values are allowed.
        pub scale: Vec3<C>,
        /// The children's boxes.
        pub child: [OffsetBox<C>; 4],
        /// Whether each child is used. An unused child is a miss.
        pub used: Flags<C, 4>,
    }

    /// A box with bounds as offsets from the origin of its node.
    pub struct OffsetBox<C> {
        /// The bounds along x.
        pub x: OffsetSlab<C>,
        /// The bounds along y.
        pub y: OffsetSlab<C>,
        /// The bounds along z.
        pub z: OffsetSlab<C>,
    }

    /// The bounds of an [`OffsetBox`] along one axis.
    pub struct OffsetSlab<C> {
        /// The lesser bound, rounded down.
        pub min: Word<C, 8>,
        /// The greater bound, rounded up.
        pub max: Word<C, 8>,
    }
}

/// The reason why boxes cannot be encoded as a node.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum QuantiseError {
    /// The number of boxes is not 1 to 4.
    #[error("{0} boxes, expected 1 to 4")]
    Count(usize),
    /// A bound is infinite or NaN, or a min exceeds its max.
    #[error("box {child}, axis {axis}: from {min} to {max}, expected two finite numbers in order")]
    Bounds {
        /// The index of the box.
        child: usize,
        /// The axis; 0 is x.
        axis: usize,
        /// The lesser bound.
        min: f32,
        /// The greater bound.
        max: f32,
    },
}

impl QuantisedNode<Binary32> {
    /// Encodes one to four boxes. Each box is exactly inside its quantised box. The scale of each axis is the least
    /// power of two, at least 2⁻¹²⁶, with which all boxes fit.
    ///
    /// # Errors
    /// No box or more than four, a bound that is not finite, a min that exceeds its max.
    pub fn encode(boxes: &[Aabb<Binary32>]) -> Result<Self, QuantiseError> {
        if !(1..=4).contains(&boxes.len()) {
            return Err(QuantiseError::Count(boxes.len()));
        }
        let slabs = |axis: usize| {
            let slab = move |aabb: &Aabb<Binary32>| [aabb.x, aabb.y, aabb.z][axis];
            boxes.iter().map(slab).map(|slab| [slab.min, slab.max].map(f32::from)).enumerate()
        };
        let (mut origin, mut scale) = ([0.0_f32; 3], [0.0_f32; 3]);
        let mut offsets = [[[0, 0]; 3]; 4];
        for axis in 0..3 {
            let (mut least, mut greatest) = (f32::MAX, f32::MIN);
            for (child, [min, max]) in slabs(axis) {
                if !(min.is_finite() && max.is_finite() && min <= max) {
                    return Err(QuantiseError::Bounds { child, axis, min, max });
                }
                (least, greatest) = (least.min(min), greatest.max(max));
            }
            let mut unit = least_unit(least, greatest);
            while offset(least, greatest, unit)[1] > 255.0 {
                unit *= 2.0;
            }
            for (child, [min, max]) in slabs(axis) {
                offsets[child][axis] = [offset(least, min, unit)[0] as u32, offset(least, max, unit)[1] as u32];
            }
            (origin[axis], scale[axis]) = (least, unit);
        }
        let slab = |[min, max]: [u32; 2]| OffsetSlab { min: Word::truncate(min), max: Word::truncate(max) };
        let child = offsets.map(|[x, y, z]| OffsetBox { x: slab(x), y: slab(y), z: slab(z) });
        let used = Flags::new(std::array::from_fn(|i| i < boxes.len()));
        Ok(Self { origin: origin.into(), scale: scale.into(), child, used })
    }
}

/// A power of two that is less than the scale for an axis from `from` to `to`, or the least scale.
fn least_unit(from: f32, to: f32) -> f32 {
    let extent = f64::from(to) - f64::from(from);
    let power = f64::from_bits(extent.to_bits() & f64::INFINITY.to_bits());
    ((power / 512.0) as f32).max(f32::MIN_POSITIVE)
}

/// The distance from `from` to `to` in units of `unit`, a power of two, rounded down and rounded up.
fn offset(from: f32, to: f32, unit: f32) -> [f64; 2] {
    let (from, to) = (f64::from(from), f64::from(to));
    // The rounding error of the difference (Knuth's two-sum). It matters only if the rounded difference is an integer.
    let difference = to - from;
    let back = difference - to;
    let lost = (to - (difference - back)) - (from + back);
    let units = difference / f64::from(unit);
    let exactly = units.fract() == 0.0;
    let down = if exactly && lost < 0.0 { units - 1.0 } else { units.floor() };
    let up = if exactly && lost > 0.0 { units + 1.0 } else { units.ceil() };
    [down, up]
}
