//! Floating-point formats in software, of 3 to 11 exponent bits and 3 to 24 significand bits: names, exact arithmetic,
//! and the recoded format of the hardware.
//!
//! Arithmetic is that of IEEE 754, rounded to nearest even, with subnormals. Every NaN result is canonical: the sign is
//! 0, and only the top bit of the fraction is set (in binary32 `7fc00000`).
//!
//! ```
//! use raypath_float::format::{Format, ParseFormatError};
//!
//! let half: Format = "fp16".parse()?;
//! assert_eq!((half, half.name(), half.to_string()), (Format::BINARY16, "fp16".into(), "e5s11".into()));
//!
//! let third = half.from_f64(1.0 / 3.0);
//! assert_eq!(half.to_f64(half.add(third, half.mul(third, third))), 0.4443359375);
//! assert_eq!(half.decode(half.encode(third)), third);
//! # Ok::<(), ParseFormatError>(())
//! ```

mod name;
mod recoded;
mod soft;

pub use name::ParseFormatError;
use thiserror::Error;

/// A binary floating-point format in IEEE 754's layout: exponent bits, and significand bits with the hidden bit
/// included. `Display` writes `e8s24`; [`Format::name`] is its name in the user interface.
///
/// Functions take and return numbers as codes: the bits of IEEE 754's layout in the low [`Format::ieee_width`] bits of
/// a `u64`. They ignore the bits above in arguments, and return zeros there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Format {
    exponent: u32,
    significand: u32,
}

/// The reason why widths are not those of a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum FormatError {
    /// Too few or too many exponent bits.
    #[error("format with an exponent of {0} bits, expected 3 to 11")]
    Exponent(u32),
    /// Too few or too many significand bits.
    #[error("format with a significand of {significand} bits, expected 3 to {most} for an exponent of {exponent} bits")]
    Significand {
        /// The exponent bits.
        exponent: u32,
        /// The significand bits.
        significand: u32,
        /// The greatest width that this exponent allows.
        most: u32,
    },
}

impl Format {
    /// IEEE 754 binary32.
    pub const BINARY32: Self = Self { exponent: 8, significand: 24 };
    /// TensorFloat-32: binary32's range in 19 bits.
    pub const TF32: Self = Self { exponent: 8, significand: 11 };
    /// bfloat16: the upper half of binary32.
    pub const BFLOAT16: Self = Self { exponent: 8, significand: 8 };
    /// IEEE 754 binary16.
    pub const BINARY16: Self = Self { exponent: 5, significand: 11 };

    /// IEEE 754 binary64, to convert from and to `f64`. It is wider than [`Format::new`] allows, and so not public.
    pub(crate) const BINARY64: Self = Self { exponent: 11, significand: 53 };

    /// A format of 3 to 11 exponent bits and 3 to 24 significand bits, but at most 2^(exponent-2) + 3 significand bits:
    /// with more, the smallest subnormals would need the recoded exponents that encode zero.
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
    #[inline]
    pub fn exponent(self) -> u32 {
        self.exponent
    }

    /// Significand bits, hidden bit included.
    #[inline]
    pub fn significand(self) -> u32 {
        self.significand
    }

    /// Bits of a fraction: the significand without its hidden bit.
    #[inline]
    pub fn fraction_width(self) -> u32 {
        self.significand - 1
    }

    /// Bits of a number in IEEE 754's layout.
    #[inline]
    pub fn ieee_width(self) -> u32 {
        self.exponent + self.significand
    }

    /// Bits of a recoded number.
    #[inline]
    pub fn recoded_width(self) -> u32 {
        self.ieee_width() + 1
    }

    /// Bits of the window to which the terms of a sum are truncated before they are added, and the sum is rounded once
    /// (docs/reference/semantics.md): those of the significand, and the bits of the number of terms.
    #[inline]
    pub fn sum_window(self, terms: u32) -> u32 {
        self.significand + terms.next_power_of_two().ilog2()
    }

    /// The code of +infinity.
    #[inline]
    pub fn infinity(self) -> u64 {
        mask(self.exponent) << self.fraction_width()
    }

    /// The code of the canonical NaN: sign 0, all exponent bits and the top bit of the fraction set.
    #[inline]
    pub fn nan(self) -> u64 {
        self.infinity() | 1 << (self.fraction_width() - 1)
    }

    /// The code of -0: the sign bit.
    #[inline]
    pub(crate) fn sign_bit(self) -> u64 {
        1 << (self.ieee_width() - 1)
    }

    /// Sign, exponent and fraction of a number whose exponent has `exponent_width` bits.
    #[inline]
    pub(crate) fn split(self, number: u64, exponent_width: u32) -> (u64, u64, u64) {
        let fraction = number & mask(self.fraction_width());
        let exponent = number >> self.fraction_width() & mask(exponent_width);
        (number >> (self.fraction_width() + exponent_width) & 1, exponent, fraction)
    }
}

#[inline]
pub(crate) fn mask(bits: u32) -> u64 {
    (1 << bits) - 1
}
