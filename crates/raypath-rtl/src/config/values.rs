//! How the values of parameters are written on the command line and in files.

use super::enumerations::UnitLatency;
use raypath_float::Format;
use raypath_ops::{BoxBits, Culling, EdgeRule, Rounding, Rules};

/// The greatest width of a tag in bits.
pub const MAX_TAG_WIDTH: u32 = 32;

/// How a parameter's values of type `T` are written.
pub trait Values<T> {
    /// The accepted texts, separated by `|`.
    const TEXTS: &'static str;
    /// Whether the flag alone means `true`.
    const IS_SWITCH: bool = false;

    /// Reads a value; the message of an error quotes the text and says what was expected.
    fn parse(text: &str) -> Result<T, String>;

    /// Writes a value.
    fn write(value: T) -> String;
}

/// Implements [`Values`] for a type by its `FromStr`, and by `Display` or the method that is named.
macro_rules! values_by_text {
    ($type:ty, $texts:expr, $write:ident) => {
        impl $crate::config::values::Values<Self> for $type {
            const TEXTS: &'static str = $texts;
            fn parse(text: &str) -> Result<Self, String> {
                text.parse().map_err(|problem: <Self as std::str::FromStr>::Err| problem.to_string())
            }
            fn write(value: Self) -> String {
                value.$write()
            }
        }
    };
}
pub(super) use values_by_text;

values_by_text!(Format, "fp32|tf32|bf16|fp16|eXsY", name);
values_by_text!(Rules, "paper|chisel|bounds", to_string);
values_by_text!(BoxBits, "8..24", to_string);
values_by_text!(UnitLatency, "1..8|2/1..10/8", to_string);
values_by_text!(Rounding, "unit|sum", to_string);
values_by_text!(EdgeRule, "shared|once", to_string);
values_by_text!(Culling, "back|front|none", to_string);

impl Values<Self> for bool {
    const TEXTS: &'static str = "true|false";
    const IS_SWITCH: bool = true;
    fn parse(text: &str) -> Result<Self, String> {
        text.parse().map_err(|_| format!("'{text}', expected true or false"))
    }
    fn write(value: Self) -> String {
        value.to_string()
    }
}

/// The texts of a tag's width.
pub struct TagWidth;

impl Values<u32> for TagWidth {
    const TEXTS: &'static str = "0..32";
    fn parse(text: &str) -> Result<u32, String> {
        whole(text, |width| width <= MAX_TAG_WIDTH, "0 to 32")
    }
    fn write(width: u32) -> String {
        width.to_string()
    }
}

/// The texts of the least length of a delay line. A memory has two words or more.
pub struct DelayLines;

impl Values<u32> for DelayLines {
    const TEXTS: &'static str = "0|3..64";
    fn parse(text: &str) -> Result<u32, String> {
        whole(text, |steps| steps == 0 || (3..=64).contains(&steps), "3 to 64, or 0")
    }
    fn write(steps: u32) -> String {
        steps.to_string()
    }
}

fn whole(text: &str, is_valid: impl Fn(u32) -> bool, expected: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| is_valid(*number));
    number.ok_or_else(|| format!("'{text}', expected a whole number from {expected}"))
}
