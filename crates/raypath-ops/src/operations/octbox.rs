//! A ray against eight boxes a job, as wide as RDNA 4's nodes (AMD, "RDNA4 Instruction Set Architecture",
//! IMAGE_BVH8_INTERSECT_RAY).
//!
//! The slab method is that of the four boxes. Adds, where those are, 24 adders in stage 2, 24 multipliers in stage 3
//! and comparators: 24 in stage 4, 4 in stage 5, 10 in stage 9 and 4 in stage 10.

use crate::{
    Aabb, Circuit, Entry, Flags, LaneMap, Num, Operation, Portable, Ray, Rules, Slabs, SortEntry, Word, bundle,
};

/// Which of eight boxes a ray hits, nearest first.
///
/// By the rules `paper` (`docs/reference/semantics.md`): boxes are hit and missed as by [`RayBox`](crate::RayBox), hits
/// stand before misses, nearer before farther, and equal distances by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Octbox;

bundle! {
    /// A ray and eight boxes; the first four are on the ports of the four boxes.
    pub struct OctboxInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 8],
    }
}

bundle! {
    /// The eight boxes by distance.
    pub struct OctboxOutput<C> {
        /// Whether the box in each place is hit.
        pub octbox_is_intersect: Flags<C, 8>,
        /// Where the ray enters it, in units of the direction's length; +∞ for a miss.
        pub octbox_tmin: [Num<C>; 8],
        /// Which of the job's boxes it is.
        pub octbox_box_index: [Word<C, 3>; 8],
    }
}

/// Batcher's odd-even merge sort: 19 exchanges, six deep. These sort each half.
const SORT_HALVES: [(usize, usize); 10] =
    [(0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (1, 2), (5, 6)];
/// And these merge the halves.
const MERGE: [(usize, usize); 9] = [(0, 4), (1, 5), (2, 6), (3, 7), (2, 4), (3, 5), (1, 2), (3, 4), (5, 6)];

impl Operation for Octbox {
    const NAME: &'static str = "octbox";
    type Input<C: Circuit> = OctboxInput<C>;
    type Output<C: Circuit> = OctboxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: OctboxInput<C>, _state: ()) -> (OctboxOutput<C>, ()) {
        let OctboxInput { ray, aabb } = input;

        let hits: [Entry<C>; 8] = Slabs { rules: Rules::Paper, is_conservative: false }.run(c, Portable, &ray, &aabb);
        let mut places: [SortEntry<C, 3>; 8] =
            array_of!(i => SortEntry { hit: hits[i].hit, tmin: hits[i].tmin, index: c.word(i as u32) });
        c.label(format_args!("unsorted"), &places);

        c.stage(9, "sort each half by tmin, values and indices");
        exchange(c, "half", &mut places, &SORT_HALVES);

        c.stage(10, "merge the halves");
        exchange(c, "merge", &mut places, &MERGE);
        c.label(format_args!("sorted"), &places);

        let output = OctboxOutput {
            octbox_is_intersect: Flags(array_of!(i => places[i].hit)),
            octbox_tmin: array_of!(i => places[i].tmin),
            octbox_box_index: array_of!(i => places[i].index),
        };
        (output, ())
    }
}

/// Each pair in order, one after another.
#[inline(always)]
fn exchange<C: Circuit>(c: C, name: &str, places: &mut [SortEntry<C, 3>; 8], pairs: &[(usize, usize)]) {
    for (step, &(i, j)) in pairs.iter().enumerate() {
        let swap = places[j].precedes(places[i]);
        (places[i], places[j]) = swap.exchange(places[i], places[j]);
        c.label(format_args!("{name}_swap_{step}"), &swap);
        c.label(format_args!("{name}_{step}_first"), &places[i]);
        c.label(format_args!("{name}_{step}_second"), &places[j]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A network sorts everything if it sorts all zeros and ones.
    #[test]
    fn the_network_sorts() {
        for word in 0..256_u32 {
            let mut bits: [u32; 8] = std::array::from_fn(|i| word >> i & 1);
            for (i, j) in SORT_HALVES.into_iter().chain(MERGE) {
                (bits[i], bits[j]) = (bits[i].min(bits[j]), bits[i].max(bits[j]));
            }
            assert!(bits.is_sorted(), "{word:08b}: {bits:?}");
        }
    }
}
