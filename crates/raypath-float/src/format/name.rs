//! What formats are called.

use crate::format::{Format, FormatError};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Formats with a name of their own.
const NAMED: [(&str, Format); 4] =
    [("fp32", Format::BINARY32), ("tf32", Format::TF32), ("bf16", Format::BFLOAT16), ("fp16", Format::BINARY16)];

/// A name that is no format's.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ParseFormatError {
    /// It is none of the names.
    #[error(
        "'{0}' is no format, expected fp32, tf32, bf16, fp16 or eXsY: X exponent bits, Y significand bits with the \
         hidden one"
    )]
    Name(String),
    /// It gives widths that no format has.
    #[error("'{name}': {problem}")]
    Widths {
        /// What was given.
        name: String,
        /// What is wrong with it.
        problem: FormatError,
    },
}

impl Format {
    /// What users call it: `fp32`, `tf32`, `bf16`, `fp16`, else by its widths like `e5s3`. [`FromStr`] reads it back.
    pub fn name(self) -> String {
        let named = NAMED.iter().find(|(_, format)| *format == self);
        named.map_or_else(|| self.to_string(), |(name, _)| name.to_string())
    }
}

impl FromStr for Format {
    type Err = ParseFormatError;

    /// Reads a name as [`Format::name`] gives it; widths are understood for every format.
    fn from_str(name: &str) -> Result<Self, ParseFormatError> {
        if let Some((_, format)) = NAMED.iter().find(|(known, _)| *known == name) {
            return Ok(*format);
        }
        let (exponent, significand) = widths(name).ok_or_else(|| ParseFormatError::Name(name.to_string()))?;
        Self::new(exponent, significand).map_err(|problem| ParseFormatError::Widths { name: name.to_string(), problem })
    }
}

/// The two numbers of `eXsY`.
fn widths(name: &str) -> Option<(u32, u32)> {
    let (exponent, significand) = name.strip_prefix('e')?.split_once('s')?;
    let number = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_digit()).then(|| digits.parse().ok())?;
    Some((number(exponent)?, number(significand)?))
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "e{}s{}", self.exponent(), self.significand())
    }
}
