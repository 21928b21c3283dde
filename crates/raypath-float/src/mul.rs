//! Product of two recoded numbers.
//!
//! Hardware: an adder for the exponents, a multiplier for the significands, and rounding. The bits that the result
//! loses are marked by a mask, in which the exponent sum alone sets the bits that are lost below the normal range; it
//! is ready before the product is. Half of a last place is added at the mask's edge and the mask cut away, the last
//! place itself too on a tie. Only then the result is normalised, by one place.
//!
//! Tests in `tests/units`: `small_formats.rs` (all operands, exact products), `binary32.rs` (the host's `f32`),
//! `other_formats.rs` (exact products), `verilator.rs`.

use crate::Format;
use crate::parts::Parts;
use crate::recoded::{Magnitude, Outcome};
use raypath_hdl::{Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_mul_<format>`: `product_o = a_i * b_i`.
pub fn mul(format: Format) -> Result<Arc<Module>, Error> {
    Ok(mul_parts(format, 1)?.remove(0))
}

/// The same in `parts` modules, 1 or 2.
pub fn mul_parts(format: Format, parts: u32) -> Result<Vec<Arc<Module>>, Error> {
    let doc = "Product of two recoded numbers, rounded to nearest even.";
    Parts::build(&format!("raypath_fp_mul_{format}"), doc, parts, |parts| describe(format, parts))
}

fn describe(format: Format, parts: &mut Parts<'_>) {
    let (e, s) = (format.exponent(), format.significand());
    let m = parts.builder();
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));
    let sign = (a_i.top() ^ b_i.top()).named("sign");

    m.section("Operands that are no numbers");
    let zero_times_infinity = (a.is_zero() & b.is_infinite()) | (a.is_infinite() & b.is_zero());
    let zero_times_infinity = zero_times_infinity.named("zero_times_infinity");
    let nan = (a.is_nan() | b.is_nan() | zero_times_infinity).named("operand_nan");
    let infinite = (a.is_infinite() | b.is_infinite()).named("operand_infinite");

    m.section("Multiply");
    let exponent_sum = (a.exponent().extend(e + 2) + b.exponent().extend(e + 2)).named("exponent_sum");
    let a_significand = a.significand().named("a_significand");
    let b_significand = b.significand().named("b_significand");
    let product = (a_significand * b_significand).named("product");

    let [product, exponent_sum, sign, nan, infinite] = parts.cut(
        1,
        2,
        [
            ("product", product),
            ("exponent_sum", exponent_sum),
            ("sign", sign),
            ("operand_nan", nan),
            ("operand_infinite", infinite),
        ],
    );
    let m = parts.builder();

    m.section("Mark the bits to lose: one or two, and more below the normal range");
    // With a smaller exponent sum, a product of significands in [1, 4) is less than half the smallest subnormal.
    let least_sum = format.least_normal() + (1 << e) - u64::from(s + 1);
    let above_least = (exponent_sum - m.constant(e + 2, least_sum)).named("above_least");
    let vanishes = above_least.top().named("vanishes");
    let subnormal = m.constant(s + 1, (1 << (s + 1)) - 1).shift_right(above_least.lower(e + 1)).named("subnormal");
    let carried = product.top().named("carried");
    let zero = m.constant(1, 0);
    let lost_half = subnormal.bit(0) | carried;
    let lost = m.concat(&[zero, subnormal.upper(s), lost_half, m.constant(1, 1)]).named("lost");
    let lost_below = m.concat(&[zero, lost.upper(s + 2)]).named("lost_below_half");
    let half = (lost & !lost_below).named("half");
    let last_place = (m.concat(&[lost.lower(s + 2), zero]) & !lost).named("last_place");

    m.section("Round");
    let word = product.upper(s + 2).extend(s + 3).named("word");
    let sticky = product.lower(s - 2).any().named("sticky");
    let tie = ((word & half).any() & !((word & lost_below).any() | sticky)).named("tie");
    let cut = (lost | (tie.replicate(s + 3) & last_place)).named("cut");
    let rounded = ((word + half) & !cut).named("rounded");
    m.unused("unused_half", &[rounded.bit(0)]);

    m.section("Normalise; the leading one is in the upper three bits");
    let exponent = exponent_sum.lower(e + 1) - m.constant(e + 1, 1 << e) + rounded.upper(2).extend(e + 1);
    let exponent = exponent.named("exponent");
    let fraction = rounded.bit(s + 1).mux(rounded.bits(s, 2), rounded.bits(s - 1, 1)).named("fraction");

    m.section("Result");
    let product_is_zero = (vanishes | !rounded.upper(3).any()).named("zero");
    let overflow = (exponent.upper(2).all() & !product_is_zero).named("overflow");
    let result = Outcome {
        nan,
        infinite: (infinite | overflow).named("infinite"),
        zero: product_is_zero,
        sign,
        exponent,
        fraction,
    };
    m.output("product_o", result.pack(m));
}
