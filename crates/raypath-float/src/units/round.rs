//! Rounding of a product, quotient or root to nearest even, in the normal range and below.
//!
//! Hardware: a mask marks the bits that the result loses. Below the normal range, the exponent alone sets its bits,
//! before the digits are ready. The bits below half of the last place are set, so that adding one rounds up, and the
//! mask clears the lost bits; on a tie, the last place is cleared too. Then the result is normalised by one place. The
//! mask clears every bit of a settled result.

use crate::Format;
use crate::units::constants::Constants;
use crate::units::lookahead;
use raypath_hdl::Wire;

/// A result before it is rounded.
pub(crate) struct Unrounded<'m> {
    pub format: Format,
    /// The digits of a number in [1, 4): two bits before the point, and as many behind it as the significand has.
    pub word: Wire<'m>,
    /// Whether a digit behind `word` is set.
    pub sticky: Wire<'m>,
    /// The recoded exponent that belongs to a `word` of 1: from the least normal one minus the significand's bits minus
    /// 1, to that of the largest numbers. The class in the top three bits of a settled result, above zeros.
    pub exponent: Wire<'m>,
    /// Whether the result is zero, infinite or NaN whatever the digits are.
    pub settled: Wire<'m>,
    /// The sign; 0 for NaN.
    pub sign: Wire<'m>,
    /// What [`mark_lost`] has marked, if it has been called already.
    pub subnormal: Option<Wire<'m>>,
}

/// Marks the bits that a result loses because it is below the normal range, or because it is settled. `exponent` and
/// `settled` are those of [`Unrounded`].
pub(crate) fn mark_lost<'m>(format: Format, exponent: Wire<'m>, settled: Wire<'m>) -> Wire<'m> {
    let (e, s, constants) = (format.exponent(), format.significand(), Constants(format));
    let m = exponent.builder();
    m.section("Mark the bits to lose: one or two, and more below the normal range");
    let least = m.parameter("MinExp", e + 1, constants.min_normal() - (constants.sig_bits() + 1));
    // A result that is settled loses every bit.
    let above_least = ((exponent - least).hint("from_least") & (!settled).replicate(e + 1)).named("above_least");
    let all = m.parameter("AllBits", s + 1, (1 << (s + 1)) - 1);
    all.shift_right(above_least).named("subnormal")
}

/// A rounded result.
pub(crate) struct Rounded<'m> {
    /// The recoded number.
    pub number: Wire<'m>,
    /// Its exponent.
    pub exponent: Wire<'m>,
    word: Wire<'m>,
    sticky: Wire<'m>,
    lost: Wire<'m>,
    subnormal: Wire<'m>,
    carried: Wire<'m>,
}

impl<'m> Unrounded<'m> {
    pub fn round(self) -> Rounded<'m> {
        let Self { format, word, sticky, exponent, settled, sign, subnormal } = self;
        let (e, s, constants) = (format.exponent(), format.significand(), Constants(format));
        let m = word.builder();

        let subnormal = subnormal.unwrap_or_else(|| mark_lost(format, exponent, settled));
        let zero = m.constant(1, 0);
        let carried = word.top().named("carried");
        let lost_half = (subnormal.bit(0) | carried).hint("lost_half");
        let lost = m.concat(&[settled, subnormal.upper(s), lost_half, m.constant(1, 1)]).named("lost");
        let below_half = m.concat(&[zero, lost.upper(s + 2)]).named("below_half");

        m.section("Round");
        let word = word.extend(s + 3).named("unrounded");
        let exact = (!((word & below_half).hint("lost_digits").any() | sticky)).named("exact");
        let filled = (word | below_half).named("filled");
        let rounded = lookahead::increment(filled, "filled").named("rounded");
        let half = m.concat(&[word.lower(s + 2) & lost.lower(s + 2), zero]);
        let tie = exact.replicate(s + 3) & half;
        let kept = (rounded & !lost & !tie).named("kept");
        m.unused("unused_half", &[kept.bit(0)]);

        m.section("Normalise");
        let any = settled | kept.upper(3).any();
        let result_exponent =
            ((exponent + kept.upper(2).extend(e + 1)) & any.replicate(e + 1)).named("result_exponent");
        let largest = exponent.equals(m.parameter("MaxExp", e + 1, constants.max_finite())).named("largest");
        let fraction = carried.mux(kept.bits(s, 2), kept.bits(s - 1, 1)).named("fraction");
        let fraction = fraction & (!(largest & carried)).replicate(s - 1);
        let quiet = m.concat(&[exponent.upper(3).all(), m.constant(s - 2, 0)]);
        let number = m.concat(&[sign, result_exponent, fraction | quiet]);
        Rounded { number, exponent: result_exponent, word, sticky, lost, subnormal, carried }
    }
}

impl<'m> Rounded<'m> {
    /// Whether a digit is lost; unspecified for settled results.
    pub fn is_inexact(&self) -> Wire<'m> {
        (self.word & self.lost).any() | self.sticky
    }

    /// Whether the digits are below the normal range before they are rounded: by one place, which a word of 2 or more
    /// makes up for, or further.
    pub fn is_tiny(&self) -> Wire<'m> {
        (self.subnormal.bit(0) & (!self.carried | self.subnormal.bit(1))).named("tiny")
    }
}
