//! What rounding takes from a product, by which two products that are equal after rounding still compare.

use crate::sum::Layout;

/// The bits of a residue ([`Circuit::residue`](crate::Circuit::residue)).
pub const RESIDUE_BITS: u32 = 26;

/// Set in the residue of a product that is not 0 and below the normal range; the bits below are then unspecified.
pub const RESIDUE_TINY: u32 = 1 << (RESIDUE_BITS - 1);

/// The bits of the longest significand whose products have a residue.
const MOST: u32 = RESIDUE_BITS - 2;

impl Layout {
    /// The residue of the product of two numbers ([`Circuit::residue`](crate::Circuit::residue)), on bits in the IEEE
    /// 754 layout. It is 0 if a factor is 0, infinite or NaN. A longer significand than 24 bits loses its last bits.
    #[inline]
    pub fn residue(self, a: u64, b: u64) -> u32 {
        let (s, all_ones) = (self.significand, (1 << self.exponent) - 1);
        // The significand with its highest bit set, and the exponent of that bit, relative to the least normal one.
        let factor = |code: u64| {
            let (field, fraction) = (code >> (s - 1) & all_ones, code & ((1 << (s - 1)) - 1));
            let digits = fraction | u64::from(field != 0) << (s - 1);
            let up = digits.leading_zeros() as i32 - (64 - s as i32);
            (field != all_ones && digits != 0).then(|| (digits << up, field.max(1) as i32 - 1 - up))
        };
        let (Some((a, a_exponent)), Some((b, b_exponent))) = (factor(a), factor(b)) else { return 0 };
        let product = u128::from(a) * u128::from(b);
        // From here on, the product has 2s bits.
        let is_short = product >> (2 * s - 1) == 0;
        let product = product << u32::from(is_short);
        let least = 2 - (1 << (self.exponent - 1));
        if a_exponent + b_exponent + i32::from(!is_short) + least < 0 {
            return RESIDUE_TINY;
        }
        let (lost, half) = (product & ((1 << s) - 1), 1 << (s - 1));
        let is_up = lost > half || (lost == half && product >> s & 1 == 1);
        let key = u128::from(!is_up) << s | lost;
        (if s <= MOST { key << (MOST - s) } else { key >> (s - MOST) }) as u32
    }
}
