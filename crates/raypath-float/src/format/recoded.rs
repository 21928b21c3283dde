//! Numbers in the recoded format, in which the hardware computes (`docs/reference/formats.md`).

use crate::format::{Format, mask};

impl Format {
    /// The recoded +infinity.
    pub fn recoded_infinity(self) -> u64 {
        (0b110 << (self.exponent() - 2)) << self.fraction_width()
    }

    /// The recoded canonical NaN.
    pub fn recoded_nan(self) -> u64 {
        (0b111 << (self.exponent() - 2)) << self.fraction_width() | 1 << (self.fraction_width() - 1)
    }

    /// The recoded exponent of the smallest normal number.
    pub fn least_normal(self) -> u64 {
        (1 << (self.exponent() - 1)) + 2
    }

    /// The recoded number, with the result of the hardware unit of this name. NaN becomes canonical.
    pub fn encode(self, ieee: u64) -> u64 {
        let (sign, exponent, fraction) = self.split(ieee, self.exponent());
        let magnitude = match (exponent, fraction) {
            (0, 0) => 0,
            (0, _) => {
                let zeros = fraction.leading_zeros() - (64 - self.fraction_width());
                let fraction = fraction << (zeros + 1) & mask(self.fraction_width());
                (self.least_normal() - 1 - u64::from(zeros)) << self.fraction_width() | fraction
            }
            (all_ones, 0) if all_ones == mask(self.exponent()) => self.recoded_infinity(),
            (all_ones, _) if all_ones == mask(self.exponent()) => return self.recoded_nan(),
            _ => (exponent + self.least_normal() - 1) << self.fraction_width() | fraction,
        };
        sign << self.ieee_width() | magnitude
    }

    /// The number in IEEE 754's layout, with the result of the hardware unit of this name. The result is unspecified
    /// for words that are not numbers of the format. NaN becomes canonical. Bits beyond [`Format::recoded_width`] are
    /// ignored.
    pub fn decode(self, recoded: u64) -> u64 {
        let (sign, exponent, fraction) = self.split(recoded, self.exponent() + 1);
        let magnitude = match exponent >> (self.exponent() - 2) {
            0b000 => 0,
            0b110 => self.infinity(),
            0b111 => return self.nan(),
            _ if exponent < self.least_normal() => {
                let significand = 1 << self.fraction_width() | fraction;
                significand.checked_shr((self.least_normal() - exponent) as u32).unwrap_or(0)
            }
            _ => (exponent - self.least_normal() + 1) << self.fraction_width() | fraction,
        };
        sign << (self.ieee_width() - 1) | magnitude
    }
}
