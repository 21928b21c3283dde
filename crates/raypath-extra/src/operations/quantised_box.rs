//! A ray against four boxes with 8 bits a bound: compressed wide nodes (Ylitie, Karras, Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017; Vortex and RDNA 4 have such nodes as well).
//!
//! A plane at `origin + offset · scale` is at the distance `(origin - ray.origin) · inv + offset · (scale · inv)`, so that three
//! multiplications beside the 24 of the slabs suffice in stage 3. Adds 3 multipliers in stage 2 and 3 in stage 3, 16 adders in
//! stage 4, 20 comparators in stage 5 and 4 in stage 6; the sort is that of the four boxes.

mod node;
mod oracle;

pub use node::{OffsetBox, OffsetSlab, QuantiseError, QuantisedNode};
pub use oracle::judge;

use crate::draw;
use rand::{Rng, RngExt};
use raypath_lab::{Registered, Study, inventory};
use raypath_ops::{
    Binary32, Bit, Circuit, Flags, Kernels, Num, Operation, Portable, Ray, RayBoxOutput, Slab, SortEntry, Vec3, Word, array_of, bundle,
};

/// Which of four quantised boxes a ray hits, nearest first.
///
/// Rules as for boxes by `paper` (`docs/reference/semantics.md`): near and far change places where the sign bit of inv
/// is set; along
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

inventory::submit!(Registered(|| Study::of(QuantisedBox)
    .purpose("a ray against four boxes of 8 bits a bound: compressed wide nodes")
    .stimulus(stimulus)
    .oracle("exact rationals", judge)
    .into()));

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check;
    use raypath_ops::Aabb;

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
}
