//! Units of one operand with a definition: the rounding to a shorter significand, and the number of a word.

use super::script::{Script, Term};
use raypath_float::Format;
use raypath_ops::{Direction, Narrowing};

/// A unit of one operand. Its modules are proved equal to its definition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Conversion {
    /// `Circuit::narrow`.
    Narrow(Narrowing),
    /// `Circuit::number_of`, of a word of this width.
    Number(u32),
}

impl Conversion {
    /// The name of its module in a format.
    pub fn module(self, format: Format) -> String {
        let layout = format!("e{}s{}", format.exponent(), format.significand());
        match self {
            Self::Number(width) => format!("raypath_fp_number_{layout}_w{width}"),
            Self::Narrow(Narrowing { bits, direction, margin }) => {
                let direction = direction_name(direction);
                let margin = if margin == 0 { String::new() } else { format!("_margin_{margin}") };
                format!("raypath_narrow_{layout}_s{bits}_{direction}{margin}")
            }
        }
    }

    /// The names of its ports without their directions.
    pub fn ports(self) -> (&'static str, &'static str) {
        match self {
            Self::Number(_) => ("word", "recoded"),
            Self::Narrow(_) => ("number", "narrow"),
        }
    }

    /// The recoded number that it makes of an operand, by definition. A short one has zeros below.
    pub fn definition(self, script: &mut Script, format: Format, operand: Term) -> Term {
        match self {
            Self::Number(width) => number_of(script, format, width, operand),
            Self::Narrow(to) => narrowed(script, format, operand, to),
        }
    }
}

/// The direction in the names of modules.
pub(super) fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::TowardZero => "toward_zero",
        Direction::AwayFromZero => "away_from_zero",
    }
}

fn number_of(script: &mut Script, format: Format, width: u32, word: Term) -> Term {
    let fraction = format.fraction_width();
    let mut number = script.constant(format.recoded_width(), 0);
    // The highest bit that is set decides: its selection is the outermost.
    for bit in 0..width {
        let exponent = script.constant(format.recoded_width() - fraction, (1 << format.exponent()) + u64::from(bit));
        let mut value = exponent;
        if bit > 0 {
            let below = script.slice(word, bit - 1, 0);
            value = script.operator(value.width + bit, "concat", &[value, below]);
        }
        if fraction > bit {
            let zeros = script.constant(fraction - bit, 0);
            value = script.operator(format.recoded_width(), "concat", &[value, zeros]);
        }
        let is_set = script.slice(word, bit, bit);
        number = script.select(is_set, value, number);
    }
    number
}

fn narrowed(script: &mut Script, format: Format, number: Term, to: Narrowing) -> Term {
    let (width, exponent, fraction) = (number.width, format.exponent(), format.fraction_width());
    let class = script.slice(number, width - 2, width - 4);
    let sign = script.slice(number, width - 1, width - 1);
    // One bit more than a magnitude, for sums.
    let magnitude = script.slice(number, width - 2, 0);
    let magnitude = script.operator(width, "(_ zero_extend 1)", &[magnitude]);
    let mut constant = |value: u64| script.constant(width, value);
    let low = (1_u64 << (format.significand() - to.bits)) - 1;
    let [zero, margin, low, kept] = [0, to.margin.into(), low, ((1 << width) - 1) & !low].map(&mut constant);
    // Twice the least normal number, and infinity, which follows the greatest number.
    let least = constant(((1_u64 << exponent) + 3 - (1 << (exponent - 1))) << fraction);
    let infinity = constant(((1_u64 << exponent) + (1 << (exponent - 1))) << fraction);
    let moved = match to.direction {
        Direction::TowardZero => format!("(ite (bvult {magnitude} {margin}) {zero} (bvsub {magnitude} {margin}))"),
        Direction::AwayFromZero => format!("(bvadd (bvadd {magnitude} {margin}) {low})"),
    };
    let rounded = script.define(width, format!("(bvand {moved} {kept})"));
    let kept = format!("(ite (bvuge {rounded} {infinity}) {infinity} {rounded})");
    let kept = script.define(width, format!("(ite (or (= {class} #b000) (bvult {rounded} {least})) {zero} {kept})"));
    let kept = script.slice(kept, width - 2, 0);
    let finite = script.operator(width, "concat", &[sign, kept]);
    script.define(width, format!("(ite (bvult {class} #b110) {finite} {number})"))
}
