//! Rounding of a recoded number to a shorter significand, in one direction.
//!
//! Hardware: rounding toward zero drops bits, rounding away from zero adds one if a dropped bit is set. A carry out of
//! the fraction steps the exponent, and from the largest number to infinity, because exponent and fraction are one
//! word. A margin below the last kept place changes what is added to 1 or 2, or subtracts 1. The module is not a unit
//! of its own in area reports, so that it is optimised with the logic around it.
//!
//! Checked by `verify unit-proofs` (all numbers, by words of IEEE 754 as integers).

use crate::units::constants::Constants;
use crate::units::recoded::Magnitude;
use crate::{Format, FormatError};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::fmt;
use std::sync::Arc;

/// A rounding to a shorter significand in one direction. Results below twice the least normal number are zeros of
/// their sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Narrow {
    /// The bits of the significand, hidden bit included.
    pub bits: u32,
    /// Whether magnitudes are rounded up; otherwise they are rounded down.
    pub away: bool,
    /// Units in the last place of the operand by which its magnitude is changed in that direction before, at most 4.
    pub margin: u32,
}

/// `s12_toward_zero`, with `_margin_4` if there is one.
impl fmt::Display for Narrow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "s{}_{}_zero", self.bits, if self.away { "away_from" } else { "toward" })?;
        if self.margin > 0 { write!(f, "_margin_{}", self.margin) } else { Ok(()) }
    }
}

impl Narrow {
    /// The direction in words.
    pub(crate) fn direction(self) -> &'static str {
        if self.away { "away from zero" } else { "toward zero" }
    }
}

impl Format {
    /// The format of the same exponent and a significand of `bits` bits.
    ///
    /// # Errors
    /// Less than 3 bits, or more than this format has.
    pub fn narrowed(self, bits: u32) -> Result<Self, FormatError> {
        if bits > self.significand() {
            let (exponent, most) = (self.exponent(), self.significand());
            return Err(FormatError::Significand { exponent, significand: bits, most });
        }
        Self::new(self.exponent(), bits)
    }
}

/// The format of a narrow number at a port of a module.
pub(crate) fn narrowed(format: Format, bits: u32, module: &str, signal: &str) -> Result<Format, Error> {
    let error = |problem: FormatError| Error::Width {
        module: module.to_string(),
        signal: signal.to_string(),
        problem: problem.to_string(),
    };
    format.narrowed(bits).map_err(error)
}

/// The module `raypath_narrow_<format>_<rounding>`: the recoded number `number_i` of `format`, rounded to `narrow_o`,
/// which has no lower bits of the fraction.
///
/// # Errors
/// A significand of less than 3 bits or of more than the format has.
pub fn narrow(format: Format, to: Narrow) -> Result<Arc<Module>, Error> {
    let name = format!("raypath_narrow_{format}_{to}");
    narrowed(format, to.bits, &name, "narrow_o")?;
    let (e, lost) = (format.exponent(), format.significand() - to.bits);
    let m = Builder::new(&name);
    m.doc(format!("A recoded number rounded {} to a significand of {} bits.", to.direction(), to.bits));
    let number_i = m.input("number_i", format.recoded_width());
    let number = Magnitude::of(format, number_i);

    m.section("Round");
    let changes = to.margin > 0 || (to.away && lost > 0);
    let ordinary = changes.then(|| (!number.exponent().upper(2).all()).named("ordinary"));
    let width = number.word.width();
    let (moved, margin) = match ordinary {
        // Of a margin within the lost bits, only a carry or borrow into the kept ones is computed.
        Some(ordinary) if to.margin > 0 && to.margin >> lost > 0 => {
            let margin = m.constant(width, to.margin.into()) & ordinary.replicate(width);
            let moved = if to.away { number.word + margin } else { number.word - margin };
            (moved.named("moved"), 0)
        }
        _ => (number.word, to.margin),
    };
    let kept = moved.upper(width - lost);
    let least_kept = m.parameter("LeastKept", e + 1, Constants(format).min_normal() + 1);
    let is_small = |word| Wire::upper(word, e + 1).less(least_kept);
    let (rounded, flushed) = match ordinary {
        Some(ordinary) if to.away && margin > 0 => {
            // One is added if a bit is lost or the margin alone is, and two if the lost bits exceed what is left.
            let two = m.constant(lost, (1 << lost) - u64::from(margin)).less(moved.lower(lost)).named("two");
            let carry = ((kept.bit(0) | two) & ordinary).named("carry");
            let upper = step(kept.upper(kept.width() - 1), carry, true).0;
            let rounded = m.concat(&[upper, kept.bit(0) ^ (ordinary & !two)]).named("rounded");
            (rounded, is_small(rounded))
        }
        Some(ordinary) if margin > 0 => {
            let borrow = moved.lower(lost).less(m.constant(lost, margin.into()));
            let rounded = step(kept, (borrow & ordinary).named("borrow"), false).0.named("rounded");
            (rounded, is_small(rounded))
        }
        Some(ordinary) if to.away && lost > 0 => {
            let up = (moved.lower(lost).any() & ordinary).named("up");
            let (rounded, reach) = step(kept, up, true);
            // Decided without waiting for the sum: of small numbers, only one below the least kept power of two is
            // rounded up to it.
            let below = kept.upper(e + 1).equals(m.parameter("MinNormal", e + 1, Constants(format).min_normal()));
            let reaches = (below & up & reach.bit(to.bits - 1)).named("reaches");
            (rounded.named("rounded"), is_small(kept) & !reaches)
        }
        _ => {
            if lost > 0 {
                m.unused("unused_lost", &[moved.lower(lost)]);
            }
            (kept, is_small(kept))
        }
    };

    m.section("Flush small results");
    // Zero less the margin is no small number.
    let flushed = if to.margin > 0 && !to.away { flushed | number.exponent().less(least_kept) } else { flushed };
    let magnitude = rounded & (!flushed.named("flushed")).replicate(width - lost);
    let magnitude = match ordinary {
        // The margin may carry a large number beyond the canonical infinity.
        Some(ordinary) if to.margin > 0 && to.away => {
            let overflows = (magnitude.upper(2).all() & ordinary).named("overflows");
            let fraction = magnitude.lower(to.bits - 1) & (!overflows).replicate(to.bits - 1);
            m.concat(&[magnitude.upper(e + 1), fraction])
        }
        _ => magnitude,
    };
    m.output("narrow_o", m.concat(&[number_i.top(), magnitude]));
    m.finish()
}

/// The word plus one, or minus one, if `condition` holds, and the bits that change then. They do not depend on the
/// condition, which is the last to arrive.
fn step<'m>(word: Wire<'m>, condition: Wire<'m>, is_up: bool) -> (Wire<'m>, Wire<'m>) {
    let one = word.builder().constant(word.width(), 1);
    let reach = (word ^ if is_up { word + one } else { word - one }).named("reach");
    (word ^ (reach & condition.replicate(word.width())), reach)
}
