//! Ray against four boxes: the slab method (Table VII, column Quadbox).

use crate::operation::run_portable;
use crate::ray_box_bounds::outer_intervals;
use crate::rules::Interval;
use crate::{
    Aabb, Binary32, Bit, Circuit, Flags, Kernels, LaneMap, Num, Operation, Portable, Ray, Rules, SortEntry, Word,
    bundle,
};

/// Tests a ray against four boxes and sorts the boxes by distance, the nearest hit first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayBox {
    /// The rules for special cases.
    pub rules: Rules,
}

/// [`RayBox`] under the rules `paper`, widened so that rounding never causes a miss: `tmax` is multiplied by 1 +
/// [`WIDENING_ULPS`] units in the last place before it is compared. `docs/reference/semantics.md` states the guarantee.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayBoxConservative;

/// The number of units in the last place of 1 by which the factor of [`RayBoxConservative`] exceeds 1.
///
/// A slab distance has three roundings: of the inverse, of the difference, and of the product. Two equal exact
/// distances may therefore differ by a factor of (1 + 2u)^3, where u is half a unit in the last place of 1: slightly
/// more than three units. Two units (Ize, "Robust BVH Ray Traversal", JCGT 2013) are enough if the inverse counts as
/// exact.
pub const WIDENING_ULPS: u32 = 3;

bundle! {
    /// A ray and four boxes.
    pub struct RayBoxInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 4],
    }

    /// The four boxes sorted by distance: hits before misses, nearer before farther.
    pub struct RayBoxOutput<C> {
        /// Whether the box at each position of the order is hit.
        pub is_intersect: Flags<C, 4>,
        /// The distance at which the ray enters the box, in units of the direction's length; +∞ for a miss.
        pub tmin: [Num<C>; 4],
        /// The index of the box in the job.
        pub box_index: [Word<C, 2>; 4],
    }
}

impl Operation for RayBox {
    const NAME: &'static str = "quadbox";
    type Input<C: Circuit> = RayBoxInput<C>;
    type Output<C: Circuit> = RayBoxOutput<C>;
    type State<C: Circuit> = ();

    run_portable!();

    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        c: C,
        kernels: K,
        input: RayBoxInput<C>,
        _state: (),
    ) -> (RayBoxOutput<C>, ()) {
        (nearest_first(c, kernels, input, Slabs { rules: self.rules, is_conservative: false }), ())
    }
}

impl Operation for RayBoxConservative {
    const NAME: &'static str = RayBox::NAME;
    type Input<C: Circuit> = RayBoxInput<C>;
    type Output<C: Circuit> = RayBoxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: RayBoxInput<C>, _state: ()) -> (RayBoxOutput<C>, ()) {
        (nearest_first(c, Portable, input, Slabs { rules: Rules::Paper, is_conservative: true }), ())
    }
}

#[inline(always)]
fn nearest_first<C: Circuit>(c: C, kernels: impl Kernels<C>, input: RayBoxInput<C>, slabs: Slabs) -> RayBoxOutput<C> {
    let RayBoxInput { ray, aabb } = input;

    let hits = kernels.map(c, &slabs, &ray, &aabb);
    let unsorted: [SortEntry<C, 2>; 4] =
        array_of!(i => SortEntry { hit: hits[i].hit, tmin: hits[i].tmin, index: c.word(i as u32) });
    c.label(format_args!("unsorted"), &unsorted);

    c.stage_or(10, 8, "sort the four by tmin, values and indices");
    let sorted = slabs.rules.sort(c, kernels, unsorted);
    c.label(format_args!("sorted"), &sorted);

    RayBoxOutput::of_sorted(&sorted)
}

impl<C: Circuit> RayBoxOutput<C> {
    #[inline(always)]
    pub(crate) fn of_sorted(sorted: &[SortEntry<C, 2>; 4]) -> Self {
        Self {
            is_intersect: Flags(array_of!(i => sorted[i].hit)),
            tmin: array_of!(i => sorted[i].tmin),
            box_index: array_of!(i => sorted[i].index),
        }
    }
}

/// The slab method for one ray and several boxes, in stages 2 to 5. Per box it takes 6 adders, 6 multipliers and 7
/// comparators under the rules `paper`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slabs {
    /// The rules for special cases.
    pub rules: Rules,
    /// Widens boxes as [`RayBoxConservative`] does: one multiplier per box in stage 5; the comparison moves to stage 6.
    pub is_conservative: bool,
}

bundle! {
    /// The result of testing a ray against one box.
    pub struct Entry<C> {
        /// The ray hits the box.
        pub hit: Bit<C>,
        /// The distance at which the ray enters the box; +∞ for a miss.
        pub tmin: Num<C>,
    }
}

impl LaneMap for Slabs {
    type Shared = Ray<Binary32>;
    type Item = Aabb<Binary32>;
    type Output = Entry<Binary32>;

    #[inline(always)]
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        c: C,
        kernels: K,
        ray: &Ray<C>,
        aabb: &[Aabb<C>; N],
    ) -> [Entry<C>; N] {
        let inside = match self.rules {
            Rules::Bounds(bits) => outer_intervals(c, kernels, bits, ray, aabb),
            Rules::Paper | Rules::Chisel => self.intervals(c, kernels, ray, aabb),
        };
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

impl Slabs {
    /// The interval of the ray in each box, each operator rounded to nearest.
    #[inline(always)]
    fn intervals<C: Circuit, const N: usize>(
        &self,
        c: C,
        kernels: impl Kernels<C>,
        ray: &Ray<C>,
        aabb: &[Aabb<C>; N],
    ) -> [Interval<C>; N] {
        c.stage(2, "every box bound - origin");
        let relative: [Aabb<C>; N] = array_of!(i => aabb[i] - ray.origin);
        c.label(format_args!("relative"), &relative);

        c.stage(3, "times inv: slab distances");
        let distance: [Aabb<C>; N] = array_of!(i => relative[i] * ray.inv);
        c.label(format_args!("distance"), &distance);

        c.stage(4, "near and far by sign; tmin = max(near, 0), tmax = min(far, extent)");
        array_of!(i => {
            let Aabb { x, y, z } = distance[i];
            let slabs = [(x, ray.dir.x, ray.inv.x), (y, ray.dir.y, ray.inv.y), (z, ray.dir.z, ray.inv.z)];
            let backwards: [Bit<C>; 3] = array_of!(k => self.rules.runs_backwards(c, slabs[k].1, slabs[k].2));
            let ends: [(Num<C>, Num<C>); 3] =
                array_of!(k => kernels.exchange(backwards[k], slabs[k].0.min, slabs[k].0.max));
            let (near, far): ([Num<C>; 3], [Num<C>; 3]) = (array_of!(k => ends[k].0), array_of!(k => ends[k].1));
            for (k, axis) in ["x", "y", "z"].iter().enumerate() {
                c.label(format_args!("near_{i}_{axis}"), &near[k]);
                c.label(format_args!("far_{i}_{axis}"), &far[k]);
            }
            Interval {
                tmin: self.rules.entry(c, kernels, format_args!("near_{i}"), near),
                tmax: self.rules.exit(c, kernels, format_args!("far_{i}"), far, ray.extent),
            }
        })
    }
}
