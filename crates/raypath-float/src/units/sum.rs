//! Sum of three or more recoded numbers, rounded once.
//!
//! The terms are shifted right to the greatest exponent among them and truncated to a window of [`Format::sum_window`]
//! bits. What remains is added exactly, and the sum is rounded to nearest even. `docs/reference/semantics.md` defines
//! the result. It does not depend on the order of the terms.
//!
//! Hardware: a tree finds the greatest exponent, a tree of full adders reduces the shifted terms to two words, and one
//! adder adds those. All signs are relative to that of the first term, so the terms to be complemented are one fewer
//! than all, and each has a place for its carry: the free lowest place of a full adder's carries, or the carry into
//! the adder. A sum below the normal range is exact and needs no special case.
//!
//! Tests: `raypath-verify-arithmetic/tests/units/sums.rs` (an oracle in integers of its own), whole and in parts.

use crate::Format;
use crate::units::constants::Constants;
use crate::units::lookahead;
use crate::units::normalise::Normalised;
use crate::units::recoded::Magnitude;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module `raypath_fp_sum_<terms>_<format>`: `sum_o` is the sum of `x_0_i` to `x_<terms - 1>_i`, rounded once.
///
/// # Errors
/// Fewer than 3 terms or more than 64.
pub fn sum(format: Format, terms: u32) -> Result<Arc<Module>, Error> {
    let name = format!("raypath_fp_sum_{terms}_{format}");
    if !(3..=64).contains(&terms) {
        let problem = format!("has {terms} terms, expected 3 to 64");
        return Err(Error::Name { module: name, name: "sum_o".to_string(), problem });
    }
    let m = Builder::new(&name);
    m.doc(format!("Sum of {terms} recoded numbers, rounded once to nearest even."));
    describe(format, terms, &m);
    m.finish()
}

fn describe(format: Format, terms: u32, m: &Builder) {
    let (e, s, window) = (format.exponent(), format.significand(), format.sum_window(terms));
    let growth = terms.next_power_of_two().ilog2();
    let numbers: Vec<Wire<'_>> = (0..terms).map(|term| m.input(&format!("x_{term}_i"), e + s + 1)).collect();
    let each: Vec<Magnitude<'_>> = numbers.iter().map(|&number| Magnitude::of(format, number)).collect();
    let signs = all(m, numbers.iter().map(|number| number.top())).named("signs");
    let zeros = all(m, each.iter().map(|x| x.is_zero())).named("zeros");

    m.section("Zeros, infinities and NaN");
    let infinities = all(m, each.iter().map(|x| x.is_infinite())).named("infinities");
    let infinite = infinities.any().named("infinite");
    let minus = (infinities & signs).any().named("minus_infinity");
    let both = (infinities & !signs).any() & minus;
    let nan = (all(m, each.iter().map(|x| x.is_nan())).any() | both).named("nan");
    let special = (infinite | nan).named("special");
    let minus_zero = (zeros.all() & signs.all()).named("minus_zero");

    m.section("The greatest exponent");
    // The exponent field of a zero is below all others.
    let exponents: Vec<Wire<'_>> = each.iter().map(|x| x.exponent()).collect();
    let mut greatest = exponents.clone();
    while greatest.len() > 1 {
        let left = greatest.len().div_ceil(2);
        greatest = greatest
            .chunks(2)
            .enumerate()
            .map(|(number, pair)| match *pair {
                [a, b] => a.less(b).mux(b, a).named(&format!("greatest_{left}_{number}")),
                _ => pair[0],
            })
            .collect();
    }
    let exponent = greatest[0];

    m.section("Shift to the greatest exponent and truncate; complement where the sign differs from the first");
    let relative = (signs.upper(terms - 1) ^ signs.bit(0).replicate(terms - 1)).named("relative");
    let width = window + growth + 1;
    let mut complements: Vec<Wire<'_>> = (0..terms - 1).map(|other| relative.bit(other)).collect();
    let rows: Vec<Wire<'_>> = (0..terms)
        .map(|term| {
            let distance = (exponent - exponents[term as usize]).named(&format!("distance_{term}"));
            let present = !zeros.bit(term);
            let word = m.concat(&[present, each[term as usize].fraction(), m.constant(window - s, 0)]);
            let shifted = truncating_shift(word, distance, present);
            let row = if term == 0 {
                shifted.extend(width)
            } else {
                let sign = relative.bit(term - 1);
                m.concat(&[sign.replicate(growth + 1), shifted ^ sign.replicate(window)])
            };
            row.named(&format!("row_{term}"))
        })
        .collect();

    m.section("Add");
    let sign = signs.bit(0);
    let rows = reduce(rows, &mut complements);
    let total = lookahead::add(rows[0], rows[1], complements.pop(), "total");
    m.unused("unused_total_carry", &[total.carry]);
    let total = total.word.named("total");
    let negative = total.top().named("negative");
    let magnitude = total.lower(width - 1) ^ negative.replicate(width - 1);
    let magnitude = (magnitude + negative.extend(width - 1)).named("magnitude");

    m.section("Normalise");
    let normalised = Normalised::of(magnitude);
    let leading_zeros = normalised.leading_zeros();
    let cancelled = (!normalised.word.upper(2).any()).named("cancelled");
    let ordinary = (!special & !cancelled).named("ordinary");
    let digits = normalised.fraction(width - 2, ordinary).named("digits");
    let extended = (exponent.extend(e + 2) + m.constant(e + 2, growth.into())).named("extended");
    let before = (extended - leading_zeros.extend(e + 2)).named("exponent_before");

    m.section("Round");
    let kept = digits.upper(s - 1);
    let guard = digits.bit(width - 2 - s);
    let below = digits.lower(width - 2 - s).any().named("below_guard");
    let up = (guard & (below | kept.bit(0))).named("round_up");
    let rounded = (kept.extend(s) + up.extend(s)).named("rounded");
    let after = (before + rounded.top().extend(e + 2)).named("exponent_after");
    let beyond = m.parameter("BeyondExp", e + 2, Constants(format).max_finite() + 1);
    let overflow = (!after.less(beyond) & ordinary).named("overflow");

    m.section("Result");
    let infinite = (special | overflow).named("result_infinite");
    let number = (ordinary & !overflow).named("number");
    let class = m.concat(&[infinite, infinite, nan, m.constant(e - 2, 0)]);
    let result_exponent = ((after.lower(e + 1) & number.replicate(e + 1)) | class).named("result_exponent");
    m.unused("unused_exponent", &[after.top()]);
    let fraction = (rounded.lower(s - 1) & number.replicate(s - 1)) | m.concat(&[nan, m.constant(s - 2, 0)]);
    let ordinary_sign = cancelled.mux(minus_zero, sign ^ negative);
    let result_sign = special.mux(minus & !nan, ordinary_sign).named("result_sign");
    m.output("sum_o", m.concat(&[result_sign, result_exponent, fraction.named("result_fraction")]));
}

/// One bit of each term as a word, the first term lowest.
fn all<'m>(m: &'m Builder, bits: impl DoubleEndedIterator<Item = Wire<'m>>) -> Wire<'m> {
    m.concat(&bits.rev().collect::<Vec<_>>())
}

/// `word` shifted right by any `amount`, without the bits that are shifted out; zeros unless `present`.
fn truncating_shift<'m>(word: Wire<'m>, amount: Wire<'m>, present: Wire<'m>) -> Wire<'m> {
    let (m, width) = (word.builder(), word.width());
    let layers = width.next_power_of_two().ilog2().min(amount.width());
    let layer = |word: Wire<'m>, layer: u32| {
        let shifted = word.shift_right(m.constant(7, 1 << layer));
        amount.bit(layer).mux(shifted, word)
    };
    let shifted = (0..layers).fold(word, layer);
    let beyond = (amount.width() > layers).then(|| amount.bits(amount.width() - 1, layers).any());
    shifted & beyond.map_or(present, |beyond| present & !beyond).replicate(width)
}

/// Reduces rows of one width by levels of full adders to two. A carry is taken from `complements` into the free lowest
/// place of each row of carries.
fn reduce<'m>(mut rows: Vec<Wire<'m>>, complements: &mut Vec<Wire<'m>>) -> Vec<Wire<'m>> {
    while rows.len() > 2 {
        let count = rows.len();
        let mut reduced = Vec::new();
        for (number, chunk) in rows.chunks(3).enumerate() {
            match *chunk {
                [x, y, z] => reduced.extend(full_adders([x, y, z], complements.pop(), &format!("{count}_{number}"))),
                _ => reduced.extend_from_slice(chunk),
            }
        }
        rows = reduced;
    }
    rows
}

/// A full adder for each place of three rows: the rows of sums and of carries, whose lowest place is free for `lowest`.
fn full_adders<'m>([x, y, z]: [Wire<'m>; 3], lowest: Option<Wire<'m>>, number: &str) -> [Wire<'m>; 2] {
    let (m, width) = (x.builder(), x.width());
    let differ = (x ^ z).named(&format!("differ_{number}"));
    let carry = (differ & y) | (!differ & x);
    let lowest = lowest.unwrap_or_else(|| m.constant(1, 0));
    m.unused(&format!("unused_carry_{number}"), &[carry.top()]);
    let carries = m.concat(&[carry.lower(width - 1), lowest]);
    [(differ ^ y).named(&format!("sum_{number}")), carries.named(&format!("carries_{number}"))]
}
