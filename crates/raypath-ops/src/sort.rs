//! Sorting networks for the boxes of a job.

use crate::{Bit, Bundle, Circuit, Num, Select, Word, bundle};
use std::fmt::Display;

bundle! {
    /// One box in a sorting network.
    pub struct SortEntry<C, const W: u32> {
        /// The ray hits the box.
        pub hit: Bit<C>,
        /// The distance at which the ray enters the box; +∞ for a miss.
        pub tmin: Num<C>,
        /// The index of the box in its job.
        pub index: Word<C, W>,
    }
}

impl<C: Circuit, const W: u32> SortEntry<C, W> {
    /// Whether this entry comes before `other`: the nearer one; at equal distances hits before misses, then by index.
    #[inline(always)]
    pub fn precedes(self, other: Self) -> Bit<C> {
        let distance = self.tmin.compare(other.tmin);
        let only_this_hits = self.hit & !other.hit;
        let tie = only_this_hits | (self.hit.same_as(other.hit) & self.index.less(other.index));
        distance.less() | (distance.equal() & tie)
    }
}

impl<C: Circuit, const W: u32> Select<C> for SortEntry<C, W> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        Self {
            hit: condition.select(if_true.hit, if_false.hit),
            tmin: condition.select(if_true.tmin, if_false.tmin),
            index: condition.select(if_true.index, if_false.index),
        }
    }

    #[inline(always)]
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self) {
        let (hit, tmin) = (condition.exchange(a.hit, b.hit), condition.exchange(a.tmin, b.tmin));
        let index = condition.exchange(a.index, b.index);
        (Self { hit: hit.0, tmin: tmin.0, index: index.0 }, Self { hit: hit.1, tmin: tmin.1, index: index.1 })
    }
}

/// Sorts four items by five compare-and-swaps. `swaps(a, b)` returns whether `b` must come before `a`.
#[inline(always)]
pub(crate) fn sort_four<C: Circuit, T: Select<C> + Bundle<C>>(
    c: C,
    name: impl Display + Copy,
    mut items: [T; 4],
    swaps: impl Fn(T, T) -> Bit<C>,
) -> [T; 4] {
    // Unrolled, so that every index is a constant.
    compare_and_swap(c, name, &mut items, [0, 0, 2], &swaps);
    compare_and_swap(c, name, &mut items, [1, 1, 3], &swaps);
    compare_and_swap(c, name, &mut items, [2, 0, 1], &swaps);
    compare_and_swap(c, name, &mut items, [3, 2, 3], &swaps);
    compare_and_swap(c, name, &mut items, [4, 1, 2], &swaps);
    items
}

/// Step number `step` of a sorting network: exchanges items `i` and `j` if `swaps` holds for them.
#[inline(always)]
pub(crate) fn compare_and_swap<C: Circuit, T: Select<C> + Bundle<C>, const N: usize>(
    c: C,
    name: impl Display,
    items: &mut [T; N],
    [step, i, j]: [usize; 3],
    swaps: &impl Fn(T, T) -> Bit<C>,
) {
    let swap = swaps(items[i], items[j]);
    (items[i], items[j]) = swap.exchange(items[i], items[j]);
    c.label(format_args!("{name}_swap_{step}"), &swap);
    c.label(format_args!("{name}_{step}_first"), &items[i]);
    c.label(format_args!("{name}_{step}_second"), &items[j]);
}
