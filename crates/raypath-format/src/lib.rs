//! Floating-point formats in software, of 3 to 11 exponent bits and 3 to 24 significand bits: what they are called,
//! exact arithmetic in them, and their numbers in the recoded format of the hardware.
//!
//! Arithmetic is IEEE 754's, rounded to nearest even, with subnormals. Every NaN that comes out is canonical: no sign,
//! and of the fraction the top bit alone, in binary32 `7fc00000`.
//!
//! ```
//! use raypath_format::Format;
//!
//! let half: Format = "fp16".parse()?;
//! assert_eq!((half, half.name(), half.to_string()), (Format::BINARY16, "fp16".into(), "e5s11".into()));
//!
//! let third = half.from_f64(1.0 / 3.0);
//! assert_eq!(half.to_f64(half.add(third, half.mul(third, third))), 0.4443359375);
//! assert_eq!(half.decode(half.encode(third)), third);
//! # Ok::<(), raypath_format::ParseFormatError>(())
//! ```

mod format;
mod name;
mod recoded;
mod soft;

pub use format::{Format, FormatError};
pub use name::ParseFormatError;
