//! Ray against four boxes: the slab method (Table VII, column Quadbox).

use crate::operation::run_portable;
use crate::ray_box_bounds::outer_ends;
use crate::rules::Interval;
use crate::{
    Aabb, Binary32, Bit, Circuit, Flags, Kernels, LaneMap, Num, Operation, Ray, Rules, SortEntry, Vec3, Word, bundle,
};

/// Tests a ray against four boxes and sorts the boxes by distance, the nearest hit first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayBox {
    /// The rules for special cases.
    pub rules: Rules,
    /// Lowers `tmin` by [`MARGIN_ULPS`], so that rounding never causes a miss of a box that the ray touches.
    /// `docs/reference/error-bounds.md` has the proof, and what it says of triangles.
    pub is_conservative: bool,
}

/// By how much a conservative `tmin` is lowered, in units in the last place of 1, times the greater magnitude of the
/// box's two distances along the axis kz: 32u, where u is half a unit in the last place of 1.
pub const MARGIN_ULPS: u32 = 16;

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
        let Self { rules, is_conservative } = *self;
        let RayBoxInput { ray, aabb } = input;

        let hits = kernels.map(c, &Slabs { rules, is_conservative }, &ray, &aabb);
        let unsorted: [SortEntry<C, 2>; 4] =
            array_of!(i => SortEntry { hit: hits[i].hit, tmin: hits[i].tmin, index: c.word(i as u32) });
        c.label(format_args!("unsorted"), &unsorted);

        c.stage_or(10, 8, "sort the four by tmin, values and indices");
        let sorted = rules.sort(c, kernels, unsorted);
        c.label(format_args!("sorted"), &sorted);

        (RayBoxOutput::of_sorted(&sorted), ())
    }
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

/// The slab method for one ray and several boxes, in stages 2 to 5, or 2 to 8 if it is conservative. Per box it takes 6
/// adders, 6 multipliers and 7 comparators under the rules `paper`, and one more of each if it is conservative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slabs {
    /// The rules for special cases.
    pub rules: Rules,
    /// As in [`RayBox`].
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
        let (ends, extent): ([SlabEnds<C>; N], _) = match self.rules {
            Rules::Bounds(bits) => outer_ends(c, kernels, bits, ray, aabb),
            Rules::Paper | Rules::Chisel => (self.ends(c, kernels, ray, aabb), ray.extent),
        };
        let inside: [Interval<C>; N] = array_of!(i => {
            let (near, far) = (array_of!(k => ends[i][k].0), array_of!(k => ends[i][k].1));
            Interval {
                tmin: self.rules.entry(c, kernels, format_args!("near_{i}"), near),
                tmax: self.rules.exit(c, kernels, format_args!("far_{i}"), far, extent),
            }
        });
        c.label(format_args!("inside"), &inside);
        if !self.is_conservative {
            c.stage(5, "hit = tmin against tmax");
            return array_of!(i => {
                let hit = self.rules.box_hit(inside[i]);
                Entry { hit, tmin: hit.select(inside[i].tmin, c.infinity()) }
            });
        }

        let depth: [Num<C>; N] = array_of!(i => {
            let [(x0, x1), (y0, y1), (z0, z1)] = ends[i];
            let near = Vec3 { x: x0, y: y0, z: z0 }.along(ray.kz);
            let far = Vec3 { x: x1, y: y1, z: z1 }.along(ray.kz);
            near.magnitude().larger(far.magnitude())
        });
        c.label(format_args!("depth"), &depth);

        c.stage(5, "margin: 32u of the greater distance along kz");
        let ulps = Num::new(c, c.ulps(MARGIN_ULPS));
        let margin: [Num<C>; N] = array_of!(i => depth[i] * ulps);
        c.label(format_args!("margin"), &margin);

        c.stage_or(7, 6, "tmin - margin");
        let lowered: [Interval<C>; N] =
            array_of!(i => Interval { tmin: inside[i].tmin - margin[i], tmax: inside[i].tmax });
        c.label(format_args!("lowered"), &lowered);

        c.stage_or(8, 7, "hit = tmin against tmax");
        array_of!(i => {
            let hit = self.rules.box_hit(lowered[i]);
            let tmin = lowered[i].tmin.is_below_zero().select(c.zero(), lowered[i].tmin);
            Entry { hit, tmin: hit.select(tmin, c.infinity()) }
        })
    }
}

/// The distances at which a ray enters and leaves the slab of each axis.
pub(crate) type SlabEnds<C> = [(Num<C>, Num<C>); 3];

impl Slabs {
    /// Distances of planes, each operator rounded to nearest.
    #[inline(always)]
    fn ends<C: Circuit, const N: usize>(
        &self,
        c: C,
        kernels: impl Kernels<C>,
        ray: &Ray<C>,
        aabb: &[Aabb<C>; N],
    ) -> [SlabEnds<C>; N] {
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
            let ends: SlabEnds<C> = array_of!(k => kernels.exchange(backwards[k], slabs[k].0.min, slabs[k].0.max));
            for (k, axis) in ["x", "y", "z"].iter().enumerate() {
                c.label(format_args!("near_{i}_{axis}"), &ends[k].0);
                c.label(format_args!("far_{i}_{axis}"), &ends[k].1);
            }
            ends
        })
    }
}
