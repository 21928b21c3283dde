//! Ray against four boxes: the slab method (Table VII, column Quadbox).

use crate::alike::Alike;
use crate::binary32::Binary32;
use crate::bundle::bundle;
use crate::circuit::Circuit;
use crate::geometry::Aabb;
use crate::handle::{Bit, Flags, Num, Word};
use crate::operation::Operation;
use crate::ray::Ray;
use crate::rules::{Interval, Place, Rules};

/// Which of four boxes a ray hits, nearest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayBox {
    /// The rules on the edges.
    pub rules: Rules,
}

/// The same under the rules `paper`, missing no box for a rounding: `tmax` is made larger by [`WIDENING_ULPS`] before it
/// is compared. `docs/reference/semantics.md` says what that promises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayBoxConservative;

/// By how many units in the last place of 1 the factor of [`RayBoxConservative`] exceeds 1.
///
/// A slab distance is three roundings away from the exact one: of the inverse, of the difference, of the product. Two
/// distances that are equal may so come to differ by a factor of (1 + 2u)^3, where u is half a unit in the last place of
/// 1: by three units and next to nothing. Two units (Ize, "Robust BVH Ray Traversal", JCGT 2013) are enough where the
/// inverse counts as exact.
pub const WIDENING_ULPS: u32 = 3;

bundle! {
    /// A ray and four boxes.
    pub struct RayBoxInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 4],
    }
}

bundle! {
    /// The four boxes by distance: hits before misses, nearer before farther.
    pub struct RayBoxOutput<C> {
        /// Whether the box in each place is hit.
        pub is_intersect: Flags<C, 4>,
        /// Where the ray enters it, in units of the direction's length; +∞ for a miss.
        pub tmin: [Num<C>; 4],
        /// Which of the job's boxes it is.
        pub box_index: [Word<C, 2>; 4],
    }
}

impl Operation for RayBox {
    const NAME: &'static str = "quadbox";
    type Input<C: Circuit> = RayBoxInput<C>;
    type Output<C: Circuit> = RayBoxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: RayBoxInput<C>, _state: ()) -> (RayBoxOutput<C>, ()) {
        (nearest_first(c, input, Slabs { rules: self.rules, is_conservative: false }), ())
    }
}

impl Operation for RayBoxConservative {
    const NAME: &'static str = RayBox::NAME;
    type Input<C: Circuit> = RayBoxInput<C>;
    type Output<C: Circuit> = RayBoxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: RayBoxInput<C>, _state: ()) -> (RayBoxOutput<C>, ()) {
        (nearest_first(c, input, Slabs { rules: Rules::Paper, is_conservative: true }), ())
    }
}

#[inline(always)]
fn nearest_first<C: Circuit>(c: C, input: RayBoxInput<C>, slabs: Slabs) -> RayBoxOutput<C> {
    let RayBoxInput { ray, aabb } = input;

    let hits = c.alike(&slabs, &ray, &aabb);
    let unsorted: [Place<C, 2>; 4] = array_of!(i => Place { hit: hits[i].hit, tmin: hits[i].tmin, index: c.word(i as u32) },
    );
    c.label(format_args!("unsorted"), &unsorted);

    c.stage(10, "sort the four by tmin, values and indices");
    let sorted = slabs.rules.sort(c, unsorted);
    c.label(format_args!("sorted"), &sorted);

    RayBoxOutput {
        is_intersect: Flags(array_of!(i => sorted[i].hit)),
        tmin: array_of!(i => sorted[i].tmin),
        box_index: array_of!(i => sorted[i].index),
    }
}

/// The slab method, for each box alike, in stages 2 to 5: 6 adders, 6 multipliers, 6 comparators and one more for each
/// box (by the rules `paper`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slabs {
    /// The rules on the edges.
    pub rules: Rules,
    /// Boxes are widened as [`RayBoxConservative`] has it, with a multiplier a box in stage 5, and compared in stage 6.
    pub is_conservative: bool,
}

bundle! {
    /// Whether and where a ray enters a box.
    pub struct Entry<C> {
        /// Whether it does.
        pub hit: Bit<C>,
        /// Where; +∞ if it does not.
        pub tmin: Num<C>,
    }
}

impl Alike for Slabs {
    type Shared = Ray<Binary32>;
    type Each = Aabb<Binary32>;
    type Answer = Entry<Binary32>;

    #[inline(always)]
    fn run<C: Circuit, const N: usize>(&self, c: C, ray: &Ray<C>, aabb: &[Aabb<C>; N]) -> [Entry<C>; N] {
        c.stage(2, "every box bound - origin");
        let relative: [Aabb<C>; N] = array_of!(i => aabb[i] - ray.origin);
        c.label(format_args!("relative"), &relative);

        c.stage(3, "times inv: slab distances");
        let distance: [Aabb<C>; N] = array_of!(i => relative[i] * ray.inv);
        c.label(format_args!("distance"), &distance);

        c.stage(4, "near and far by sign; tmin = max(near, 0), tmax = min(far, extent)");
        let inside: [Interval<C>; N] = array_of!(i => {
                let Aabb { x, y, z } = distance[i];
                let slabs = [(x, ray.dir.x, ray.inv.x), (y, ray.dir.y, ray.inv.y), (z, ray.dir.z, ray.inv.z)];
                let backwards: [Bit<C>; 3] = array_of!(k => self.rules.runs_backwards(c, slabs[k].1, slabs[k].2));
                let ends: [(Num<C>, Num<C>); 3] =
                    array_of!(k => backwards[k].exchange(slabs[k].0.min, slabs[k].0.max));
                let (near, far): ([Num<C>; 3], [Num<C>; 3]) = (array_of!(k => ends[k].0), array_of!(k => ends[k].1));
                for (k, axis) in ["x", "y", "z"].iter().enumerate() {
                    c.label(format_args!("near_{i}_{axis}"), &near[k]);
                    c.label(format_args!("far_{i}_{axis}"), &far[k]);
                }
                Interval {
                    tmin: self.rules.entry(c, format_args!("near_{i}"), near),
                    tmax: self.rules.exit(c, format_args!("far_{i}"), far, ray.extent),
                }
            },
        );
        c.label(format_args!("inside"), &inside);

        let inside = if self.is_conservative {
            c.stage(5, "tmax widened");
            let factor = Num::new(c, c.one_plus_ulps(WIDENING_ULPS));
            let widened: [Interval<C>; N] =
                array_of!(i => Interval { tmin: inside[i].tmin, tmax: inside[i].tmax * factor });
            c.label(format_args!("widened"), &widened);
            c.stage(6, "hit = tmin against tmax");
            widened
        } else {
            c.stage(5, "hit = tmin against tmax");
            inside
        };
        array_of!(i => {
            let hit = self.rules.box_hit(inside[i]);
            Entry { hit, tmin: hit.select(inside[i].tmin, c.infinity()) }
        })
    }
}
