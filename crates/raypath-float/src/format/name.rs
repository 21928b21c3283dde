//! The names of formats.

use crate::format::{Format, FormatError};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Formats that have a name besides `eXsY`.
const NAMED: [(&str, Format); 4] =
    [("fp32", Format::BINARY32), ("tf32", Format::TF32), ("bf16", Format::BFLOAT16), ("fp16", Format::BINARY16)];

/// The reason why a text does not name a format.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ParseFormatError {
    /// Not one of the names.
    #[error(
        "'{0}' is not a valid format, expected fp32, tf32, bf16, fp16 or eXsY: X exponent bits, \
         Y significand bits with the hidden one"
    )]
    Name(String),
    /// Widths that no format has.
    #[error("'{name}': {problem}")]
    Widths {
        /// The text.
        name: String,
        /// The invalid width.
        problem: FormatError,
    },
}

impl Format {
    /// Its name: `fp32`, `tf32`, `bf16`, `fp16`, or for other formats their widths, such as `e5s3`. [`FromStr`] parses
    /// it.
    pub fn name(self) -> String {
        let named = NAMED.iter().find(|(_, format)| *format == self);
        named.map_or_else(|| self.to_string(), |(name, _)| name.to_string())
    }
}

impl FromStr for Format {
    type Err = ParseFormatError;

    /// Parses the names that [`Format::name`] returns; the form `eXsY` is accepted for every format.
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
