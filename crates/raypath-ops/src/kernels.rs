//! Parts of the paper's operations that some circuits compute faster than by their operators one by one.

use crate::sort::sort_four;
use crate::{Bit, Circuit, Family, Num, Of, SortEntry, Tie, Vec3};
use std::fmt::Arguments;

/// Implementations of the operations' inner parts over circuit `C`.
///
/// The default of each method is written in circuit arithmetic and defines the result ([`Portable`] has all defaults).
/// An implementation may override a method if it returns the same bits (signs and payloads of NaNs excepted) whenever
/// the stated preconditions hold. [`Operation::run_with`](crate::Operation::run_with) takes the
/// implementation to use.
pub trait Kernels<C: Circuit>: Copy {
    /// The numbers `(a, b)`, exchanged if `condition` holds.
    #[inline(always)]
    fn exchange(self, condition: Bit<C>, a: Num<C>, b: Num<C>) -> (Num<C>, Num<C>) {
        condition.exchange(a, b)
    }

    /// The largest of three numbers and zero, ignoring NaNs. A zero result is +0. `name` labels intermediate values.
    #[inline(always)]
    fn largest_or_zero(self, c: C, name: Arguments<'_>, [x, y, z]: [Num<C>; 3]) -> Num<C> {
        // Zero is the second operand, and `larger` returns the second of equal numbers: so a zero is +0.
        let (xy, z0) = (x.larger(y), z.larger(c.zero()));
        c.label(format_args!("{name}_xy"), &xy);
        c.label(format_args!("{name}_z0"), &z0);
        xy.larger(z0)
    }

    /// The smallest of three numbers and `extent`, ignoring NaNs; NaN if all are NaN. The sign of a zero result is
    /// unspecified, so it may only be compared. `name` labels intermediate values.
    #[inline(always)]
    fn smallest_or_extent(self, c: C, name: Arguments<'_>, [x, y, z]: [Num<C>; 3], extent: Num<C>) -> Num<C> {
        let (xy, z_extent) = (x.smaller(y), z.smaller(extent));
        c.label(format_args!("{name}_xy"), &xy);
        c.label(format_args!("{name}_z_extent"), &z_extent);
        xy.smaller(z_extent)
    }

    /// Sorts boxes in the order of [`SortEntry::precedes`]: the nearest hit first, misses last.
    ///
    /// Precondition: no distance is negative, −0 or NaN.
    #[inline(always)]
    fn sort(self, c: C, entries: [SortEntry<C, 2>; 4]) -> [SortEntry<C, 2>; 4] {
        sort_four(
            c,
            "sort",
            entries,
            #[inline(always)]
            |a, b| b.precedes(a),
        )
    }

    /// Which faces have an edge, from the first sheared vertex to the second, on which the ray passes as computed: the
    /// products are equal after rounding, and their `difference` is 0. For another difference it has no meaning.
    #[inline(always)]
    fn tie(self, c: C, ends: (Vec3<C>, Vec3<C>), products: (Num<C>, Num<C>), _difference: Num<C>) -> Tie<C> {
        Tie::between(c, ends, products)
    }

    /// Applies `map` to each item. Items may be computed one after another or side by side.
    #[inline(always)]
    fn map<M: LaneMap, const N: usize>(
        self,
        c: C,
        map: &M,
        shared: &Of<M::Shared, C>,
        items: &[Of<M::Item, C>; N],
    ) -> [Of<M::Output, C>; N] {
        map.run(c, self, shared, items)
    }
}

/// The kernels in circuit arithmetic alone, which define the result of all others and become hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Portable;

impl<C: Circuit> Kernels<C> for Portable {}

/// A part of an operation that computes the same function for each of several items: boxes, vertices, lanes of a beat.
pub trait LaneMap {
    /// The values that all items share.
    type Shared: Family;
    /// One item.
    type Item: Family;
    /// The result for one item.
    type Output: Family;

    /// Computes the results of `N` items, stage by stage. The result of an item must not depend on the other items.
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        c: C,
        kernels: K,
        shared: &Of<Self::Shared, C>,
        items: &[Of<Self::Item, C>; N],
    ) -> [Of<Self::Output, C>; N];
}
