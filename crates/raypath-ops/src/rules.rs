//! The rules for special cases (`docs/reference/semantics.md`): zeros, NaNs, ties and touching boxes.

use crate::sort::sort_four;
use crate::{Bit, Circuit, Kernels, Num, Order, SortEntry, bundle};
use std::fmt::{self, Arguments};
use std::str::FromStr;
use thiserror::Error;

/// A set of rules for zeros, NaNs, ties and touching boxes. Everything else is the same in both sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Rules {
    /// The rules for what the paper leaves open or contradicts. `docs/reference/semantics.md` gives the reasons.
    #[default]
    Paper,
    /// The behaviour of the original hardware, bit for bit, except for its accumulator fault.
    Chisel,
    /// Those of `Paper`, but slab distances have significands of a few bits and are rounded outwards: `tmin` is a lower
    /// bound of the distance at which the ray enters a box, and no box that the ray enters is missed.
    Bounds(BoxBits),
}

/// The bits of the significands in the box test of [`Rules::Bounds`], hidden bit included: from 8 to 24, and at most
/// those of the circuit's format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BoxBits(pub u32);

impl BoxBits {
    /// The least number of bits.
    pub const MIN: Self = Self(8);
    /// The greatest number of bits.
    pub const MAX: Self = Self(24);
    /// The least number that adds at most 2 % to the visits in the scenes of `docs/user/area-and-timing.md`.
    pub const DEFAULT: Self = Self(13);
}

impl fmt::Display for BoxBits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl FromStr for BoxBits {
    type Err = ParseBoxBitsError;
    fn from_str(text: &str) -> Result<Self, ParseBoxBitsError> {
        let bits = text.parse().ok().map(Self).filter(|bits| (Self::MIN..=Self::MAX).contains(bits));
        bits.ok_or_else(|| ParseBoxBitsError(text.to_string()))
    }
}

/// The error of a text that is not a number of bits for boxes.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is not a valid number of bits, expected 8 to 24")]
pub struct ParseBoxBitsError(String);

bundle! {
    /// The part of a ray that lies inside a box. It is empty if `tmin` exceeds `tmax`.
    pub struct Interval<C> {
        /// The distance at which the ray has entered all slabs.
        pub tmin: Num<C>,
        /// The distance at which the ray leaves the first slab.
        pub tmax: Num<C>,
    }
}

impl Rules {
    /// Whether the ray runs in the negative direction of an axis, so that a slab's `max` is the nearer bound.
    #[inline(always)]
    pub(crate) fn runs_backwards<C: Circuit>(self, c: C, dir: Num<C>, inv: Num<C>) -> Bit<C> {
        match self {
            Rules::Paper | Rules::Bounds(_) => inv.sign_bit(),
            Rules::Chisel => !dir.compare(c.zero()).greater_or_equal(),
        }
    }

    /// The greatest of the three near distances and zero: the distance at which the ray is inside all slabs. `name`
    /// labels intermediate values.
    #[inline(always)]
    pub(crate) fn entry<C: Circuit>(
        self,
        c: C,
        kernels: impl Kernels<C>,
        name: Arguments<'_>,
        [x, y, z]: [Num<C>; 3],
    ) -> Num<C> {
        match self {
            Rules::Paper | Rules::Bounds(_) => kernels.largest_or_zero(c, name, [x, y, z]),
            Rules::Chisel => sort_four(c, name, [x, y, z, c.zero()], chisel_swaps)[0],
        }
    }

    /// The distance at which the ray leaves a slab or ends: the least of the far distances and the extent.
    #[inline(always)]
    pub(crate) fn exit<C: Circuit>(
        self,
        c: C,
        kernels: impl Kernels<C>,
        name: Arguments<'_>,
        [x, y, z]: [Num<C>; 3],
        extent: Num<C>,
    ) -> Num<C> {
        match self {
            // The result is only compared, so the sign of a zero does not matter.
            Rules::Paper | Rules::Bounds(_) => kernels.smallest_or_extent(c, name, [x, y, z], extent),
            Rules::Chisel => sort_four(c, name, [x, y, z, extent], chisel_swaps)[3],
        }
    }

    /// Whether an interval is a hit. An interval with a NaN is a miss.
    #[inline(always)]
    pub(crate) fn box_hit<C: Circuit>(self, interval: Interval<C>) -> Bit<C> {
        let order = interval.tmin.compare(interval.tmax);
        match self {
            Rules::Paper | Rules::Bounds(_) => order.less_or_equal(),
            Rules::Chisel => order.less(),
        }
    }

    /// The boxes with the nearest hit first and misses last.
    #[inline(always)]
    pub(crate) fn sort<C: Circuit>(
        self,
        c: C,
        kernels: impl Kernels<C>,
        entries: [SortEntry<C, 2>; 4],
    ) -> [SortEntry<C, 2>; 4] {
        match self {
            Rules::Paper | Rules::Bounds(_) => kernels.sort(c, entries),
            Rules::Chisel => {
                let [first, second, third, last] = sort_four(
                    c,
                    "sort",
                    entries,
                    #[inline(always)]
                    |a, b| chisel_swaps(a.tmin, b.tmin),
                );
                [last, third, second, first]
            }
        }
    }

    /// Whether the ray passes inside the triangle's front, whose edges belong to it. `edges` are U, V and W.
    #[inline(always)]
    pub(crate) fn inside<C: Circuit>(self, c: C, [u, v, w]: [Num<C>; 3]) -> Bit<C> {
        match self {
            Rules::Paper | Rules::Bounds(_) => u.is_at_least_zero() & v.is_at_least_zero() & w.is_at_least_zero(),
            Rules::Chisel => !(is_less(c, u) | is_less(c, v) | is_less(c, w)),
        }
    }

    /// Whether a ray that passes `inside` the triangle's front hits it.
    #[inline(always)]
    pub(crate) fn triangle_hit<C: Circuit>(self, c: C, inside: Bit<C>, t_num: Num<C>, t_denom: Num<C>) -> Bit<C> {
        match self {
            Rules::Paper | Rules::Bounds(_) => inside & !t_denom.is_zero() & !t_denom.is_nan() & t_num.is_above_zero(),
            Rules::Chisel => inside & !is_less(c, t_num) & !t_denom.compare(c.zero()).equal(),
        }
    }

    /// Whether a distance lies between the ends of a ray. `near` compares the near end with the distance, `far` the
    /// distance with the far end, all times the denominator, which is negative for a back face and reverses the order.
    #[inline(always)]
    pub(crate) fn within<C: Circuit>(self, [near, far]: [Order<C>; 2], is_front: bool) -> Bit<C> {
        match (self, is_front) {
            (Rules::Paper | Rules::Bounds(_), true) => near.less_or_equal() & far.less_or_equal(),
            (Rules::Paper | Rules::Bounds(_), false) => near.greater_or_equal() & far.greater_or_equal(),
            (Rules::Chisel, true) => !near.greater() & !far.greater(),
            (Rules::Chisel, false) => !near.less() & !far.less(),
        }
    }
}

/// Whether a number is below zero, by a comparator.
#[inline(always)]
fn is_less<C: Circuit>(c: C, number: Num<C>) -> Bit<C> {
    number.compare(c.zero()).less()
}

/// The order of the original hardware, descending: a swap unless `a` is greater or equal, so also if one is NaN.
#[inline(always)]
fn chisel_swaps<C: Circuit>(a: Num<C>, b: Num<C>) -> Bit<C> {
    !a.compare(b).greater_or_equal()
}

impl fmt::Display for Rules {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Paper => "paper",
            Self::Chisel => "chisel",
            Self::Bounds(_) => "bounds",
        })
    }
}

/// The rules `bounds` have the default number of bits.
impl FromStr for Rules {
    type Err = ParseRulesError;
    fn from_str(name: &str) -> Result<Self, ParseRulesError> {
        match name {
            "paper" => Ok(Self::Paper),
            "chisel" => Ok(Self::Chisel),
            "bounds" => Ok(Self::Bounds(BoxBits::DEFAULT)),
            _ => Err(ParseRulesError(name.to_string())),
        }
    }
}

/// The error of an unknown name of a rule set.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is not a valid rule set, expected paper, chisel or bounds")]
pub struct ParseRulesError(String);
