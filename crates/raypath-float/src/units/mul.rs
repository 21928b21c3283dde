//! Product of two recoded numbers.
//!
//! Hardware: an adder for the exponents. For the significands, one multiple of the multiplicand for every three bits of
//! the multiplier (`booth.rs`), full adders that reduce them to two rows (`compress.rs`), and a carry-lookahead adder
//! (`lookahead.rs`); or the operator `*`, for which synthesis takes the multipliers of an FPGA. Then the product is
//! rounded (`round.rs`). If operands or exponents alone determine the result, its class replaces the exponent.
//!
//! Checked by `verify multiplication` (lemmas and symfpu, all operands), `unit-proofs` (the unit in parts) and
//! `testfloat` (SoftFloat).

use crate::Format;
use crate::units::booth;
use crate::units::compress::{Row, compress};
use crate::units::constants::Constants;
use crate::units::flags;
use crate::units::lookahead;
use crate::units::narrow::narrowed;
use crate::units::parts::{Parts, cut};
use crate::units::recoded::Magnitude;
use crate::units::round::{Unrounded, mark_lost};
use raypath_hdl::{Error, Formula, Module, Wire};
use std::sync::Arc;

/// What is known of a product before the significands are multiplied.
struct Factors<'m> {
    multiplicand: Magnitude<'m>,
    /// Of a significand of at most as many bits.
    multiplier: Magnitude<'m>,
    exponent: Wire<'m>,
    settled: Wire<'m>,
    sign: Wire<'m>,
}

/// The bits of the output `residue_o`.
const RESIDUE_BITS: u32 = 26;

/// Multiplies the significands in the remaining parts of a unit.
type Multiply = for<'m> fn(Format, &mut Parts<'m>, Factors<'m>) -> Product<'m>;

/// A product before it is rounded.
struct Product<'m> {
    unrounded: Unrounded<'m>,
    /// The digits behind its word, in a unit of one part.
    low: Wire<'m>,
}

/// An output besides the product.
#[derive(Clone, Copy, PartialEq)]
enum Extra {
    None,
    Flags,
    Residue,
}

impl Extra {
    fn flags_if(are_present: bool) -> Self {
        if are_present { Self::Flags } else { Self::None }
    }
}

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
        describe(format, format, parts, Extra::flags_if(with_flags), booth_product)
    })
}

/// The module `raypath_fp_mul_<format>_by_s<bits>`: the product of a number of `format` and one with a significand of
/// `bits` bits, whose word has no lower bits of the fraction, which are zeros. Divided like the multiplier of
/// [`mul_parts`], or with `inferred` like that of [`mul_inferred_parts`].
///
/// # Errors
/// Another number of parts; a significand of less than 3 bits or of more than the format has.
pub fn mul_by_short_parts(format: Format, bits: u32, parts: u32, inferred: bool) -> Result<Vec<Arc<Module>>, Error> {
    let (stem, product): (_, Multiply) =
        if inferred { ("mul_inferred", inferred_product) } else { ("mul", booth_product) };
    let name = format!("raypath_fp_{stem}_{format}_by_s{bits}");
    let factor = narrowed(format, bits, &name, "b_i")?;
    let doc = format!("Product of a recoded number and one of {factor}, rounded to nearest even.");
    Parts::build_module(&name, &doc, parts, |parts| describe(format, factor, parts, Extra::None, product))
}

/// The multiplier of [`mul_parts`] whose text multiplies significands with the operator `*`, so that synthesis for an
/// FPGA takes its multipliers. The modules are named `raypath_fp_mul_inferred_<format>` and so on. In two parts, the
/// product enters registers as it leaves `*`; in three, its factors leave registers too. Where these registers have
/// neither reset nor enable, they can be those of the FPGA's multipliers.
///
/// # Errors
/// Another number of parts.
pub fn mul_inferred_parts(format: Format, parts: u32, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
    Parts::build("mul_inferred", "Product of two recoded numbers", format, with_flags, parts, |parts| {
        describe(format, format, parts, Extra::flags_if(with_flags), inferred_product)
    })
}

/// The module `raypath_fp_mul_residue_<format>`: the multiplier of [`mul`], or with `inferred` that of
/// [`mul_inferred_parts`], with the output `residue_o`. Its 26 bits, from the highest on: the product is not 0 and below
/// the normal range; it is rounded down; the digits that rounding takes, then zeros. Of products that are equal after
/// rounding, the one of the greater magnitude has the greater residue. Zeros have the residue 0.
pub fn mul_with_residue(format: Format, inferred: bool) -> Result<Arc<Module>, Error> {
    let (stem, product): (_, Multiply) =
        if inferred { ("mul_inferred", inferred_product) } else { ("mul", booth_product) };
    let name = format!("raypath_fp_{stem}_residue_{format}");
    let doc = "Product of two recoded numbers, rounded to nearest even, and what rounding takes.";
    let describe = |parts: &mut Parts<'_>| describe(format, format, parts, Extra::Residue, product);
    Ok(Parts::build_module(&name, doc, 1, describe)?.remove(0))
}

fn describe(format: Format, factor: Format, parts: &mut Parts<'_>, extra: Extra, multiply: Multiply) {
    let e = format.exponent();
    let m = parts.builder();
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", factor.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(factor, b_i));

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

    if extra == Extra::Flags {
        parts.take_along("invalid", zero_times_infinity.named("invalid"));
        let special = a.exponent().upper(2).all() | b.exponent().upper(2).all();
        parts.take_along("ordinary", (!special & !a.is_zero() & !b.is_zero()).named("ordinary"));
    }

    let nonzero = !special & !a.is_zero() & !b.is_zero();
    let factors = Factors { multiplicand: a, multiplier: b, exponent, settled, sign };
    let Product { unrounded, low } = multiply(format, parts, factors);
    let (word, is_settled) = (unrounded.word, unrounded.settled);
    let rounded = unrounded.round();
    let m = parts.builder();
    m.output("product_o", rounded.number);
    if extra == Extra::Residue {
        m.section("What rounding takes");
        let s = format.significand();
        // The lower half of the digits of a product in [2, 4), and the place before them.
        let digits = m.concat(&[word.lower(3), low]).named("lower_digits");
        let zero = m.constant(1, 0);
        let (carried, short) = (word.top(), m.concat(&[digits.lower(s - 1), zero]));
        let lost = carried.mux(digits.lower(s), short).named("taken");
        let last = carried.mux(digits.bit(s), digits.bit(s - 1));
        let up = (lost.top() & (lost.lower(s - 1).any() | last)).named("rounded_up");
        let key = m.concat(&[!up, lost]) & (!is_settled).replicate(s + 1);
        let tiny = is_settled.mux(vanishes & nonzero, rounded.is_tiny());
        let below = RESIDUE_BITS - s - 2;
        let residue = m.concat(&[tiny, key]);
        m.output("residue_o", if below > 0 { m.concat(&[residue, m.constant(below, 0)]) } else { residue });
    }
    if extra == Extra::Flags {
        m.section("Exceptions");
        let absent = m.constant(1, 0);
        let [invalid, ordinary] = ["invalid", "ordinary"].map(|stem| parts.along(stem).unwrap_or(absent));
        let overflow = (ordinary & rounded.exponent.upper(2).all()).named("overflow");
        let inexact = (overflow | (ordinary & rounded.is_inexact())).named("inexact");
        let underflow = (inexact & rounded.is_tiny() & !overflow).named("underflow");
        flags::output(m, [Some(invalid), Some(overflow), Some(underflow), Some(inexact)]);
    }
}

fn booth_product<'m>(format: Format, parts: &mut Parts<'m>, factors: Factors<'m>) -> Product<'m> {
    let s = format.significand();
    let Factors { exponent, settled, sign, .. } = factors;
    let m = parts.builder();
    // The bits of the multiplier, hidden bit included.
    let n = factors.multiplier.fraction().width() + 1;
    m.section("Multiples");
    let multiplicand = m.concat(&[m.constant(1, 1), factors.multiplicand.fraction()]).named("multiplicand");
    let triple_above = booth::triple_above(multiplicand).named("triple_above");
    let (multiplicand, multiplier) = (multiplicand.lower(s - 1), factors.multiplier.fraction());
    cut!(parts, [(1, 3)], multiplicand, triple_above, multiplier, exponent, settled, sign);
    let m = parts.builder();
    let multiplicand = m.concat(&[m.constant(1, 1), multiplicand]).named("factor");
    let triple = m.concat(&[triple_above, multiplicand.bit(0)]);

    m.section("Multiply");
    let mut rows = booth::rows(multiplicand, triple, multiplier, s + n);
    // The multiplier's hidden bit.
    rows.push(Row { word: multiplicand, low: n - 1 });
    let rows = compress(rows, s + n);
    let [addend, augend] = [0, 1].map(|row| rows[row].columns(0, s + n));
    let (addend, augend) = (addend.named("addend"), augend.named("augend"));

    m.section("Add; the lower columns give a carry and a sticky bit");
    let low = lookahead::add(addend.lower(n - 2), augend.lower(n - 2), None, "low");
    let sticky = low.word.any().named("sticky");
    let (addend, augend, low_carry) = (addend.upper(s + 2), augend.upper(s + 2), low.carry);
    cut!(parts, [(1, 2), (2, 3)], addend, augend, low_carry, sticky, exponent, settled, sign);
    let m = parts.builder();
    let word = lookahead::add(addend, augend, Some(low_carry), "high");
    m.unused("unused_carry", &[word.carry]);
    let word = word.word.named("word");
    Product { unrounded: Unrounded { format, word, sticky, exponent, settled, sign, subnormal: None }, low: low.word }
}

fn inferred_product<'m>(format: Format, parts: &mut Parts<'m>, factors: Factors<'m>) -> Product<'m> {
    let (s, n) = (format.significand(), factors.multiplier.fraction().width() + 1);
    let Factors { exponent, settled, sign, .. } = factors;
    let (multiplicand, multiplier) = (factors.multiplicand.fraction(), factors.multiplier.fraction());
    cut!(parts, [(1, 3)], multiplicand, multiplier, exponent, settled, sign);
    let m = parts.builder();

    m.section("Multiply");
    let significand = |fraction| m.concat(&[m.constant(1, 1), fraction]);
    let factor = significand(multiplicand).named("factor");
    let whole = (factor * significand(multiplier).named("other_factor")).named("whole");
    // DSP blocks take longer than the exponent, which has time to mark the bits here.
    let subnormal = mark_lost(format, exponent, settled);
    cut!(parts, [(1, 2), (2, 3)], whole, exponent, settled, sign, subnormal);
    let word = whole.upper(s + 2).named("word");
    let low = whole.lower(n - 2);
    let sticky = low.any().named("sticky");
    let subnormal = Some(subnormal);
    Product { unrounded: Unrounded { format, word, sticky, exponent, settled, sign, subnormal }, low }
}
