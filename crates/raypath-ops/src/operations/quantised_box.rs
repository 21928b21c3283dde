//! A ray against four boxes with bounds of 8 bits, for compressed wide nodes (Ylitie, Karras, Laine, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017; Vortex and RDNA 4 have such nodes as
//! well).
//!
//! A plane at `origin + offset · scale` has the distance `(origin - ray.origin) · inv + offset · (scale · inv)`. Stage
//! 3 therefore takes only three multiplications in addition to the 24 of the slab method. A datapath with the operation
//! for a ray and four boxes needs these additional units: 3 multipliers each in stages 2 and 3, 16 adders in stage 4,
//! 20 comparators in stage 5 and 4 in stage 6.

use crate::{
    Aabb, Binary32, Bit, Circuit, Flags, Kernels, Num, Operation, Portable, Ray, RayBoxOutput, Slab, SortEntry, Vec3,
    Word, bundle,
};
use thiserror::Error;

/// Tests a ray against four quantised boxes and sorts the boxes by distance, the nearest hit first.
///
/// The rules are those of `paper` for boxes (`docs/reference/semantics.md`): near and far are exchanged if the sign bit
/// of inv is set; a NaN distance is ignored; a box is hit if tmin ≤ tmax; hits come before misses, nearer boxes before
/// farther ones, then in the order of indices. Along an axis in which the direction is ±0, a slab only excludes rays
/// outside it. Bounds with min greater than max are not reordered.
///
/// # Accuracy
/// The test is not conservative. With D = node.origin - ray.origin and P = offset · scale, the error of a slab distance
/// is at most 5 u (|D| + |P|) / |dir|, u = 2⁻²⁴, without overflow and underflow. A hit or miss is certain only if the
/// distances of entry and exit differ by more than twice this error. In contrast to other boxes, the error is not
/// smaller for planes near the origin of the ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuantisedBox;

bundle! {
    /// A ray and a node.
    pub struct QuantisedBoxInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The node.
        pub node: QuantisedNode<C>,
    }
}

impl Operation for QuantisedBox {
    const NAME: &'static str = "quantised_box";
    type Input<C: Circuit> = QuantisedBoxInput<C>;
    type Output<C: Circuit> = RayBoxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: QuantisedBoxInput<C>, _state: ()) -> (RayBoxOutput<C>, ()) {
        let QuantisedBoxInput { ray, node } = input;

        c.stage(2, "node - ray origin ; scale times inv");
        let [parallel, backwards] = [each(ray.dir, Num::is_zero), each(ray.inv, Num::sign_bit)];
        let relative = coordinates(node.origin - ray.origin);
        let (inv, scale) = (coordinates(ray.inv), coordinates(node.scale));
        // If the ray is parallel to a slab, inv is infinite; the coordinates across the slab are used instead.
        let step: [Num<C>; 3] = array_of!(k => parallel[k].select(scale[k], scale[k] * inv[k]));
        c.label(format_args!("relative"), &relative);
        c.label(format_args!("step"), &step);

        c.stage(3, "offsets times steps ; origin times inv");
        let base: [Num<C>; 3] = array_of!(k => parallel[k].select(relative[k], relative[k] * inv[k]));
        let steps: [[Slab<C>; 3]; 4] = array_of!(i => {
            let OffsetBox { x, y, z } = node.child[i];
            let child = [x, y, z];
            array_of!(k => Slab { min: child[k].min.number(), max: child[k].max.number() } * step[k])
        });
        c.label(format_args!("base"), &base);
        c.label(format_args!("steps"), &steps);

        c.stage(4, "slab distances");
        let distance: [[Slab<C>; 3]; 4] =
            array_of!(i => array_of!(k => Slab { min: steps[i][k].min + base[k], max: steps[i][k].max + base[k] }));
        c.label(format_args!("distance"), &distance);

        c.stage(5, "near and far by sign; tmin = max(near, 0), tmax = min(far, extent)");
        let inside: [Slab<C>; 4] = array_of!(i => {
            let ends: [Slab<C>; 3] = array_of!(k => near_and_far(c, distance[i][k], parallel[k], backwards[k]));
            let (near, far) = (array_of!(k => ends[k].min), array_of!(k => ends[k].max));
            Slab {
                min: Portable.largest_or_zero(c, format_args!("near_{i}"), near),
                max: Portable.smallest_or_extent(c, format_args!("far_{i}"), far, ray.extent),
            }
        });
        c.label(format_args!("inside"), &inside);

        c.stage(6, "hit = tmin against tmax");
        let unsorted: [SortEntry<C, 2>; 4] = array_of!(i => {
            let hit = node.used.0[i] & inside[i].min.compare(inside[i].max).less_or_equal();
            SortEntry { hit, tmin: hit.select(inside[i].min, c.infinity()), index: c.word(i as u32) }
        });
        c.label(format_args!("unsorted"), &unsorted);

        c.stage(10, "sort the four by tmin, values and indices");
        let sorted = Portable.sort(c, unsorted);
        c.label(format_args!("sorted"), &sorted);

        (RayBoxOutput::of_sorted(&sorted), ())
    }
}

/// The distances at which the ray enters and leaves a slab. If the ray is parallel to the slab, the interval is
/// infinite for a ray inside and empty for a ray outside.
#[inline(always)]
fn near_and_far<C: Circuit>(c: C, distance: Slab<C>, parallel: Bit<C>, backwards: Bit<C>) -> Slab<C> {
    let Slab { min, max } = distance;
    let (near, far) = backwards.exchange(min, max);
    let beyond_max = max.sign_bit() & !max.is_zero() & !max.is_nan();
    Slab {
        min: parallel.select(min.is_above_zero().select(c.infinity(), -c.infinity()), near),
        max: parallel.select(beyond_max.select(-c.infinity(), c.infinity()), far),
    }
}

#[inline(always)]
fn coordinates<C: Circuit>(v: Vec3<C>) -> [Num<C>; 3] {
    [v.x, v.y, v.z]
}

#[inline(always)]
fn each<C: Circuit>(v: Vec3<C>, test: impl Fn(Num<C>) -> Bit<C>) -> [Bit<C>; 3] {
    [test(v.x), test(v.y), test(v.z)]
}

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

/// Boxes that cannot be encoded as a node: what was found, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct QuantiseError(String);

impl QuantisedNode<Binary32> {
    /// Encodes one to four boxes. Each box is exactly inside its quantised box. The scale of each axis is the least
    /// power of two, at least 2⁻¹²⁶, with which all boxes fit.
    ///
    /// # Errors
    /// No box or more than four, a bound that is not finite, a min that exceeds its max.
    pub fn encode(boxes: &[Aabb<Binary32>]) -> Result<Self, QuantiseError> {
        if !(1..=4).contains(&boxes.len()) {
            return Err(QuantiseError(format!("{} boxes, expected 1 to 4", boxes.len())));
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
                    let expected = "expected two finite numbers in order";
                    let problem = format!("box {child}, axis {axis}: from {min} to {max}, {expected}");
                    return Err(QuantiseError(problem));
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
