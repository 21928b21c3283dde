//! Sums of several numbers that are rounded once, in software.
//!
//! `docs/reference/semantics.md` defines them. The hardware's unit uses another algorithm; tests compare both with an
//! oracle.

/// Whether sums of several terms round at every addition, or once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Rounding {
    /// Every addition of two terms rounds: the paper's trees of adders.
    #[default]
    Unit,
    /// [`Circuit::sum`](crate::Circuit::sum) rounds once.
    Sum,
}

names! {
    Rounding { Unit = "unit", Sum = "sum" },
    /// The error of an unknown name of a rounding.
    ParseRoundingError, "'{0}' is not a valid rounding, expected unit or sum"
}

/// The bits of a format's numbers in the IEEE 754 layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Exponent bits, at most 11.
    pub exponent: u32,
    /// Significand bits, hidden bit included, at most 53.
    pub significand: u32,
}

impl Layout {
    /// Binary32.
    pub const BINARY32: Self = Self { exponent: 8, significand: 24 };
    /// Binary64.
    pub const BINARY64: Self = Self { exponent: 11, significand: 53 };

    /// The greatest number of terms of a sum.
    pub const MAX_TERMS: usize = 64;

    /// The sum of 3 to [`MAX_TERMS`](Self::MAX_TERMS) numbers, rounded once ([`Circuit::sum`](crate::Circuit::sum)), on
    /// bits in the IEEE 754 layout. A NaN is the canonical one.
    #[inline]
    pub fn sum(self, terms: impl ExactSizeIterator<Item = u64> + Clone) -> u64 {
        let (fraction, all_ones) = (self.significand - 1, (1 << self.exponent) - 1);
        let (infinity, sign) = (all_ones << fraction, 1 << (self.exponent + fraction));
        let quiet = infinity | 1 << (fraction - 1);

        // The greatest magnitude has the greatest exponent, and is infinite or NaN if any number is.
        let (mut greatest, mut minus_zeros) = (0, sign);
        for term in terms.clone() {
            greatest = greatest.max(term & (sign - 1));
            minus_zeros &= if term & (sign - 1) == 0 { term } else { 0 };
        }
        if greatest == 0 {
            return minus_zeros;
        }
        if greatest >= infinity {
            let mut found = terms.filter(|term| term & (sign - 1) >= infinity);
            let first = found.next().unwrap_or(quiet);
            let is_one_infinity = greatest == infinity && found.all(|other| other == first);
            return if is_one_infinity { first & (sign | infinity) } else { quiet };
        }

        // The last place of the window, as a power of two relative to the last place of subnormal numbers; below 0 if
        // every number is a multiple of it.
        let place = |magnitude: u64| (magnitude >> fraction).saturating_sub(1) as i32;
        let digits = |magnitude: u64| {
            let hidden = u64::from(magnitude >> fraction != 0) << fraction;
            magnitude & ((1 << fraction) - 1) | hidden
        };
        let leading = place(greatest) + 63 - digits(greatest).leading_zeros() as i32;
        let window = self.significand + (terms.len() as u32).next_power_of_two().ilog2();
        let last = (leading + 1 - window as i32).max(0);
        let mut total: i128 = 0;
        for term in terms {
            let magnitude = term & (sign - 1);
            let distance = place(magnitude) - last;
            let kept = match distance {
                0.. => digits(magnitude) << distance,
                _ => digits(magnitude).checked_shr(distance.unsigned_abs()).unwrap_or(0),
            };
            total += if term & sign == 0 { i128::from(kept) } else { -i128::from(kept) };
        }
        let rounded = self.round(total.unsigned_abs(), last).min(infinity);
        if total < 0 { rounded | sign } else { rounded }
    }

    /// The bits of the number nearest to `total` times two to the `place`, relative to the last place of subnormal
    /// numbers; ties to even.
    #[inline]
    fn round(self, total: u128, place: i32) -> u64 {
        let width = 128 - total.leading_zeros();
        let lost = width.saturating_sub(self.significand);
        if lost == 0 && place > 0 && width < self.significand {
            // Fewer digits than a significand has, but not below the normal range.
            let up = (self.significand - width).min(place as u32);
            return self.round(total << up, place - up as i32);
        }
        let (kept, rest) = ((total >> lost) as u64, total & ((1 << lost) - 1));
        let half = 1_u128 << lost >> 1;
        let up = lost > 0 && (rest > half || rest == half && kept & 1 == 1);
        // A hidden bit, or a carry out of the significand, adds one to the exponent field.
        (((place as u64) + u64::from(lost)) << (self.significand - 1)) + kept + u64::from(up)
    }
}
