//! Quotients, reciprocals and square roots of recoded numbers, as one module or in parts.
//!
//! Hardware: a subtractor and a multiplexer for each digit (`recurrence.rs`), in a chain, and then the rounding that
//! products have too (`round.rs`). `iterative.rs` has one or a few of the subtractors, used again in every cycle.
//!
//! Tests: `tests/division` (the format in software: all operands of small formats, hard ones of others, handshakes),
//! `verify testfloat` (SoftFloat), `verify unit-proofs` (symfpu in small formats, split and iterative units),
//! `tests/units/division.rs` in `raypath-verify-arithmetic` (Verilator).

use crate::Format;
use crate::units::iterative;
use crate::units::parts::{Parts, cut};
use crate::units::pipeline;
use crate::units::recurrence::{DivSqrt, Start, step, subtrahend};
use crate::units::round::Unrounded;
use raypath_hdl::{Error, Module, Wire};
use std::sync::Arc;

/// The module `raypath_fp_div_<format>`, combinational: `result_o = a_i / b_i`.
pub fn div(format: Format) -> Result<Arc<Module>, Error> {
    Ok(DivSqrt::Quotient.parts(format, 1)?.remove(0))
}

/// The module `raypath_fp_sqrt_<format>`, combinational: `result_o` is the square root of `a_i`.
pub fn sqrt(format: Format) -> Result<Arc<Module>, Error> {
    Ok(DivSqrt::Root.parts(format, 1)?.remove(0))
}

/// The units. Their inputs are those of the variant; results are rounded to nearest even, with subnormal numbers and
/// canonical words, like those of all units. A finite number divided by zero is infinite; 0 / 0, infinity / infinity
/// and roots of negative numbers are NaN; the root of -0 is -0.
impl DivSqrt {
    /// The unit in parts, all combinational, in the order of computation, connected as those of
    /// [`divide`](raypath_hdl::divide()). The last part rounds, and the others share the digits, of which there are two
    /// more than the significand has. The output is `result_o`.
    ///
    /// # Errors
    /// No part, or more than the significand's bits plus 3.
    pub fn parts(self, format: Format, count: u32) -> Result<Vec<Arc<Module>>, Error> {
        let (name, doc) =
            (format!("raypath_fp_{}_{format}", self.stem()), format!("{}, rounded to nearest even.", self.doc()));
        Parts::build(&name, &doc, count, |parts| describe(self, format, parts))
    }

    /// The unit with registers after each of `latency` parts: it takes operands in every cycle, and has their result
    /// `latency` cycles later. The module is `raypath_<div|rcp|sqrt|div_sqrt>_pipelined_<format>_l<latency>`, without
    /// the `fp_` of combinational units.
    ///
    /// Ports besides the operands, outputs in this order: `valid_i`, `ready_i`, `ready_o`, `valid_o`, `result_o`. If
    /// `tag_width` is not 0, `tag_i` of as many bits comes out with the result as `tag_o`, the last output. While a
    /// result waits for `ready_i`, nothing moves: `ready_o` is `ready_i` unless there is no result.
    ///
    /// # Errors
    /// A latency of 0, or more than the significand's bits plus 3; a tag of more than 64 bits.
    pub fn pipelined(self, format: Format, latency: u32, tag_width: u32) -> Result<Arc<Module>, Error> {
        let name = format!("raypath_{}_pipelined_{format}_l{latency}", self.stem());
        let doc = format!("{}, pipelined.", self.doc());
        pipeline::pipeline(&name, &doc, &self.parts(format, latency)?, tag_width)
    }

    /// The text of the pipelined quotient with a tag, by the name of its module: a loop in place of modules for the parts
    /// between the first and the last. None if there are none.
    ///
    /// # Errors
    /// A latency that the quotient does not have.
    pub fn looped_quotient(format: Format, latency: u32) -> Result<Option<(String, String)>, Error> {
        let name = format!("raypath_{}_pipelined_{format}_l{latency}", Self::Quotient.stem());
        pipeline::looped(&name, &Self::Quotient.parts(format, latency)?)
    }

    /// The unit that computes one result at a time, `digits` digits a cycle. The module is
    /// `raypath_<div|rcp|sqrt|div_sqrt>_iterative_<format>_d<digits>`, with the ports of
    /// [`pipelined`](Self::pipelined). The result is there [`iterative_latency`](Self::iterative_latency) cycles after
    /// the operands, for all operands, and stays until `ready_i` is 1; in that cycle the unit takes the next operands.
    ///
    /// # Errors
    /// No digit, or more than a result has: the significand's bits plus 2; a tag of more than 64 bits.
    pub fn iterative(self, format: Format, digits: u32, tag_width: u32) -> Result<Arc<Module>, Error> {
        // So that units with different tags have different names.
        let tag = if tag_width == 0 { String::new() } else { format!("_t{tag_width}") };
        let name = format!("raypath_{}_iterative_{format}_d{digits}{tag}", self.stem());
        let doc = format!("{}, {digits} digits a cycle.", self.doc());
        iterative::iterative(self, format, digits, tag_width, &name, &doc)
    }

    /// Cycles from the operands to the result of an iterative unit, and from one result to the next if none waits.
    pub fn iterative_latency(format: Format, digits: u32) -> u32 {
        Self::digits(format).div_ceil(digits.max(1)) + 1
    }

    fn stem(self) -> &'static str {
        match self {
            Self::Quotient => "div",
            Self::Reciprocal => "rcp",
            Self::Root => "sqrt",
            Self::QuotientOrRoot => "div_sqrt",
        }
    }

    fn doc(self) -> &'static str {
        match self {
            Self::Quotient => "Quotient of two recoded numbers",
            Self::Reciprocal => "Reciprocal of a recoded number",
            Self::Root => "Square root of a recoded number",
            Self::QuotientOrRoot => "Quotient of two recoded numbers, or square root of the first",
        }
    }
}

fn describe(function: DivSqrt, format: Format, parts: &mut Parts<'_>) {
    let total = DivSqrt::digits(format);
    let start = Start::of(function, format, parts.builder());
    let along = [("exponent", start.exponent), ("settled", start.settled), ("sign", start.sign)];
    along.into_iter().for_each(|(stem, wire)| parts.take_along(stem, wire));
    let for_digits = [("divisor", start.divisor), ("is_root", start.is_root)];
    for_digits.into_iter().for_each(|(stem, wire)| wire.into_iter().for_each(|wire| parts.take_along(stem, wire)));

    parts.builder().section("Digits");
    let (mut digits, mut remainder) = next_digit(parts, None, start.remainder, 0, total);
    for place in 1..total {
        (digits, remainder) = {
            cut!(parts, ends(parts.count(), place, total), digits, remainder);
            next_digit(parts, Some(digits), remainder, place, total)
        };
    }
    for_digits.iter().for_each(|(stem, _)| parts.leave_behind(stem));
    cut!(parts, ends(parts.count(), total, total), digits, remainder);
    let zero = parts.builder().constant(1, 0);
    let [exponent, settled, sign] = along.map(|(stem, _)| parts.along(stem).unwrap_or(zero));
    let sticky = remainder.any().named("sticky");
    let rounded = Unrounded { format, word: digits, sticky, exponent, settled, sign, subnormal: None }.round();
    parts.builder().output("result_o", rounded.number);
}

/// The digits with the one at `place`, of 0 to `total` - 1, and the remainder after it.
fn next_digit<'m>(
    parts: &Parts<'m>,
    digits: Option<Wire<'m>>,
    remainder: Wire<'m>,
    place: u32,
    total: u32,
) -> (Wire<'m>, Wire<'m>) {
    let m = parts.builder();
    let trial = || {
        // The first digit's trial is a 1 behind it, and the last digit's has no place behind that.
        let behind = total - 1 - place;
        let tail = m.constant(behind + 2, 1 << behind);
        digits.map_or(tail, |digits| m.concat(&[digits, tail]))
    };
    let subtrahend = subtrahend(remainder, parts.along("divisor"), parts.along("is_root"), trial);
    let (digit, remainder) = step(remainder, subtrahend, place);
    let digits = digits.map_or(digit, |digits| m.concat(&[digits, digit]));
    (digits.named(&format!("digits_{place}")), remainder)
}

/// The cut, if there is one, before the digit at `place`: of `count` parts, the last one rounds and the others have
/// equally many of `total` digits, the first ones fewer by one.
fn ends(count: usize, place: u32, total: u32) -> Vec<(usize, usize)> {
    let with_digits = count - 1;
    let is_end = |&part: &usize| part * total as usize / with_digits == place as usize;
    (1..count).filter(is_end).map(|part| (part, count)).collect()
}
