//! Floating-point formats in software, of 3 to 11 exponent bits and 3 to 24 significand bits: what they are called,
//! and their numbers in IEEE 754's layout and in the recoded format of the hardware.
//!
//! ```
//! use raypath_format::Format;
//!
//! let half: Format = "fp16".parse()?;
//! assert_eq!((half, half.name(), half.to_string()), (Format::BINARY16, "fp16".into(), "e5s11".into()));
//! let recoded = half.encode(0x3c00); // 1
//! assert_eq!(half.decode(recoded), 0x3c00);
//! # Ok::<(), raypath_format::ParseFormatError>(())
//! ```

mod format;
mod name;
mod recoded;

pub use format::{Format, FormatError};
pub use name::ParseFormatError;
