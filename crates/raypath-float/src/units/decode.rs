//! The recoded format to IEEE 754's layout.
//!
//! Hardware: a shift right for subnormal fractions, and a subtractor for the old bias of the exponent.
//!
//! Checked by `verify unit-proofs` (all numbers, and all words of the classes zero, infinity and NaN).

use crate::Format;
use crate::units::constants::Constants;
use crate::units::narrow::narrowed;
use crate::units::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_decode_<format>`: `ieee_o` is the number `recoded_i`, which must be a number of the
/// format. The result is exact.
pub fn decode(format: Format) -> Result<Arc<Module>, Error> {
    let (e, s) = (format.exponent(), format.significand());
    let m = Builder::new(&format!("raypath_fp_decode_{format}"));
    m.doc("Recoded to IEEE 754.");
    let recoded_i = m.input("recoded_i", format.recoded_width());
    let number = Magnitude::of(format, recoded_i);
    let exponent = number.exponent().named("exponent");

    m.section("Subnormal numbers: the hidden bit becomes part of the fraction");
    let subnormal = exponent.less(m.parameter("MinNormal", e + 1, Constants(format).min_normal())).named("subnormal");
    let layers = s.next_power_of_two().ilog2();
    let depth = m.constant(layers, format.least_normal() & ((1 << layers) - 1)) - exponent.lower(layers);
    let depth = (depth & subnormal.replicate(layers)).named("depth");
    let significand = m.concat(&[m.constant(1, 1), number.fraction()]).named("significand");
    let shifted = (1..layers).rev().fold(significand, |word, layer| {
        let step = 1 << layer;
        depth.bit(layer).mux(word.shift_right(m.constant(layers, step)), word).named(&format!("shifted_{step}"))
    });

    m.section("Result");
    let nan = number.is_nan().named("nan");
    let special = exponent.upper(2).all().named("special");
    let finite = (!special & !number.is_zero()).named("finite");
    let f = s - 1;
    let take_0 = (finite & !depth.bit(0)).named("take_0");
    let take_1 = (finite & depth.bit(0)).named("take_1");
    let fraction = (take_0.replicate(f) & shifted.lower(f))
        | (take_1.replicate(f) & shifted.upper(f))
        | m.concat(&[nan, m.constant(f - 1, 0)]);
    let biased = exponent.lower(e) - m.parameter("Bias", e, Constants(format).min_normal() - 1);
    let biased = ((biased & (!subnormal).replicate(e)) | special.replicate(e)).named("biased");
    m.output("ieee_o", m.concat(&[recoded_i.top() & !nan, biased, fraction]));
    m.finish()
}

/// The decoder of numbers of `format` that have significands of `bits` bits and are not subnormal: that of the format
/// with such a significand. The words have no lower bits of the fractions, which are zeros.
///
/// # Errors
/// A significand of less than 3 bits or of more than the format has.
pub fn decode_narrow(format: Format, bits: u32) -> Result<Arc<Module>, Error> {
    decode(narrowed(format, bits, "raypath_fp_decode", "recoded_i")?)
}
