//! A ray against eight boxes per job, as in the nodes of RDNA 4 (AMD, "RDNA4 Instruction Set Architecture",
//! IMAGE_BVH8_INTERSECT_RAY).
//!
//! It uses the slab method of the operation for four boxes. A datapath with that operation needs these additional
//! units: 24 adders in stage 2, 24 multipliers in stage 3, and 24, 4, 10 and 4 comparators in stages 4, 5, 9 and 10.

use crate::sort::compare_and_swap;
use crate::{
    Aabb, Circuit, Entry, Flags, LaneMap, Num, Operation, Portable, Ray, Rules, Slabs, SortEntry, Word, bundle,
};

/// Tests a ray against eight boxes and sorts the boxes by distance, the nearest hit first.
///
/// Hits and distances are those of [`RayBox`](crate::RayBox) under the rules `paper` (`docs/reference/semantics.md`).
/// Hits come before misses, nearer boxes before farther ones, equally distant boxes by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Octbox;

bundle! {
    /// A ray and eight boxes. The first four have the ports of [`RayBoxInput`](crate::RayBoxInput).
    pub struct OctboxInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 8],
    }

    /// The eight boxes sorted by distance: hits before misses, nearer before farther.
    pub struct OctboxOutput<C> {
        /// Whether the box at each position of the order is hit.
        pub octbox_is_intersect: Flags<C, 8>,
        /// The distance at which the ray enters the box, in units of the direction's length; +∞ for a miss.
        pub octbox_tmin: [Num<C>; 8],
        /// The index of the box in the job.
        pub octbox_box_index: [Word<C, 3>; 8],
    }
}

/// The steps of Batcher's odd-even merge sort that sort each half. In total it has 19 steps and a depth of six.
const SORT_HALVES: [(usize, usize); 10] =
    [(0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (1, 2), (5, 6)];
/// The steps that merge the halves.
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
        let mut entries: [SortEntry<C, 3>; 8] =
            array_of!(i => SortEntry { hit: hits[i].hit, tmin: hits[i].tmin, index: c.word(i as u32) });
        c.label(format_args!("unsorted"), &entries);

        c.stage(9, "sort each half by tmin, values and indices");
        sort_by(c, "half", &mut entries, &SORT_HALVES);

        c.stage(10, "merge the halves");
        sort_by(c, "merge", &mut entries, &MERGE);
        c.label(format_args!("sorted"), &entries);

        let output = OctboxOutput {
            octbox_is_intersect: Flags(array_of!(i => entries[i].hit)),
            octbox_tmin: array_of!(i => entries[i].tmin),
            octbox_box_index: array_of!(i => entries[i].index),
        };
        (output, ())
    }
}

/// The steps of a sorting network on these pairs, in order.
#[inline(always)]
fn sort_by<C: Circuit>(c: C, name: &str, entries: &mut [SortEntry<C, 3>; 8], pairs: &[(usize, usize)]) {
    for (step, &(i, j)) in pairs.iter().enumerate() {
        compare_and_swap(c, name, entries, [step, i, j], &|a, b| b.precedes(a));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the zero-one principle, a network that sorts all sequences of zeros and ones sorts every sequence.
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
