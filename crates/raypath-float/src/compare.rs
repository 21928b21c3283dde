//! Comparison of two recoded numbers.
//!
//! Hardware: one comparison of the magnitudes as words; all infinities are one magnitude, and so are all zeros.
//!
//! Tests in `tests/units`: `small_formats.rs` (all operands), `binary32.rs` (the host's `f32`), `other_formats.rs`,
//! `verilator.rs`.

use crate::Format;
use crate::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_compare_<format>`: `less_o` for `a_i < b_i`, `equal_o` (-0 equals +0), and `unordered_o`
/// where one is NaN; at most one of them is set.
pub fn compare(format: Format) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("raypath_fp_compare_{format}"));
    m.doc("Comparison of two recoded numbers.");
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));
    let a_negative = a_i.top().named("a_negative");
    let b_negative = b_i.top().named("b_negative");

    m.section("Magnitudes; the lower bits of zeros and infinities mean nothing");
    let both_zero = (a.is_zero() & b.is_zero()).named("both_zero");
    let same_class = (both_zero | (a.is_infinite() & b.is_infinite())).named("same_class");
    let same = (same_class | a.word.equals(b.word)).named("same");
    let smaller = (!same_class & a.word.less(b.word)).named("smaller");
    let larger = (!same & !smaller).named("larger");

    m.section("Signs");
    let unordered = (a.is_nan() | b.is_nan()).named("unordered");
    let less_apart = (a_negative & !b_negative & !both_zero).named("less_apart");
    let less_positive = (!a_negative & !b_negative & smaller).named("less_positive");
    let less_negative = (a_negative & b_negative & larger).named("less_negative");
    m.output("less_o", !unordered & (less_apart | less_positive | less_negative));
    m.output("equal_o", !unordered & same & (both_zero | !(a_negative ^ b_negative)));
    m.output("unordered_o", unordered);
    m.finish()
}
