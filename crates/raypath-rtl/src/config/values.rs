//! How the values of parameters are written on the command line and in files.

use raypath_float::Format;
use raypath_ops::{Culling, Rules};
use std::str::FromStr;

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

fn parse<T: FromStr<Err: ToString>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|problem: T::Err| problem.to_string())
}

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

impl Values<Self> for Format {
    const TEXTS: &'static str = "fp32|tf32|bf16|fp16|eXsY";
    fn parse(text: &str) -> Result<Self, String> {
        parse(text)
    }
    fn write(value: Self) -> String {
        value.name()
    }
}

impl Values<Self> for Rules {
    const TEXTS: &'static str = "paper|chisel";
    fn parse(text: &str) -> Result<Self, String> {
        parse(text)
    }
    fn write(value: Self) -> String {
        value.to_string()
    }
}

impl Values<Self> for Culling {
    const TEXTS: &'static str = "back|front|none";
    fn parse(text: &str) -> Result<Self, String> {
        parse(text)
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
        let max = MAX_TAG_WIDTH;
        let width = text.parse().ok().filter(|&width| width <= max);
        width.ok_or_else(|| format!("'{text}', expected a whole number from 0 to {max}"))
    }
    fn write(width: u32) -> String {
        width.to_string()
    }
}
