//! Product of two recoded numbers.
//!
//! Hardware: an adder for the exponents. For the significands, one multiple of the multiplicand for every three bits of
//! the multiplier (`booth.rs`), full adders that reduce them to two rows (`compress.rs`), and a carry-lookahead adder
//! (`lookahead.rs`); or the operator `*`, for which synthesis takes the multipliers of an FPGA; or products for these
//! multipliers (`partial.rs`). Then the product is rounded (`round.rs`). If operands or exponents alone determine the
//! result, its class replaces the exponent.
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
use crate::units::partial;
use crate::units::recoded::Magnitude;
use crate::units::round::{Unrounded, mark_lost};
use raypath_hdl::{Builder, Error, Formula, Module, Wire};
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

/// How the text of a multiplier forms the product of significands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Product {
    /// Booth digits, rows and full adders: gates.
    Booth,
    /// The operator `*`, for which synthesis for an FPGA takes multipliers. The modules are named `mul_inferred`.
    Inferred,
    /// Products of 18 by 18 bits, each for one multiplier of an FPGA ([`multiplier`](crate::multiplier())), and their
    /// sum. The modules are named `mul_dsp`.
    Dsp,
}

impl Product {
    fn stem(self) -> &'static str {
        match self {
            Self::Booth => "mul",
            Self::Inferred => "mul_inferred",
            Self::Dsp => "mul_dsp",
        }
    }

    /// Multiplies the significands.
    fn of<'m>(self, format: Format, m: &'m Builder, factors: Factors<'m>, is_divided: bool) -> Digits<'m> {
        match self {
            Self::Booth => booth_product(format, m, factors, is_divided),
            Self::Inferred => operator_product(format, m, factors, |a, b| a * b),
            Self::Dsp => operator_product(format, m, factors, partial::product),
        }
    }
}

/// A product before it is rounded.
struct Digits<'m> {
    unrounded: Unrounded<'m>,
    /// The digits behind its word.
    low: Wire<'m>,
}

/// An output besides the product.
#[derive(Clone, Copy, PartialEq)]
enum Extra {
    None,
    Flags,
    Residue,
}

/// The module `raypath_fp_mul_<format>`: `product_o = a_i * b_i`. With `with_flags` it has the output `flags_o`, like
/// [`add`](crate::add()).
pub fn mul(format: Format, product: Product, with_flags: bool) -> Result<Arc<Module>, Error> {
    unit(format, product, with_flags, false)
}

/// The multiplier of [`mul`], to be [divided](raypath_hdl::divide()). In gates, the carries of the adder for three
/// times the multiplicand do not ripple, so that a cut can be inside.
pub fn mul_to_divide(format: Format, product: Product, with_flags: bool) -> Result<Arc<Module>, Error> {
    unit(format, product, with_flags, true)
}

fn unit(format: Format, product: Product, with_flags: bool, is_divided: bool) -> Result<Arc<Module>, Error> {
    let m = flags::unit(product.stem(), "Product of two recoded numbers", format, with_flags);
    let extra = if with_flags { Extra::Flags } else { Extra::None };
    describe(format, format, &m, extra, product, is_divided);
    m.finish()
}

/// The module `raypath_fp_mul_<format>_by_s<bits>`: the product of a number of `format` and one with a significand of
/// `bits` bits, whose word has no lower bits of the fraction, which are zeros.
///
/// # Errors
/// A significand of less than 3 bits or of more than the format has.
pub fn mul_by_short(format: Format, bits: u32, product: Product) -> Result<Arc<Module>, Error> {
    let name = format!("raypath_fp_{}_{format}_by_s{bits}", product.stem());
    let factor = narrowed(format, bits, &name, "b_i")?;
    let m = Builder::new(&name);
    m.doc(format!("Product of a recoded number and one of {factor}, rounded to nearest even."));
    describe(format, factor, &m, Extra::None, product, false);
    m.finish()
}

/// The module `raypath_fp_mul_residue_<format>`: the multiplier of [`mul`] with the output `residue_o`. Its 26 bits,
/// from the highest on: the product is not 0 and below the normal range; it is rounded down; the digits that rounding
/// takes, then zeros. Of products that are equal after rounding, the one of the greater magnitude has the greater
/// residue. Zeros have the residue 0.
pub fn mul_with_residue(format: Format, product: Product) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("raypath_fp_{}_residue_{format}", product.stem()));
    m.doc("Product of two recoded numbers, rounded to nearest even, and what rounding takes.");
    describe(format, format, &m, Extra::Residue, product, false);
    m.finish()
}

fn describe(format: Format, factor: Format, m: &Builder, extra: Extra, product: Product, is_divided: bool) {
    let e = format.exponent();
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
    let infinite = [(a, "a_infinite"), (b, "b_infinite")].map(|(x, name)| x.is_infinite().hint(name));
    let zero = [(a, "a_zero"), (b, "b_zero")].map(|(x, name)| x.is_zero().hint(name));
    let zero_times_infinity = ((zero[0] & infinite[1]) | (infinite[0] & zero[1])).hint("zero_times_infinity");
    let any_nan = (a.is_nan() | b.is_nan()).hint("any_nan");
    let nan = (any_nan | zero_times_infinity).named("nan");
    let special = (nan | infinite[0] | infinite[1] | overflows).named("special");
    let settled = (special | zero[0] | zero[1] | vanishes).named("settled");
    let class = m.concat(&[special, special, nan, m.constant(e - 2, 0)]);
    let biased = (exponent_sum.lower(e + 1) - m.parameter("Bias", e + 1, bias)).hint("biased");
    let exponent = settled.mux(class, biased).named("exponent");
    let sign = ((a_i.top() ^ b_i.top()).hint("signs_differ") & !nan).named("sign");

    let invalid = (extra == Extra::Flags).then(|| {
        let special = a.exponent().upper(2).all() | b.exponent().upper(2).all();
        let invalid = zero_times_infinity.named("invalid");
        (invalid, (!special & !a.is_zero() & !b.is_zero()).named("ordinary"))
    });

    let nonzero = !special & !a.is_zero() & !b.is_zero();
    let factors = Factors { multiplicand: a, multiplier: b, exponent, settled, sign };
    let Digits { unrounded, low } = product.of(format, m, factors, is_divided);
    let (word, is_settled) = (unrounded.word, unrounded.settled);
    let rounded = unrounded.round();
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
    if let Some((invalid, ordinary)) = invalid {
        m.section("Exceptions");
        let overflow = (ordinary & rounded.exponent.upper(2).all()).named("overflow");
        let inexact = (overflow | (ordinary & rounded.is_inexact())).named("inexact");
        let underflow = (inexact & rounded.is_tiny() & !overflow).named("underflow");
        flags::output(m, [Some(invalid), Some(overflow), Some(underflow), Some(inexact)]);
    }
}

fn booth_product<'m>(format: Format, m: &'m Builder, factors: Factors<'m>, has_lookahead: bool) -> Digits<'m> {
    let s = format.significand();
    let Factors { exponent, settled, sign, .. } = factors;
    // The bits of the multiplier, hidden bit included.
    let n = factors.multiplier.fraction().width() + 1;
    m.section("Multiples");
    let multiplicand = m.concat(&[m.constant(1, 1), factors.multiplicand.fraction()]).named("multiplicand");
    let triple_above = booth::triple_above(multiplicand, has_lookahead).named("triple_above");
    let triple = m.concat(&[triple_above, multiplicand.bit(0)]);

    m.section("Multiply");
    let mut rows = booth::rows(multiplicand, triple, factors.multiplier.fraction(), s + n);
    // The multiplier's hidden bit.
    rows.push(Row { word: multiplicand, low: n - 1 });
    let rows = compress(rows, s + n);
    let [addend, augend] = [0, 1].map(|row| rows[row].columns(0, s + n));
    let (addend, augend) = (addend.named("addend"), augend.named("augend"));

    m.section("Add; the lower columns give a carry and a sticky bit");
    let low = lookahead::add(addend.lower(n - 2), augend.lower(n - 2), None, "low");
    let sticky = low.word.any().named("sticky");
    let word = lookahead::add(addend.upper(s + 2), augend.upper(s + 2), Some(low.carry), "high");
    m.unused("unused_carry", &[word.carry]);
    let word = word.word.named("word");
    Digits { unrounded: Unrounded { format, word, sticky, exponent, settled, sign, subnormal: None }, low: low.word }
}

fn operator_product<'m>(
    format: Format,
    m: &'m Builder,
    factors: Factors<'m>,
    multiply: impl Fn(Wire<'m>, Wire<'m>) -> Wire<'m>,
) -> Digits<'m> {
    let (s, n) = (format.significand(), factors.multiplier.fraction().width() + 1);
    let Factors { exponent, settled, sign, .. } = factors;

    m.section("Multiply");
    let significand = |fraction| m.concat(&[m.constant(1, 1), fraction]);
    let factor = significand(factors.multiplicand.fraction()).named("factor");
    let other = significand(factors.multiplier.fraction()).named("other_factor");
    let whole = multiply(factor, other).named("whole");
    // Multipliers take longer than the exponent, which has time to mark the bits here.
    let subnormal = Some(mark_lost(format, exponent, settled));
    let word = whole.upper(s + 2).named("word");
    let low = whole.lower(n - 2);
    let sticky = low.any().named("sticky");
    Digits { unrounded: Unrounded { format, word, sticky, exponent, settled, sign, subnormal }, low }
}
