//! Small unsigned words to the recoded format.
//!
//! Hardware: a normalising shift, whose count of leading zeros is the complement of the exponent. The result is exact.
//!
//! Tests in `raypath-verify-arithmetic`, `tests/units/conversions.rs` (all words, by the format in software, which has
//! its tests).

use crate::Format;
use crate::units::normalise::Normalised;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_number_<format>_w<width>`: `recoded_o` is the value of the unsigned word `word_i` of `width`
/// bits, exact.
///
/// # Errors
/// A width of 0 or more than 16 bits, or more bits than the format represents exactly: more than the significand has,
/// or more than `2^(exponent bits - 1)`.
pub fn number(format: Format, width: u32) -> Result<Arc<Module>, Error> {
    let (e, s) = (format.exponent(), format.significand());
    let name = format!("raypath_fp_number_{format}_w{width}");
    let widest = s.min(1 << (e - 1)).min(16);
    if !(1..=widest).contains(&width) {
        let problem = format!("has {width} bits, expected 1 to {widest}, so that the format represents all values");
        return Err(Error::Width { module: name, signal: "word_i".to_string(), problem });
    }
    let m = Builder::new(&name);
    m.doc("A word as a recoded number, exact.");
    let word = m.input("word_i", width);
    // The shifter is of three bits at least.
    let places = width.max(3);
    let padded = if places > width { word.extend(places) } else { word };
    let normalised = Normalised::of(padded);
    let leading_zeros = normalised.leading_zeros();
    let filled = normalised.word.upper(2).any().named("filled");

    m.section("Result");
    let exponent = (m.constant(leading_zeros.width(), (places - 1).into()) - leading_zeros).named("exponent");
    let exponent = m.concat(&[m.constant(1, 1), exponent.extend(e)]);
    let mut parts = vec![m.constant(1, 0), exponent & filled.replicate(e + 1), normalised.fraction(places - 1, filled)];
    if s > places {
        parts.push(m.constant(s - places, 0));
    }
    m.output("recoded_o", m.concat(&parts));
    m.finish()
}
