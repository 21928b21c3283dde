//! Formats by their two widths, and the recoded format in software.

use std::fmt;
use thiserror::Error;

/// A binary floating-point format: exponent bits and significand bits, hidden bit included. Prints as `e8s24`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Format {
    exponent: u32,
    significand: u32,
}

/// Why there is no such format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum FormatError {
    /// Too few or too many exponent bits.
    #[error("format with an exponent of {0} bits, expected 3 to 11")]
    Exponent(u32),
    /// Too few or too many significand bits.
    #[error("format with a significand of {significand} bits, expected 3 to {most} where the exponent has {exponent}")]
    Significand {
        /// The exponent bits asked for.
        exponent: u32,
        /// The significand bits asked for.
        significand: u32,
        /// The most that this exponent allows.
        most: u32,
    },
}

impl Format {
    /// IEEE 754 binary32.
    pub const BINARY32: Self = Self { exponent: 8, significand: 24 };

    /// A format of 3 to 11 exponent bits and 3 to 24 significand bits. The significand is bounded by 2^(exponent-2) + 3
    /// as well: with more, the smallest subnormals would need the exponents that say zero.
    pub fn new(exponent: u32, significand: u32) -> Result<Self, FormatError> {
        if !(3..=11).contains(&exponent) {
            return Err(FormatError::Exponent(exponent));
        }
        let most = 24.min((1 << (exponent - 2)) + 3);
        if !(3..=most).contains(&significand) {
            return Err(FormatError::Significand { exponent, significand, most });
        }
        Ok(Self { exponent, significand })
    }

    /// Exponent bits in IEEE 754's layout; the recoded format has one more.
    pub fn exponent(self) -> u32 {
        self.exponent
    }

    /// Significand bits, hidden bit included.
    pub fn significand(self) -> u32 {
        self.significand
    }

    /// Bits of a number in IEEE 754's layout.
    pub fn ieee_width(self) -> u32 {
        self.exponent + self.significand
    }

    /// Bits of a recoded number.
    pub fn recoded_width(self) -> u32 {
        self.ieee_width() + 1
    }

    /// The recoded +infinity.
    pub fn recoded_infinity(self) -> u64 {
        (0b110 << (self.exponent - 2)) << self.fraction_width()
    }

    /// The recoded canonical NaN.
    pub fn recoded_nan(self) -> u64 {
        (0b111 << (self.exponent - 2)) << self.fraction_width() | 1 << (self.fraction_width() - 1)
    }

    /// What the unit of this name computes: an IEEE 754 number, recoded. Bits beyond [`Format::ieee_width`] are
    /// ignored.
    pub fn encode(self, ieee: u64) -> u64 {
        let (sign, exponent, fraction) = self.split(ieee, self.exponent);
        let magnitude = match (exponent, fraction) {
            (0, 0) => 0,
            (0, _) => {
                let zeros = fraction.leading_zeros() - (64 - self.fraction_width());
                let fraction = fraction << (zeros + 1) & mask(self.fraction_width());
                (self.least_normal() - 1 - u64::from(zeros)) << self.fraction_width() | fraction
            }
            (all_ones, 0) if all_ones == mask(self.exponent) => self.recoded_infinity(),
            (all_ones, _) if all_ones == mask(self.exponent) => return self.recoded_nan(),
            _ => (exponent + self.least_normal() - 1) << self.fraction_width() | fraction,
        };
        sign << self.ieee_width() | magnitude
    }

    /// What the unit of this name computes: a recoded number in IEEE 754's layout, for words that are numbers of the
    /// format; others are unspecified, here and in hardware. Bits beyond [`Format::recoded_width`] are ignored.
    pub fn decode(self, recoded: u64) -> u64 {
        let (sign, exponent, fraction) = self.split(recoded, self.exponent + 1);
        let infinity = mask(self.exponent) << self.fraction_width();
        let magnitude = match exponent >> (self.exponent - 2) {
            0b000 => 0,
            0b110 => infinity,
            0b111 => return infinity | 1 << (self.fraction_width() - 1),
            _ if exponent < self.least_normal() => {
                let significand = 1 << self.fraction_width() | fraction;
                significand.checked_shr((self.least_normal() - exponent) as u32).unwrap_or(0)
            }
            _ => (exponent - self.least_normal() + 1) << self.fraction_width() | fraction,
        };
        sign << (self.ieee_width() - 1) | magnitude
    }

    /// Bits of a fraction.
    pub(crate) fn fraction_width(self) -> u32 {
        self.significand - 1
    }

    /// The recoded exponent of the smallest normal number.
    pub(crate) fn least_normal(self) -> u64 {
        (1 << (self.exponent - 1)) + 2
    }

    /// Sign, exponent and fraction of a number whose exponent has `exponent_width` bits.
    fn split(self, number: u64, exponent_width: u32) -> (u64, u64, u64) {
        let fraction = number & mask(self.fraction_width());
        let exponent = number >> self.fraction_width() & mask(exponent_width);
        (number >> (self.fraction_width() + exponent_width) & 1, exponent, fraction)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "e{}s{}", self.exponent, self.significand)
    }
}

fn mask(bits: u32) -> u64 {
    (1 << bits) - 1
}
