//! The rules on the edges (`docs/reference/semantics.md`), in the two sets that exist. Everything else the two share.

use crate::bundle::{Bundle, bundle};
use crate::circuit::Circuit;
use crate::handle::{Bit, Num, Order, Select, Word};
use crate::ray_triangle::Edges;
use std::fmt::{self, Arguments, Display};
use std::str::FromStr;
use thiserror::Error;

/// Which rules decide at zeros, NaNs, ties and touching boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Rules {
    /// Our rulings where the paper is silent or contradicts itself; `docs/reference/semantics.md` gives their reasons.
    #[default]
    Paper,
    /// What the original hardware does, bit for bit, its accumulator fault excepted.
    Chisel,
}

bundle! {
    /// The part of a ray that lies inside a box; empty where `tmin` exceeds `tmax`.
    pub struct Interval<C> {
        /// Where the ray has entered every slab.
        pub tmin: Num<C>,
        /// Where it leaves the first slab.
        pub tmax: Num<C>,
    }
}

bundle! {
    /// A box on its way through a sorting network.
    pub struct Place<C, const W: u32> {
        /// Whether the ray hits it.
        pub hit: Bit<C>,
        /// Where; +∞ if it does not.
        pub tmin: Num<C>,
        /// Which of the job's boxes it is.
        pub index: Word<C, W>,
    }
}

impl Rules {
    /// Whether the ray runs against an axis, so that a slab's `max` is the nearer bound.
    #[inline(always)]
    pub(crate) fn runs_backwards<C: Circuit>(self, c: C, dir: Num<C>, inv: Num<C>) -> Bit<C> {
        match self {
            Rules::Paper => inv.sign_bit(),
            Rules::Chisel => !dir.compare(c.zero()).greater_or_equal(),
        }
    }

    /// The greatest of the three near distances and zero: where the ray is inside all slabs. `name` is whose it is.
    #[inline(always)]
    pub(crate) fn entry<C: Circuit>(self, c: C, name: Arguments<'_>, [x, y, z]: [Num<C>; 3]) -> Num<C> {
        match self {
            Rules::Paper => c.largest_or_zero(name, [x, y, z]),
            Rules::Chisel => self.sort_four(c, name, [x, y, z, c.zero()])[0],
        }
    }

    /// The least of the three far distances and the extent: where the ray leaves a slab, or ends.
    #[inline(always)]
    pub(crate) fn exit<C: Circuit>(self, c: C, name: Arguments<'_>, [x, y, z]: [Num<C>; 3], extent: Num<C>) -> Num<C> {
        match self {
            // It is only compared, so a zero's sign does not matter.
            Rules::Paper => c.smallest_or_extent(name, [x, y, z], extent),
            Rules::Chisel => self.sort_four(c, name, [x, y, z, extent])[3],
        }
    }

    /// Whether an interval is a hit. With a NaN it is none.
    #[inline(always)]
    pub(crate) fn box_hit<C: Circuit>(self, interval: Interval<C>) -> Bit<C> {
        let order = interval.tmin.compare(interval.tmax);
        match self {
            Rules::Paper => order.less_or_equal(),
            Rules::Chisel => order.less(),
        }
    }

    /// Nearest hit first, misses last.
    #[inline(always)]
    pub(crate) fn sort<C: Circuit>(self, c: C, boxes: [Place<C, 2>; 4]) -> [Place<C, 2>; 4] {
        match self {
            Rules::Paper => c.sort(boxes),
            Rules::Chisel => {
                let [first, second, third, last] = self.sort_four(c, "sort", boxes);
                [last, third, second, first]
            }
        }
    }

    /// Five compare-and-swaps, (0,2) (1,3) (0,1) (2,3) (1,2).
    #[inline(always)]
    fn sort_four<C: Circuit, T: Sort<C>>(self, c: C, name: impl Display + Copy, mut items: [T; 4]) -> [T; 4] {
        // One by one, so that every place is known when this is compiled.
        self.compare_and_swap(c, name, &mut items, [0, 0, 2]);
        self.compare_and_swap(c, name, &mut items, [1, 1, 3]);
        self.compare_and_swap(c, name, &mut items, [2, 0, 1]);
        self.compare_and_swap(c, name, &mut items, [3, 2, 3]);
        self.compare_and_swap(c, name, &mut items, [4, 1, 2]);
        items
    }

    /// Step number `step`: the items in places `i` and `j`.
    #[inline(always)]
    fn compare_and_swap<C: Circuit, T: Sort<C>>(
        self,
        c: C,
        name: impl Display,
        items: &mut [T; 4],
        [step, i, j]: [usize; 3],
    ) {
        let swap = T::swaps(self, items[i], items[j]);
        (items[i], items[j]) = swap.exchange(items[i], items[j]);
        c.label(format_args!("{name}_swap_{step}"), &swap);
        c.label(format_args!("{name}_{step}_first"), &items[i]);
        c.label(format_args!("{name}_{step}_second"), &items[j]);
    }

    /// Whether the ray hits the triangle's front.
    #[inline(always)]
    pub(crate) fn triangle_hit<C: Circuit>(self, c: C, edges: Edges<C>, t_num: Num<C>, t_denom: Num<C>) -> Bit<C> {
        let Edges { u, v, w } = edges;
        match self {
            Rules::Paper => {
                let inside = u.is_at_least_zero() & v.is_at_least_zero() & w.is_at_least_zero();
                inside & !t_denom.is_zero() & !t_denom.is_nan() & t_num.is_above_zero()
            }
            Rules::Chisel => {
                let negative = |x: Num<C>| x.compare(c.zero()).less();
                let outside = negative(u) | negative(v) | negative(w) | negative(t_num);
                !outside & !t_denom.compare(c.zero()).equal()
            }
        }
    }

    /// Whether a distance lies between a ray's ends, given the near end's order with it and its order with the far end,
    /// all of them times a denominator; that of a back face is below zero and turns the orders round.
    #[inline(always)]
    pub(crate) fn within<C: Circuit>(self, [near, far]: [Order<C>; 2], is_front: bool) -> Bit<C> {
        match (self, is_front) {
            (Rules::Paper, true) => near.less_or_equal() & far.less_or_equal(),
            (Rules::Paper, false) => near.greater_or_equal() & far.greater_or_equal(),
            (Rules::Chisel, true) => !near.greater() & !far.greater(),
            (Rules::Chisel, false) => !near.less() & !far.less(),
        }
    }
}

/// The largest of three numbers and zero, NaNs left out. Zero comes last, and ties take the second: so a zero is +0.
#[inline(always)]
pub(crate) fn largest_or_zero<C: Circuit>(c: C, name: Arguments<'_>, [x, y, z]: [Num<C>; 3]) -> Num<C> {
    let (xy, z0) = (x.larger(y), z.larger(c.zero()));
    c.label(format_args!("{name}_xy"), &xy);
    c.label(format_args!("{name}_z0"), &z0);
    xy.larger(z0)
}

/// The smallest of three numbers and the extent, NaNs left out; NaN where there is nothing else.
#[inline(always)]
pub(crate) fn smallest_or_extent<C: Circuit>(
    c: C,
    name: Arguments<'_>,
    [x, y, z]: [Num<C>; 3],
    extent: Num<C>,
) -> Num<C> {
    let (xy, z_extent) = (x.smaller(y), z.smaller(extent));
    c.label(format_args!("{name}_xy"), &xy);
    c.label(format_args!("{name}_z_extent"), &z_extent);
    xy.smaller(z_extent)
}

/// Nearest hit first, misses last, by a sorting network.
#[inline(always)]
pub(crate) fn sort<C: Circuit>(c: C, boxes: [Place<C, 2>; 4]) -> [Place<C, 2>; 4] {
    Rules::Paper.sort_four(c, "sort", boxes)
}

/// What a sorting network sorts.
trait Sort<C: Circuit>: Select<C> + Bundle<C> {
    /// Whether `b` must come before `a`.
    fn swaps(rules: Rules, a: Self, b: Self) -> Bit<C>;
}

impl<C: Circuit, const W: u32> Sort<C> for Place<C, W> {
    #[inline(always)]
    fn swaps(rules: Rules, a: Self, b: Self) -> Bit<C> {
        match rules {
            Rules::Paper => b.precedes(a),
            Rules::Chisel => Num::swaps(rules, a.tmin, b.tmin),
        }
    }
}

impl<C: Circuit> Sort<C> for Num<C> {
    /// The original's order, descending: what is not greater or equal changes places, so that unordered numbers do.
    #[inline(always)]
    fn swaps(_rules: Rules, a: Self, b: Self) -> Bit<C> {
        !a.compare(b).greater_or_equal()
    }
}

impl<C: Circuit, const W: u32> Place<C, W> {
    /// Nearer before farther; at the same distance hits before misses, then by index.
    #[inline(always)]
    pub fn precedes(self, other: Self) -> Bit<C> {
        let distance = self.tmin.compare(other.tmin);
        let only_this_hits = self.hit & !other.hit;
        let tie = only_this_hits | (self.hit.same_as(other.hit) & self.index.less(other.index));
        distance.less() | (distance.equal() & tie)
    }
}

impl<C: Circuit, const W: u32> Select<C> for Place<C, W> {
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

/// A name that is no rule set.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no rule set, expected paper or chisel")]
pub struct ParseRulesError(String);

impl FromStr for Rules {
    type Err = ParseRulesError;
    fn from_str(name: &str) -> Result<Self, ParseRulesError> {
        match name {
            "paper" => Ok(Rules::Paper),
            "chisel" => Ok(Rules::Chisel),
            _ => Err(ParseRulesError(name.to_string())),
        }
    }
}

impl fmt::Display for Rules {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Rules::Paper => "paper",
            Rules::Chisel => "chisel",
        })
    }
}
