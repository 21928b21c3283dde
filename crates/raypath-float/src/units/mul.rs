//! Product of two recoded numbers.
//!
//! Hardware: an adder for the exponents. For the significands, one multiple of the multiplicand for every three bits of
//! the multiplier (`booth.rs`), full adders that reduce them to two rows (`compress.rs`), and a carry-lookahead adder
//! (`lookahead.rs`). Then the product is rounded (`round.rs`). If operands or exponents alone determine the result, its
//! class replaces the exponent.
//!
//! Tests in `tests/units`: `small_formats.rs` (all operands, soft float), `binary32.rs` (the host's `f32`),
//! `other_formats.rs` (soft float), `verilator.rs`; in all of them whole and in parts.

use crate::Format;
use crate::units::booth;
use crate::units::compress::{Row, compress};
use crate::units::constants::Constants;
use crate::units::flags;
use crate::units::lookahead;
use crate::units::parts::{Parts, cut};
use crate::units::recoded::Magnitude;
use crate::units::round::Unrounded;
use raypath_hdl::{Error, Formula, Module};
use std::sync::Arc;

/// The module `raypath_fp_mul_<format>`: `product_o = a_i * b_i`.
pub fn mul(format: Format) -> Result<Arc<Module>, Error> {
    Ok(mul_parts(format, 1, false)?.remove(0))
}

/// The multiplier in 1, 2 or 3 parts, with or without the output `flags_o`, like [`add_parts`](crate::add_parts).
///
/// # Errors
/// Another number of parts.
pub fn mul_parts(format: Format, parts: u32, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
    Parts::build("mul", "Product of two recoded numbers", format, with_flags, parts, |parts| {
        describe(format, parts, with_flags)
    })
}

fn describe(format: Format, parts: &mut Parts<'_>, with_flags: bool) {
    let (e, s) = (format.exponent(), format.significand());
    let m = parts.builder();
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));

    m.section("Exponent, or the class of a settled result");
    let exponent_sum = (a.exponent().extend(e + 2) + b.exponent().extend(e + 2)).named("exponent_sum");
    // With a smaller exponent sum, a product of significands in [1, 4) is less than half the smallest subnormal.
    let constants = Constants(format);
    let bias = Formula::from(1) << constants.exp_bits();
    let least_sum = constants.min_normal() + bias.clone() - (constants.sig_bits() + 1);
    let vanishes = exponent_sum.less(m.parameter("MinExpSum", e + 2, least_sum)).named("vanishes");
    let overflow_sum = Formula::from(5) << (constants.exp_bits() - 1);
    let overflows = (!exponent_sum.less(m.parameter("InfiniteExpSum", e + 2, overflow_sum))).named("overflows");
    let zero_times_infinity = (a.is_zero() & b.is_infinite()) | (a.is_infinite() & b.is_zero());
    let nan = (a.is_nan() | b.is_nan() | zero_times_infinity).named("nan");
    let special = (nan | a.is_infinite() | b.is_infinite() | overflows).named("special");
    let settled = (special | a.is_zero() | b.is_zero() | vanishes).named("settled");
    let class = m.concat(&[special, special, nan, m.constant(e - 2, 0)]);
    let biased = exponent_sum.lower(e + 1) - m.parameter("Bias", e + 1, bias);
    let exponent = settled.mux(class, biased).named("exponent");
    let sign = ((a_i.top() ^ b_i.top()) & !nan).named("sign");

    if with_flags {
        parts.take_along("invalid", zero_times_infinity.named("invalid"));
        let special = a.exponent().upper(2).all() | b.exponent().upper(2).all();
        parts.take_along("ordinary", (!special & !a.is_zero() & !b.is_zero()).named("ordinary"));
    }

    m.section("Multiples");
    let multiplicand = m.concat(&[m.constant(1, 1), a.fraction()]).named("multiplicand");
    let triple_above = booth::triple_above(multiplicand).named("triple_above");
    let (multiplicand, multiplier) = (multiplicand.lower(s - 1), b.fraction());
    cut!(parts, [(1, 3)], multiplicand, triple_above, multiplier, exponent, settled, sign);
    let m = parts.builder();
    let multiplicand = m.concat(&[m.constant(1, 1), multiplicand]).named("factor");
    let triple = m.concat(&[triple_above, multiplicand.bit(0)]);

    m.section("Multiply");
    let mut rows = booth::rows(multiplicand, triple, multiplier, 2 * s);
    // The multiplier's hidden bit.
    rows.push(Row { word: multiplicand, low: s - 1 });
    let rows = compress(rows, 2 * s);
    let [addend, augend] = [0, 1].map(|row| rows[row].columns(0, 2 * s));
    let (addend, augend) = (addend.named("addend"), augend.named("augend"));

    m.section("Add; the lower columns give a carry and a sticky bit");
    let low = lookahead::add(addend.lower(s - 2), augend.lower(s - 2), None, "low");
    let sticky = low.word.any().named("sticky");
    let (addend, augend, low_carry) = (addend.upper(s + 2), augend.upper(s + 2), low.carry);
    cut!(parts, [(1, 2), (2, 3)], addend, augend, low_carry, sticky, exponent, settled, sign);
    let m = parts.builder();
    let word = lookahead::add(addend, augend, Some(low_carry), "high");
    m.unused("unused_carry", &[word.carry]);
    let word = word.word.named("word");

    let rounded = Unrounded { format, word, sticky, exponent, settled, sign }.round();
    m.output("product_o", rounded.number);
    if with_flags {
        m.section("Exceptions");
        let absent = m.constant(1, 0);
        let [invalid, ordinary] = ["invalid", "ordinary"].map(|stem| parts.along(stem).unwrap_or(absent));
        let overflow = (ordinary & rounded.exponent.upper(2).all()).named("overflow");
        let inexact = (overflow | (ordinary & rounded.is_inexact())).named("inexact");
        let underflow = (inexact & rounded.is_tiny() & !overflow).named("underflow");
        flags::output(m, [Some(invalid), Some(overflow), Some(underflow), Some(inexact)]);
    }
}
