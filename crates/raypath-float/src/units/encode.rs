//! IEEE 754's layout to the recoded format.
//!
//! Hardware: a normalising shift for subnormal fractions, which does nothing if the hidden bit is set, and one adder
//! for the new bias of the exponent. This addition also maps infinity to the recoded infinity.
//!
//! Checked by `verify unit-proofs` (canonical words, decoded to the number, for all numbers) and, in
//! `raypath-verify-arithmetic`, `tests/units/conversions.rs` (the table of the format).

use crate::Format;
use crate::units::constants::Constants;
use crate::units::normalise::Normalised;
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
    let zeros = |width| m.constant(width, 0);

    m.section("Subnormal numbers: the leading one becomes hidden");
    let subnormal = (!biased.any()).named("subnormal");
    let significand = m.concat(&[!subnormal, fraction]).named("significand");
    let normalised = Normalised::of(significand);
    let leading_zeros = normalised.leading_zeros();
    let filled = normalised.word.upper(2).any().named("filled");

    m.section("Change the bias");
    // Minus the leading zeros is their complement plus one; the biased exponent of the smallest normal numbers is 1.
    let complement = !leading_zeros.extend(e + 1) & subnormal.replicate(e + 1);
    let step = (biased.extend(e + 1) | complement).named("step");
    let two_if_subnormal = m.concat(&[zeros(e - 1), subnormal, zeros(1)]);
    let bias = m.parameter("Bias", e + 1, Constants(format).min_normal() - 1) | two_if_subnormal;
    let exponent = (step + bias).named("exponent");

    m.section("Result");
    let nan = (biased.all() & fraction.any()).named("nan");
    let number = normalised.fraction(s - 1, !nan);
    m.output(
        "recoded_o",
        m.concat(&[
            sign & !nan,
            ((exponent & filled.replicate(e + 1)) | m.concat(&[zeros(2), nan, zeros(e - 2)])).named("result_exponent"),
            (number | m.concat(&[nan, zeros(s - 2)])).named("result_fraction"),
        ]),
    );
    m.finish()
}
