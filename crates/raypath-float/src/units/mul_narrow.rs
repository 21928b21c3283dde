//! Product of two recoded numbers with short significands, rounded to nearest in their format and then in one
//! direction to a short significand.
//!
//! Hardware: as `mul.rs` up to the word of the product. The two roundings are one: the first changes the result of the
//! second only if it carries into the kept bits. Rounding away from zero adds one if the first rounds up or leaves a
//! bit below the kept ones. Rounding toward zero adds one if the first rounds up and all bits between are set. Results
//! below the normal range are zero, so no place but the last is rounded.
//!
//! Checked by `verify unit-proofs` (symfpu, all operands of small formats).

use crate::Format;
use crate::units::booth;
use crate::units::compress::compress;
use crate::units::constants::Constants;
use crate::units::lookahead;
use crate::units::narrow::{Narrow, narrowed};
use crate::units::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Formula, Module};
use std::sync::Arc;

/// The module `raypath_fp_mul_<format>_s<operand>_<rounding>`: the product of two numbers of `format` that have
/// significands of `operand` bits, rounded to nearest even in `format`, and then as `to` says, without its margin. The
/// words of operands and product have no lower bits of the fractions, which are zeros.
///
/// # Errors
/// A significand of less than 3 bits or of more than the format has, or of the product that
/// is longer than that of an operand.
pub fn mul_narrow(format: Format, operand: u32, to: Narrow) -> Result<Arc<Module>, Error> {
    let name = format!("raypath_fp_mul_{format}_s{operand}_{to}");
    let operand = narrowed(format, operand, &name, "a_i")?;
    narrowed(operand, to.bits, &name, "product_o")?;
    let m = Builder::new(&name);
    m.doc(format!("Product of two recoded numbers of {operand}, rounded {}.", to.direction()));
    describe(format, operand, to, &m);
    m.finish()
}

fn describe(format: Format, operand: Format, to: Narrow, m: &Builder) {
    let (e, s, n, kept_bits) = (format.exponent(), format.significand(), operand.significand(), to.bits);
    let a_i = m.input("a_i", operand.recoded_width());
    let b_i = m.input("b_i", operand.recoded_width());
    let (a, b) = (Magnitude::of(operand, a_i), Magnitude::of(operand, b_i));

    m.section("Exponent and class");
    let bias = Formula::from(1) << Constants(format).exp_bits();
    let sum = a.exponent().extend(e + 2) + b.exponent().extend(e + 2);
    let exponent = (sum - m.parameter("Bias", e + 2, bias)).named("exponent");
    let nan = a.is_nan() | b.is_nan() | (a.is_zero() & b.is_infinite()) | (a.is_infinite() & b.is_zero());
    let nan = nan.named("nan");
    let special = (nan | a.is_infinite() | b.is_infinite()).named("special");
    let zero = (a.is_zero() | b.is_zero()).named("zero");
    let sign = ((a_i.top() ^ b_i.top()) & !nan).named("sign");

    m.section("Multiples");
    let multiplicand = m.concat(&[m.constant(1, 1), a.fraction()]).named("multiplicand");
    let triple_above = booth::triple_above(multiplicand, false).named("triple_above");
    let triple = m.concat(&[triple_above, multiplicand.bit(0)]);

    m.section("Multiply");
    // With the hidden bit, a multiplier of 13 or 14 bits needs a row less than without.
    let multiplier = m.concat(&[m.constant(1, 1), b.fraction()]);
    let rows = compress(booth::rows(multiplicand, triple, multiplier, 2 * n), 2 * n);
    let [addend, augend] = [0, 1].map(|row| rows[row].columns(0, 2 * n));
    let (addend, augend) = (addend.named("addend"), augend.named("augend"));
    let word = lookahead::add(addend, augend, None, "product");
    m.unused("unused_carry", &[word.carry]);
    let word = word.word.named("word");

    m.section("Normalise by one place");
    let carried = word.top().named("carried");
    let shifted = m.concat(&[word.lower(2 * n - 1), m.constant(1, 0)]);
    let digits = carried.mux(word, shifted).named("digits");
    let kept = digits.upper(kept_bits);
    // Bits between the kept ones and the last place of the format, and those below it.
    let below = (2 * n).saturating_sub(s);
    let between = if 2 * n - below > kept_bits { Some(digits.bits(2 * n - kept_bits - 1, below)) } else { None };

    m.section("Round");
    let nearest_up = (below > 0).then(|| {
        let (half, even) = (digits.bit(below - 1), digits.bit(below));
        let more = if below > 1 { digits.lower(below - 1).any() | even } else { even };
        (half & more).named("nearest_up")
    });
    let up = match (nearest_up, between) {
        (Some(nearest_up), Some(between)) if to.away => Some(nearest_up | between.any()),
        (Some(nearest_up), Some(between)) => Some(nearest_up & between.all()),
        (None, Some(between)) if to.away => Some(between.any()),
        (nearest_up, _) => nearest_up,
    };
    m.unused("unused_hidden", &[digits.top()]);
    if up.is_none() && 2 * n > kept_bits {
        m.unused("unused_lost", &[digits.lower(2 * n - kept_bits)]);
    }
    let up = up.map_or(m.constant(1, 0), |up| up.named("up"));
    let width = e + 1 + kept_bits;
    let unrounded = m.concat(&[exponent, kept.lower(kept_bits - 1)]);
    let steps = m.concat(&[m.constant(e + 1, 0), carried, m.constant(kept_bits - 2, 0), up]);
    let rounded = (unrounded + steps.extend(width)).named("rounded");

    m.section("Result");
    // Before rounding, which may carry the largest exponent into the sign.
    let negative = exponent.top();
    let exponent = rounded.upper(e + 2);
    let least_kept = m.parameter("LeastKept", e + 2, Constants(format).min_normal() + 1);
    let infinite = m.parameter("Infinite", e + 2, Constants(format).max_finite() + 1);
    let vanishes = (zero | negative | exponent.less(least_kept)).named("vanishes");
    let special = (special | (!vanishes & !exponent.less(infinite))).named("special_product");
    let ordinary = (!special & !vanishes).named("ordinary");
    let class = m.concat(&[special, special, nan, m.constant(e - 2, 0)]);
    let exponent = (exponent.lower(e + 1) & ordinary.replicate(e + 1)) | class;
    let quiet = m.concat(&[nan, m.constant(kept_bits - 2, 0)]);
    let fraction = (rounded.lower(kept_bits - 1) & ordinary.replicate(kept_bits - 1)) | quiet;
    m.output("product_o", m.concat(&[sign, exponent, fraction]));
}
