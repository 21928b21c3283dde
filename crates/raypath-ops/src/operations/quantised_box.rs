//! A ray against four boxes with 8 bits a bound: compressed wide nodes (Ylitie, Karras, Laine, "Efficient Incoherent
//! Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017; Vortex and RDNA 4 have such nodes as well).
//!
//! A plane at `origin + offset · scale` is at the distance `(origin - ray.origin) · inv + offset · (scale · inv)`, so
//! that three multiplications beside the 24 of the slabs suffice in stage 3. Adds 3 multipliers in stage 2 and 3 in
//! stage 3, 16 adders in stage 4, 20 comparators in stage 5 and 4 in stage 6; the sort is that of the four boxes.

mod node;

pub use node::{OffsetBox, OffsetSlab, QuantiseError, QuantisedNode};

use crate::{Bit, Circuit, Flags, Kernels, Num, Operation, Portable, Ray, RayBoxOutput, Slab, SortEntry, Vec3, bundle};

/// Which of four quantised boxes a ray hits, nearest first.
///
/// Rules as for boxes by `paper` (`docs/reference/semantics.md`): near and far change places where the sign bit of inv
/// is set; along
/// an axis in which the direction is ±0 a slab says nothing but that the ray is beside it; a NaN distance drops out;
/// hit where tmin ≤ tmax; hits first, nearer first, ties by index. A box whose min exceeds its max is taken as it
/// stands.
///
/// **How far it is not conservative.** With D = node.origin - ray.origin and P = offset · scale, a slab distance is
/// within 5 u (|D| + |P|) / |dir| of the exact one, u = 2⁻²⁴, where nothing over- or underflows. A box whose slabs the
/// ray is in together for less than twice that may be missed, and one that it misses by less may be hit. Unlike those
/// of other boxes, planes close to the ray's origin are not known better than those far from it.
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
