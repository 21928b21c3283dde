//! IEEE 754's layout to the recoded format.
//!
//! Hardware: a normalising shift for subnormal fractions, and one adder that gives the exponent its new bias. IEEE's
//! infinity becomes the recoded infinity by that addition alone.
//!
//! Tests in `tests/units`: `small_formats.rs` (all numbers, by the format's definition), `binary32.rs`, `verilator.rs`.

use crate::Format;
use crate::normalise::normalise;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_encode_<format>`: `recoded_o` is the number `ieee_i`.
pub fn encode(format: Format) -> Result<Arc<Module>, Error> {
    let (e, s) = (format.exponent(), format.significand());
    let m = Builder::new(&format!("raypath_fp_encode_{format}"));
    m.doc("IEEE 754 to recoded.");
    let ieee_i = m.input("ieee_i", format.ieee_width());
    let sign = ieee_i.top();
    let biased = ieee_i.bits(e + s - 2, s - 1).named("biased");
    let fraction = ieee_i.lower(s - 1).named("fraction");

    m.section("Subnormal numbers: the leading one becomes hidden");
    let subnormal = (!biased.any()).named("subnormal");
    let normalised = normalise(fraction);
    let zero = (subnormal & !normalised.word.top()).named("zero");
    let shifted = m.concat(&[normalised.word.lower(s - 2), m.constant(1, 0)]);

    m.section("Change the bias");
    // Minus the leading zeros is their complement plus one.
    let step = subnormal.mux(!normalised.count.extend(e + 1), biased.extend(e + 1)).named("step");
    let normal_bias = format.least_normal() - 1;
    let bias = subnormal.mux(m.constant(e + 1, normal_bias + 1), m.constant(e + 1, normal_bias));
    let exponent = (step + bias).named("exponent");

    m.section("Result");
    let nan = (biased.all() & fraction.any()).named("nan");
    let nan_bit = m.constant(e + 1, 1 << (e - 2));
    let nan_fraction = m.constant(s - 1, 1 << (s - 2));
    let number = subnormal.mux(shifted, fraction).named("number");
    m.output(
        "recoded_o",
        m.concat(&[
            sign & !nan,
            ((exponent & (!zero).replicate(e + 1)) | (nan_bit & nan.replicate(e + 1))).named("result_exponent"),
            nan.mux(nan_fraction, number).named("result_fraction"),
        ]),
    );
    m.finish()
}
