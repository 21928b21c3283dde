//! Comparison of two recoded numbers.
//!
//! Hardware: exponents and fractions are compared in parallel as unsigned words, for less and for equal. The magnitudes
//! of all infinities are equal, and so are those of all zeros.
//!
//! Checked by `verify unit-proofs` (symfpu, all operands) and `testfloat` (SoftFloat).

use crate::Format;
use crate::units::narrow::narrowed;
use crate::units::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module `raypath_fp_compare_<format>`: `less_o` for `a_i < b_i`, `equal_o` (-0 equals +0), and `unordered_o`
/// if one is NaN; at most one of them is set.
pub fn compare(format: Format) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("raypath_fp_compare_{format}"));
    m.doc("Comparison of two recoded numbers.");
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));
    let a_negative = a_i.top().named("a_negative");
    let b_negative = b_i.top().named("b_negative");

    m.section("Magnitudes as words");
    let exponents = Order::of("exponent", a.exponent(), b.exponent());
    let fractions = Order::of("fraction", a.fraction(), b.fraction());
    let less = (exponents.less | (exponents.covered & fractions.less)).named("less");
    let equal = (exponents.covered & fractions.covered & !less).named("equal");

    m.section("Magnitudes, without the lower bits of zeros and infinities");
    let both_zero = (a.is_zero() & b.is_zero()).named("both_zero");
    let both_infinite = (a.is_infinite() & b.is_infinite()).hint("both_infinite");
    let same = (equal | both_zero | both_infinite).named("same");
    let smaller = (less & !same).named("smaller");
    let larger = (!less & !same).named("larger");

    m.section("Signs");
    let unordered = (a.is_nan() | b.is_nan()).named("unordered");
    let same_sign = (!(a_negative ^ b_negative)).named("same_sign");
    let less_alike = a_negative.mux(larger, smaller).named("less_alike");
    let less_apart = (a_negative & !both_zero).named("less_apart");
    m.output("less_o", !unordered & same_sign.mux(less_alike, less_apart));
    m.output("equal_o", !unordered & same & (same_sign | both_zero));
    m.output("unordered_o", unordered);
    m.finish()
}

/// The comparison of two numbers of `format` that have significands of `bits` bits: that of the format with such a
/// significand. The words have no lower bits of the fractions, which are zeros.
///
/// # Errors
/// A significand of less than 3 bits or of more than the format has.
pub fn compare_narrow(format: Format, bits: u32) -> Result<Arc<Module>, Error> {
    compare(narrowed(format, bits, "raypath_fp_compare", "a_i")?)
}

/// The order of two words. They are equal if `b` covers `a` and `a` is not less.
struct Order<'m> {
    less: Wire<'m>,
    /// Every bit that is set in `a` is set in `b`, so `a` is not greater. The gates are those of `less`.
    covered: Wire<'m>,
}

impl<'m> Order<'m> {
    fn of(name: &str, a: Wire<'m>, b: Wire<'m>) -> Self {
        Self {
            less: a.less(b).named(&format!("{name}_less")),
            covered: (!(a & !b).hint(&format!("{name}_above")).any()).named(&format!("{name}_covered")),
        }
    }
}
