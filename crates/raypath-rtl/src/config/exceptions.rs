//! Values of parameters that cannot be combined: every combination without one of these pairs can be elaborated.

use super::declarations::{Config, parameters};
use super::enumerations::{Control, Interval, Multiplier};
use crate::error::Error;
use raypath_float::Format;
use raypath_ops::{BoxBits, EdgeRule, Rounding, Rules};
use std::fmt;

/// Values of two parameters that cannot be combined.
#[derive(Debug, Clone, Copy)]
pub struct Exception {
    /// The values that are refused.
    pub values: Choice,
    /// The values of another parameter with which they are.
    pub with: Choice,
    /// What to select instead of one of the two.
    pub expected: &'static str,
    /// Why they cannot be combined.
    pub reason: &'static str,
}

/// Some values of a parameter.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// The parameter.
    pub parameter: &'static str,
    /// Its values in words: `above 1`.
    pub values: &'static str,
    /// Whether the parameter has one of these values.
    holds: fn(&Config) -> bool,
}

const FOLDED: Choice = choice("interval", "above 1", |c| c.microarchitecture.interval != Interval::One);
const DIVIDED: Choice = choice("unit-latency", "above 1", |c| c.microarchitecture.unit_latency.is_divided());
const DIVIDED_AND_FOLDED: Choice =
    choice("unit-latency", "above 1 with interval above 1", |c| (DIVIDED.holds)(c) && (FOLDED.holds)(c));
const GATED: Choice = choice("clock-gating", "true", |c| c.microarchitecture.clock_gating);
const DELAYED: Choice = choice("delay-lines", "above 0", |c| c.microarchitecture.delay_lines > 0);
const SKID: Choice = choice("control", "skid", |c| c.microarchitecture.control == Control::Skid);
const DSP: Choice = choice("multiplier", "dsp", |c| c.microarchitecture.multiplier == Multiplier::Dsp);
const FEW_STEPS: Choice =
    choice("unit-latency", "below 3 for multipliers", |c| c.microarchitecture.unit_latency.products < 3);
const FLAGS: Choice = choice("exception-flags", "true", |c| c.semantics.features.exception_flags);
const SUMS: Choice = choice("rounding", "sum", |c| c.semantics.rounding == Rounding::Sum);
const CHISEL: Choice = choice("rules", "chisel", |c| c.semantics.rules == Rules::Chisel);
const BOUNDS: Choice = choice("rules", "bounds", |c| matches!(c.semantics.rules, Rules::Bounds(_)));
const NOT_BOUNDS: Choice = choice("rules", "paper or chisel", |c| !matches!(c.semantics.rules, Rules::Bounds(_)));
const CONSERVATIVE: Choice = choice("conservative", "true", |c| c.semantics.features.conservative);
const ONCE: Choice = choice("edges", "once", |c| c.semantics.features.edges == EdgeRule::Once);
const QUANTISED: Choice = choice("quantised-boxes", "true", |c| c.semantics.features.quantised_boxes);
const NOT_BINARY32: Choice = choice("format", "other than fp32", |c| c.semantics.format != Format::BINARY32);
const BOX_BITS: Choice = choice("box-bits", "other than 13", |c| c.semantics.box_bits != BoxBits::DEFAULT);
const LONG_BOXES: Choice = choice("box-bits", "above the bits of a significand", |c| {
    (BOUNDS.holds)(c) && c.semantics.box_bits.0 > c.semantics.format.significand()
});
const SHORT: Choice = choice("format", "with fewer bits and the rules bounds", |_| true);

/// All pairs of values that cannot be combined. The first that a configuration has is the one that it is refused for.
pub const EXCEPTIONS: &[Exception] = &[
    exception(BOX_BITS, NOT_BOUNDS, "rules bounds", "only the rules bounds shorten the significands of boxes"),
    exception(LONG_BOXES, SHORT, "fewer box-bits or a longer format", "a bound has no more bits than the format"),
    exception(
        QUANTISED,
        CONSERVATIVE,
        "conservative false",
        "it changes the test of boxes of numbers, and there is none",
    ),
    exception(ONCE, CHISEL, "rules paper or bounds", "the edges of the original hardware belong to all triangles"),
    exception(ONCE, FLAGS, "edges shared", "no multiplier has outputs for both"),
    exception(ONCE, FOLDED, "interval 1", "the rounds of a stage have no multiplier with another output"),
    exception(ONCE, DIVIDED, "unit-latency 1", "a divided multiplier has no such output"),
    exception(QUANTISED, CHISEL, "rules paper", "the original hardware has no such boxes"),
    exception(QUANTISED, BOUNDS, "rules paper", "they shorten boxes of numbers, and there are none"),
    exception(FLAGS, NOT_BINARY32, "format fp32", "only in binary32 a model computes exceptions"),
    exception(SUMS, CHISEL, "rules paper or bounds", "the original hardware rounds at every adder"),
    exception(SUMS, FOLDED, "interval 1", "the rounds of a stage have no adder of several terms"),
    exception(SUMS, DIVIDED, "unit-latency 1", "adders of several terms are not divided"),
    exception(SUMS, FLAGS, "rounding unit", "adders of several terms signal no exceptions"),
    exception(DELAYED, SKID, "control credit", "a memory cannot wait for one job among others"),
    exception(DELAYED, GATED, "clock-gating false", "a memory has no clock gates"),
    exception(DELAYED, FOLDED, "interval 1", "the rounds of a stage have no delay lines"),
    exception(DIVIDED_AND_FOLDED, SKID, "control credit", "a job inside a unit cannot wait for another one"),
    exception(DSP, SKID, "control credit", "the registers of a DSP block cannot wait for one job among others"),
    exception(DSP, GATED, "clock-gating false", "a DSP block has no clock gates"),
    exception(DSP, FEW_STEPS, "unit-latency 3 or more", "a step before and one behind the DSP block are needed"),
    exception(FOLDED, FLAGS, "interval 1", "exceptions join all units of a stage, not those of a round"),
    exception(FOLDED, GATED, "interval 1", "registers already load in the rounds in which a value comes into them"),
    exception(FOLDED, BOUNDS, "interval 1", "the rounds of a stage have no units for short significands"),
];

const fn choice(parameter: &'static str, values: &'static str, holds: fn(&Config) -> bool) -> Choice {
    Choice { parameter, values, holds }
}

const fn exception(values: Choice, with: Choice, expected: &'static str, reason: &'static str) -> Exception {
    Exception { values, with, expected, reason }
}

impl Exception {
    /// Refuses a configuration that has both.
    pub(super) fn check(&self, config: &Config) -> Result<(), Error> {
        let Self { values, with, expected, reason } = self;
        if !((values.holds)(config) && (with.holds)(config)) {
            return Ok(());
        }
        let shown = |name: &str| {
            let value = parameters().find(|parameter| parameter.name == name).map(|parameter| parameter.get(config));
            value.unwrap_or_default()
        };
        let (value, other) = (shown(values.parameter), shown(with.parameter));
        let problem =
            format!("{value} is not available with {} {other}, because {reason}; expected {expected}", with.parameter);
        Err(Error::Feature { feature: values.parameter, problem })
    }
}

/// The parameter and its values: `interval above 1`.
impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.parameter, self.values)
    }
}
