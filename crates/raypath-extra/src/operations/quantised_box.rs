//! A ray against four boxes with 8 bits a bound: compressed wide nodes (Ylitie, Karras, Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017; Vortex and RDNA 4 have such nodes as well).
//!
//! A plane at `origin + offset · scale` is at the distance `(origin - ray.origin) · inv + offset · (scale · inv)`, so that the
//! 24 multiplications of stage 3 suffice. Adds 3 multipliers in stage 2 and 3 in stage 3, 16 adders in stage 4, 20 comparators
//! in stage 5 and 4 in stage 6; the sort is that of the four boxes.

use raypath_lab::{Registered, Study};
use crate::{draw, exact};
use num_rational::BigRational;
use rand::{Rng, RngExt};
use raypath_ops::{
    Aabb, Binary32, Bit, Circuit, Flags, Num, Operation, Place, Ray, RayBoxOutput, Slab, Vec3, Word, array_of, bundle,
};
use thiserror::Error;

/// Which of four quantised boxes a ray hits, nearest first.
///
/// Rules as for boxes by `paper` (`docs/semantics.md`): near and far change places where the sign bit of inv is set; along
/// an axis in which the direction is ±0 a slab says nothing but that the ray is beside it; a NaN distance drops out; hit
/// where tmin ≤ tmax; hits first, nearer first, ties by index. A box whose min exceeds its max is taken as it stands.
///
/// **How far it is not conservative.** With D = node.origin - ray.origin and P = offset · scale, a slab distance is within
/// 5 u (|D| + |P|) / |dir| of the exact one, u = 2⁻²⁴, where nothing over- or underflows. A box whose slabs the ray is in
/// together for less than twice that may be missed, and one that it misses by less may be hit. Unlike those of other
/// boxes, planes close to the ray's origin are not known better than those far from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuantisedBox;

bundle! {
    /// A node with four children.
    pub struct QuantisedNode<C> {
        /// Where offsets count from.
        pub origin: Vec3<C>,
        /// What an offset of 1 is worth along each axis: a power of two, so that nothing is rounded but sums and distances.
        /// Any other number is multiplied like any other.
        pub scale: Vec3<C>,
        /// The children's boxes.
        pub child: [OffsetBox<C>; 4],
        /// Which children there are; one that is not there is missed, whatever its box.
        pub used: Flags<C, 4>,
    }
}

bundle! {
    /// A box in offsets.
    pub struct OffsetBox<C> {
        /// Along x.
        pub x: OffsetSlab<C>,
        /// Along y.
        pub y: OffsetSlab<C>,
        /// Along z.
        pub z: OffsetSlab<C>,
    }
}

bundle! {
    /// One axis of a box in offsets.
    pub struct OffsetSlab<C> {
        /// The lesser bound, rounded down.
        pub min: Word<C, 8>,
        /// The greater bound, rounded up.
        pub max: Word<C, 8>,
    }
}

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
        // Where the ray runs along a slab, distances across it instead: inv is infinite.
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
                min: c.largest_or_zero(format_args!("near_{i}"), near),
                max: c.smallest_or_extent(format_args!("far_{i}"), far, ray.extent),
            }
        });
        c.label(format_args!("inside"), &inside);

        c.stage(6, "hit = tmin against tmax");
        let unsorted: [Place<C, 2>; 4] = array_of!(i => {
            let hit = node.used.0[i] & inside[i].min.compare(inside[i].max).less_or_equal();
            Place { hit, tmin: hit.select(inside[i].min, c.infinity()), index: c.word(i as u32) }
        });
        c.label(format_args!("unsorted"), &unsorted);

        c.stage(10, "sort the four by tmin, values and indices");
        let sorted = c.sort(unsorted);
        c.label(format_args!("sorted"), &sorted);

        let output = RayBoxOutput {
            is_intersect: Flags(array_of!(i => sorted[i].hit)),
            tmin: array_of!(i => sorted[i].tmin),
            box_index: array_of!(i => sorted[i].index),
        };
        (output, ())
    }
}

/// Where the ray enters a slab and where it leaves it. Along the slab: at no place, or beside it everywhere.
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

/// Why boxes make no node.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum QuantiseError {
    /// There are too many, or none.
    #[error("{0} boxes, expected 1 to 4")]
    Count(usize),
    /// A bound is infinite or NaN, or a box's min exceeds its max.
    #[error("box {child}, axis {axis}: from {min} to {max}, expected two finite numbers in order")]
    Bounds {
        /// Which box.
        child: usize,
        /// Along which axis: 0 is x.
        axis: usize,
        /// Its lesser bound.
        min: f32,
        /// Its greater bound.
        max: f32,
    },
}

impl QuantisedNode<Binary32> {
    /// The node of one to four boxes: each is inside its quantised box, exactly, and along each axis the scale is the least
    /// power of two, not below 2⁻¹²⁶, by which all boxes fit.
    ///
    /// # Errors
    /// No or more than four boxes, a bound that is not finite, a min that exceeds its max.
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

/// A power of two of which more than 255 are between two numbers, or the least that is a scale.
fn least_unit(from: f32, to: f32) -> f32 {
    let extent = f64::from(to) - f64::from(from);
    let power = f64::from_bits(extent.to_bits() & f64::INFINITY.to_bits());
    ((power / 512.0) as f32).max(f32::MIN_POSITIVE)
}

/// How many units, a power of two, `to` is above `from`: rounded down, and rounded up.
fn offset(from: f32, to: f32, unit: f32) -> [f64; 2] {
    let (from, to) = (f64::from(from), f64::from(to));
    // What the difference lost to rounding (Knuth's two-sum); it decides only where what is left is a whole number.
    let difference = to - from;
    let back = difference - to;
    let lost = (to - (difference - back)) - (from + back);
    let units = difference / f64::from(unit);
    let exactly = units.fract() == 0.0;
    let down = if exactly && lost < 0.0 { units - 1.0 } else { units.floor() };
    let up = if exactly && lost > 0.0 { units + 1.0 } else { units.ceil() };
    [down, up]
}

inventory::submit! {
    Registered(|| Study::of(QuantisedBox).purpose("a ray against four boxes of 8 bits a bound: compressed wide nodes").stimulus(stimulus).oracle("exact rationals", judge).into())
}

/// A node of one to four boxes and a ray towards one of them; or any node and any ray, at the edges of the format now and
/// then.
pub fn stimulus(rng: &mut impl Rng) -> QuantisedBoxInput<Binary32> {
    let boxes = [(); 4].map(|()| draw::aabb(rng));
    let count = rng.random_range(1..=4);
    let aimed_at = boxes[rng.random_range(0..count)];
    let target = draw::point_of(rng, aimed_at);
    let mut ray = draw::ray_at(rng, target);
    let any = QuantisedNode {
        origin: draw::three(|| draw::whole(rng)).into(),
        scale: draw::three(|| 2.0_f32.powi(rng.random_range(-9..-4))).into(),
        child: [(); 4].map(|()| {
            let [x, y, z] = draw::three(|| OffsetSlab {
                min: Word::truncate(rng.random_range(0..256)),
                max: Word::truncate(rng.random_range(0..256)),
            });
            OffsetBox { x, y, z }
        }),
        used: Flags::from_mask(rng.random_range(0..16)),
    };
    let node = if rng.random_bool(0.2) { Err(()) } else { QuantisedNode::encode(&boxes[..count]).map_err(|_| ()) };
    let mut node = node.unwrap_or(any);
    if rng.random_bool(0.05) {
        let field = [&mut node.origin.x, &mut node.scale.y, &mut ray.origin.z, &mut ray.inv.x, &mut ray.extent];
        *field[rng.random_range(0..5)] = draw::edge(rng).into();
    }
    QuantisedBoxInput { ray, node }
}

/// Slab distances in rationals: boxes that the ray hits by more than the bound must be hit, those that it misses by more must
/// be missed, and the distance of a hit must be within the bound. Which box stands where follows from what is answered.
///
/// # Errors
/// The first box about which the answer is wrong, or the first place that is out of order.
pub fn judge(job: &QuantisedBoxInput<Binary32>, answer: &RayBoxOutput<Binary32>) -> Result<(), String> {
    let hits = answer.is_intersect.to_array();
    let key = |place: usize| (answer.tmin[place].to_bits(), !hits[place], u32::from(answer.box_index[place]));
    let keys = [0, 1, 2, 3].map(key);
    if !keys.is_sorted() {
        return Err(format!("places (tmin, miss, index) {keys:x?} are out of order"));
    }
    let mut seen = [false; 4];
    for (tmin, miss, index) in keys {
        let index = index as usize;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("box {index} stands in two places"));
        }
        let infinite = f32::INFINITY.to_bits();
        if tmin > infinite || (miss && tmin != infinite) {
            return Err(format!("box {index}: tmin has the bits {tmin:08x}, expected a distance, +∞ of a miss"));
        }
        if !job.node.used.to_array()[index] {
            if miss {
                continue;
            }
            return Err(format!("box {index} is hit, but is not there"));
        }
        let Some(exact) = Exact::of(job, index) else { continue };
        let place = exact::value(Num::from_bits(tmin));
        let near = place.is_some_and(|tmin| exact.entry[0] <= tmin && tmin <= exact.entry[1]);
        match exact.hit() {
            Some(hit) if hit == miss => return Err(format!("box {index}: hit is {}, but exactly it is {hit}", !miss)),
            _ if !miss && !near => {
                let [least, greatest] = exact.entry;
                return Err(format!("box {index}: tmin is {:e}, expected {least} to {greatest}", f32::from_bits(tmin)));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Where the ray enters a box and where it leaves it: the least and the greatest distance that the answer may go by.
struct Exact {
    entry: [BigRational; 2],
    /// None is infinite.
    exit: Option<[BigRational; 2]>,
    /// Whether it is beside a slab along which it runs; none if too close to a plane to say.
    beside: Option<bool>,
}

impl Exact {
    /// None where a number is not finite, or so large or small that the bound does not hold.
    fn of(job: &QuantisedBoxInput<Binary32>, index: usize) -> Option<Self> {
        let QuantisedBoxInput { ray, node } = job;
        let (from, to) = (exact::values(ray.origin)?, exact::values(node.origin)?);
        let (dir, scale) = (exact::values(ray.dir)?, exact::values(node.scale)?);
        let zero = BigRational::default();
        let extent = match f32::from(ray.extent) {
            f32::INFINITY => None,
            _ => Some(exact::value(ray.extent)?),
        };
        let mut found = Self { entry: [zero.clone(), zero.clone()], exit: extent.map(|t| [t.clone(), t]), beside: Some(false) };
        let OffsetBox { x, y, z } = node.child[index];
        for (k, (slab, [direction, inverse])) in [x, y, z]
            .into_iter()
            .zip([[ray.dir.x, ray.inv.x], [ray.dir.y, ray.inv.y], [ray.dir.z, ray.inv.z]])
            .enumerate()
        {
            if f32::from(inverse).to_bits() != (1.0 / f32::from(direction)).to_bits() {
                return None;
            }
            let relative = &to[k] - &from[k];
            let planes = [slab.min, slab.max].map(|offset| {
                let steps = BigRational::from_integer(u32::from(offset).into()) * &scale[k];
                let bound = exact::power(-24)
                    * BigRational::from_integer(5.into())
                    * (exact::absolute(&relative) + exact::absolute(&steps));
                [&relative + steps, bound]
            });
            if planes.iter().flatten().any(|number| exact::absolute(number) > exact::power(60)) {
                return None;
            }
            if dir[k] == zero {
                found.along(planes);
            } else if (exact::power(-60)..exact::power(60)).contains(&exact::absolute(&dir[k])) {
                found.across(planes, &dir[k]);
            } else {
                return None;
            }
        }
        Some(found)
    }

    /// The slab's planes, as far from the ray as they are, with bounds.
    fn along(&mut self, [[min, min_bound], [max, max_bound]]: [[BigRational; 2]; 2]) {
        if min > min_bound || max < -&max_bound {
            self.beside = Some(true);
        } else if (min > -min_bound || max < max_bound) && self.beside == Some(false) {
            self.beside = None;
        }
    }

    /// The slab's planes likewise, for a ray that crosses them.
    fn across(&mut self, planes: [[BigRational; 2]; 2], direction: &BigRational) {
        let [near, far] = planes.map(|[place, bound]| {
            let bound = bound / exact::absolute(direction) + exact::power(-130);
            let distance = place / direction;
            [&distance - &bound, distance + bound]
        });
        let (near, far) = if *direction < BigRational::default() { (far, near) } else { (near, far) };
        let [least, greatest] = near;
        let [entry_least, entry_greatest] = self.entry.clone();
        self.entry = [exact::greater(entry_least, least), exact::greater(entry_greatest, greatest)];
        let [least, greatest] = far;
        self.exit = Some(match self.exit.take() {
            Some([exit_least, exit_greatest]) => {
                [exact::lesser(exit_least, least), exact::lesser(exit_greatest, greatest)]
            }
            None => [least, greatest],
        });
    }

    /// Whether it is hit, if by more than the bound.
    fn hit(&self) -> Option<bool> {
        let [entry_least, entry_greatest] = &self.entry;
        let misses = self.exit.as_ref().is_some_and(|[_, greatest]| entry_least > greatest);
        let hits = self.exit.as_ref().is_none_or(|[least, _]| entry_greatest <= least);
        match self.beside {
            Some(true) => Some(false),
            _ if misses => Some(false),
            Some(false) if hits => Some(true),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{check, jobs};
    use rand::SeedableRng;

    check!(QuantisedBox, QuantisedBoxInput, RayBoxOutput);

    fn run(ray: Ray<Binary32>, boxes: &[Aabb<Binary32>]) -> RayBoxOutput<Binary32> {
        let job = QuantisedBoxInput { ray, node: QuantisedNode::encode(boxes).expect("a node") };
        let (answer, ()) = QuantisedBox.run(Binary32, job, ());
        judge(&job, &answer).expect("a right answer");
        answer
    }

    #[test]
    fn by_hand() {
        let unit = |z: f32| Aabb::new([-1.0, -1.0, z], [1.0, 1.0, z + 1.0]);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 2.0], f32::INFINITY).expect("a ray");
        let answer = run(ray, &[unit(9.0), unit(1.0), unit(-5.0)]);
        assert_eq!(answer.is_intersect.to_array(), [true, true, false, false], "the fourth box is none");
        assert_eq!(answer.box_index.map(u32::from), [1, 0, 2, 3]);
        assert_eq!(answer.tmin.map(f32::from), [0.5, 4.5, f32::INFINITY, f32::INFINITY]);
    }

    /// From so far away that all planes of the node are at the same distance.
    #[test]
    fn children_that_are_not_there_are_missed() {
        let ray = Ray::new([0.5, 0.5, -1e12], [0.0, 0.0, 1.0], f32::INFINITY).expect("a ray");
        let answer = run(ray, &[Aabb::new([0.0; 3], [1.0; 3])]);
        assert_eq!(answer.is_intersect.to_array(), [true, false, false, false]);
        assert_eq!(answer.box_index.map(u32::from), [0, 1, 2, 3]);
    }

    /// A ray along an axis, or in a plane: beside a box, in its face, inside.
    #[test]
    fn along_slabs() {
        let cube = Aabb::new([1.0; 3], [2.0; 3]);
        for (x, hits) in [(0.875, false), (1.0, true), (1.5, true), (2.0, true), (2.125, false)] {
            for zero in [0.0, -0.0] {
                for (y, towards) in [(0.0, 1.0), (3.0, -1.0)] {
                    let ray = Ray::new([x, y, 1.5], [zero, towards, zero], 10.0).expect("a ray");
                    let answer = run(ray, &[cube, Aabb::new([8.0; 3], [9.0; 3])]);
                    assert_eq!(answer.is_intersect.to_array(), [hits, false, false, false], "{x} {zero} {towards}");
                    assert_eq!(f32::from(answer.tmin[0]), if hits { 1.0 } else { f32::INFINITY });
                }
            }
        }
    }

    #[test]
    fn encoding_encloses_and_is_tight() {
        let mut rng = rand_chacha::ChaCha8Rng::from_seed([7; 32]);
        for round in 0..5000 {
            let spread = [0..1, -3..4, -60..60, -149..127][round % 4].clone();
            let count = rng.random_range(1..=4);
            let boxes: Vec<Aabb<Binary32>> = (0..count)
                .map(|_| {
                    let [a, b] = [(); 2].map(|()| draw::three(|| draw::spread(&mut rng, spread.clone())));
                    let pick = |pick: fn(f32, f32) -> f32| std::array::from_fn(|k| pick(a[k], b[k]));
                    Aabb::new(pick(f32::min), pick(f32::max))
                })
                .collect();
            let node = QuantisedNode::encode(&boxes).expect("a node");
            for axis in 0..3 {
                let origin = &exact::values(node.origin).expect("finite")[axis];
                let scale = &exact::values(node.scale).expect("finite")[axis];
                assert!(f32::from(coordinates(node.scale)[axis]).to_bits() & 0x7f_ffff == 0, "a power of two");
                let offset = |word: Word<Binary32, 8>| BigRational::from_integer(u32::from(word).into());
                let one = exact::power(0);
                let mut greatest = BigRational::default();
                for (child, aabb) in node.child.iter().zip(&boxes) {
                    let slab = [aabb.x, aabb.y, aabb.z][axis];
                    let [min, max] = [slab.min, slab.max].map(|bound| exact::value(bound).expect("finite"));
                    let [low, high] = {
                        let slab = [child.x, child.y, child.z][axis];
                        [offset(slab.min), offset(slab.max)]
                    };
                    assert!(origin + &low * scale <= min && min < origin + (&low + &one) * scale, "{boxes:?} {node:?}");
                    assert!(max <= origin + &high * scale && origin + (&high - &one) * scale < max, "{boxes:?} {node:?}");
                    greatest = exact::greater(greatest, max - origin);
                }
                let half = scale / BigRational::from_integer(2.into()) * BigRational::from_integer(255.into());
                assert!(*scale <= exact::power(-126) || greatest > half, "a smaller scale would do: {boxes:?}");
            }
        }
    }

    #[test]
    fn boxes_that_make_no_node() {
        let unit = Aabb::new([0.0; 3], [1.0; 3]);
        let said = |boxes: &[Aabb<Binary32>]| QuantisedNode::encode(boxes).expect_err("no node").to_string();
        assert_eq!(said(&[]), "0 boxes, expected 1 to 4");
        assert_eq!(said(&[unit; 5]), "5 boxes, expected 1 to 4");
        let reversed = Aabb::new([0.0, 2.0, 0.0], [1.0; 3]);
        assert_eq!(said(&[unit, reversed]), "box 1, axis 1: from 2 to 1, expected two finite numbers in order");
        assert!(said(&[Aabb::new([0.0; 3], [1.0, 1.0, f32::INFINITY])]).contains("axis 2: from 0 to inf"));
        assert!(said(&[Aabb::new([f32::NAN, 0.0, 0.0], [1.0; 3])]).contains("axis 0: from NaN to 1"));
    }

    #[test]
    fn wrong_answers_are_refused() {
        let (mut certain, mut hits) = (0, 0);
        for job in jobs(stimulus, 1000) {
            let (right, ()) = QuantisedBox.run(Binary32, job, ());
            for place in 0..4 {
                let hit = right.is_intersect.to_array()[place];
                let index = u32::from(right.box_index[place]) as usize;
                let mut wrong = right;
                wrong.box_index[place] = right.box_index[(place + 1) % 4];
                assert!(judge(&job, &wrong).is_err(), "a box in two places");
                let used = job.node.used.to_array()[index];
                if !used || Exact::of(&job, index).is_some_and(|exact| exact.hit().is_some()) {
                    certain += 1;
                    hits += i32::from(hit);
                    let mut wrong = right;
                    wrong.is_intersect.0[place] = (!hit).into();
                    assert!(judge(&job, &wrong).is_err(), "{job:?} {wrong:?}");
                    let mut wrong = right;
                    wrong.tmin[place] = (f32::from(right.tmin[place]) * 1.01 + 0.1).into();
                    assert!(!hit || judge(&job, &wrong).is_err(), "{job:?} {wrong:?}");
                }
            }
        }
        assert!(certain > 3500 && (500..2500).contains(&hits), "{certain} of 4000 certain, {hits} hits");
    }
}
