//! The recoded format to IEEE 754's layout.
//!
//! Hardware: a shift right for subnormal fractions, and a subtractor that gives the exponent its old bias.
//!
//! Tests in `tests/units`: `small_formats.rs` (all numbers, by the format's definition), `binary32.rs`, `verilator.rs`.

use crate::Format;
use crate::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_decode_<format>`: `ieee_o` is the number `recoded_i`, which must be one of the format: there
/// is nothing to round.
pub fn decode(format: Format) -> Result<Arc<Module>, Error> {
    let (e, s) = (format.exponent(), format.significand());
    let m = Builder::new(&format!("raypath_fp_decode_{format}"));
    m.doc("Recoded to IEEE 754.");
    let recoded_i = m.input("recoded_i", format.recoded_width());
    let number = Magnitude::of(format, recoded_i);
    let exponent = number.exponent().named("exponent");
    let zeros = m.constant(s - 2, 0);

    m.section("Below the normal range the hidden bit shows");
    let subnormal = exponent.less(m.constant(e + 1, format.least_normal())).named("subnormal");
    // The lowest bits of the exponent tell how far below.
    let depth_width = (s - 1).next_power_of_two().ilog2();
    let depth = (m.constant(depth_width, 1) - exponent.lower(depth_width)).named("depth");
    let significand = m.concat(&[!number.is_zero(), number.fraction().upper(s - 2)]);
    let shifted = significand.shift_right(depth).named("shifted");

    m.section("Result");
    let nan = number.is_nan().named("nan");
    let special = (nan | number.is_infinite()).named("special");
    let biased = exponent.lower(e) - m.constant(e, format.least_normal() - 1);
    let biased = ((biased & (!subnormal).replicate(e)) | special.replicate(e)).named("biased");
    let fraction = subnormal.mux(shifted, number.fraction());
    let fraction = special.mux(m.concat(&[nan, zeros]), fraction).named("fraction");
    m.output("ieee_o", m.concat(&[recoded_i.top() & !nan, biased, fraction]));
    m.finish()
}
