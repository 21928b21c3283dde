//! The digit recurrence of quotients and square roots, one binary digit at a time.
//!
//! Both find the digits of a result q from the highest on, each by one subtraction. A digit of weight m is 1 if the
//! remainder is not less than the subtrahend, which is then subtracted. The remainder is doubled for the next digit:
//!
//! | result | remainder before the digit of weight m | subtrahend |
//! | --- | --- | --- |
//! | q = 2x / d, in (1, 4) | (2x − q·d) / m | d |
//! | q = √x, in [1, 2) | (x − q²) / 2m | q + m/2 |
//!
//! with the q of the digits so far, x and d in [1, 2), and for roots x in [1, 4). The remainder stays in [0, 4) and the
//! subtrahend below 2, so their difference has the bits of the remainder, and its top bit is the sign. The digits weigh
//! 2, 1, and so on down to the half of a last place; the root's first one is 0. What is left of the remainder says
//! whether the result is exact.
//!
//! Source: M. D. Ercegovac and T. Lang, *Division and Square Root: Digit-Recurrence Algorithms and Implementations*,
//! Kluwer 1994: the restoring recurrences of radix 2.

use crate::Format;
use crate::units::constants::Constants;
use crate::units::recoded::Magnitude;
use raypath_hdl::{Builder, Formula, Wire};

/// What a unit computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DivSqrt {
    /// `a_i / b_i`.
    Quotient,
    /// `1 / b_i`: the quotient with a constant dividend.
    Reciprocal,
    /// The square root of `a_i`.
    Root,
    /// The square root of `a_i` if `is_root_i` is 1, else `a_i / b_i`.
    QuotientOrRoot,
}

impl DivSqrt {
    pub(crate) fn divides(self) -> bool {
        self != Self::Root
    }

    pub(crate) fn takes_roots(self) -> bool {
        matches!(self, Self::Root | Self::QuotientOrRoot)
    }

    /// The digits of a result before it is rounded: two before the point, and as many behind it as the significand has.
    pub(crate) fn digits(format: Format) -> u32 {
        format.significand() + 2
    }
}

/// What follows from the operands before the first digit.
pub(crate) struct Start<'m> {
    /// The first remainder, two bits before the point.
    pub remainder: Wire<'m>,
    /// The divisor's fraction, if the unit divides.
    pub divisor: Option<Wire<'m>>,
    /// Whether the result is a root, if the unit has both.
    pub is_root: Option<Wire<'m>>,
    /// Exponent or class, whether the class settles the result, and sign: as `Unrounded` has them.
    pub exponent: Wire<'m>,
    pub settled: Wire<'m>,
    pub sign: Wire<'m>,
}

/// The result as far as exponents, signs and classes determine it.
struct Outline<'m> {
    remainder: Wire<'m>,
    exponent: Wire<'m>,
    /// In the order of precedence.
    nan: Wire<'m>,
    infinite: Wire<'m>,
    zero: Wire<'m>,
    sign: Wire<'m>,
}

/// An operand in its parts.
struct Operand<'m> {
    sign: Wire<'m>,
    exponent: Wire<'m>,
    fraction: Wire<'m>,
    zero: Wire<'m>,
    infinite: Wire<'m>,
    nan: Wire<'m>,
}

impl<'m> Start<'m> {
    /// Reads the operands from the inputs that `function` has.
    pub fn of(function: DivSqrt, format: Format, m: &'m Builder) -> Self {
        let operand = |name| Operand::of(format, m.input(name, format.recoded_width()));
        let a = if function == DivSqrt::Reciprocal { Operand::one(format, m) } else { operand("a_i") };
        let b = function.divides().then(|| operand("b_i"));
        let is_root = (function == DivSqrt::QuotientOrRoot).then(|| m.input("is_root_i", 1));
        let divisor = b.as_ref().map(|b| b.fraction);
        let outline = match (b, is_root) {
            (Some(b), None) => Outline::quotient(format, &a, &b),
            (Some(b), Some(is_root)) => {
                let (root, quotient) = (Outline::root(format, &a), Outline::quotient(format, &a, &b));
                m.section("Quotient or root");
                root.or(is_root, quotient)
            }
            (None, _) => Outline::root(format, &a),
        };
        let special = (outline.nan | outline.infinite).named("special");
        let settled = (special | outline.zero).named("settled");
        let class = m.concat(&[special, special, outline.nan, m.constant(format.exponent() - 2, 0)]);
        let exponent = settled.mux(class, outline.exponent).named("exponent");
        let sign = (outline.sign & !outline.nan).named("sign");
        Self { remainder: outline.remainder, divisor, is_root, exponent, settled, sign }
    }
}

impl<'m> Outline<'m> {
    fn quotient(format: Format, a: &Operand<'m>, b: &Operand<'m>) -> Self {
        let (e, constants, m) = (format.exponent(), Constants(format), b.sign.builder());
        m.section("Quotient: exponent and class");
        let difference = (a.exponent.extend(e + 2) - b.exponent.extend(e + 2)).named("difference");
        // Above zero for all finite operands.
        let raised = m.concat(&[!difference.top(), difference.lower(e + 1)]).named("raised");
        // 2x / d has the difference of the exponents minus 1, and `raised` is 2^(e + 1) above that difference.
        let above = (Formula::from(1) << constants.exp_bits()) + 1;
        // With a smaller exponent, a word in [1, 4) is less than half the smallest subnormal.
        let least = constants.min_normal() + above.clone() - (constants.sig_bits() + 1);
        let vanishes = raised.less(m.parameter("MinRaisedExp", e + 2, least)).named("vanishes");
        let overflow = constants.max_finite() + 1 + above.clone();
        let overflows = (!raised.less(m.parameter("InfiniteRaisedExp", e + 2, overflow))).named("overflows");
        let exponent = (raised.lower(e + 1) - m.parameter("RaisedBias", e + 1, above)).named("quotient_exponent");
        Self {
            remainder: m.concat(&[m.constant(2, 1), a.fraction]),
            exponent,
            nan: (a.nan | b.nan | (a.zero & b.zero) | (a.infinite & b.infinite)).named("quotient_nan"),
            infinite: (a.infinite | b.zero | overflows).named("quotient_infinite"),
            zero: (a.zero | b.infinite | vanishes).named("quotient_zero"),
            sign: a.sign ^ b.sign,
        }
    }

    fn root(format: Format, a: &Operand<'m>) -> Self {
        let (e, constants, m) = (format.exponent(), Constants(format), a.sign.builder());
        m.section("Root: exponent, made even, and class");
        let is_odd = a.exponent.bit(0).named("is_odd");
        let half_bias = m.parameter("HalfBias", e + 1, Formula::from(1) << (constants.exp_bits() - 1));
        let [two_zeros, three_zeros] = [2, 3].map(|width| m.constant(width, 0));
        let significand = m.concat(&[m.constant(1, 1), a.fraction]);
        let odd = m.concat(&[two_zeros, significand, m.constant(1, 0)]);
        Self {
            // A quarter of the significand, or of its double.
            remainder: is_odd.mux(odd, m.concat(&[three_zeros, significand])).named("radicand"),
            exponent: (a.exponent.upper(e).extend(e + 1) + half_bias).named("root_exponent"),
            nan: (a.nan | (a.sign & !a.zero)).named("root_nan"),
            infinite: a.infinite,
            zero: a.zero,
            sign: a.sign & a.zero,
        }
    }

    /// `self` if `is_root` is set, else `quotient`, with the remainder's length of roots.
    fn or(self, is_root: Wire<'m>, quotient: Self) -> Self {
        let m = is_root.builder();
        let pick = |root, quotient, name: &str| is_root.mux(root, quotient).named(name);
        let remainder = m.concat(&[quotient.remainder, m.constant(2, 0)]);
        Self {
            remainder: pick(self.remainder, remainder, "remainder"),
            exponent: pick(self.exponent, quotient.exponent, "result_exponent_or_none"),
            nan: pick(self.nan, quotient.nan, "nan"),
            infinite: pick(self.infinite, quotient.infinite, "infinite"),
            zero: pick(self.zero, quotient.zero, "zero"),
            sign: pick(self.sign, quotient.sign, "sign_or_none"),
        }
    }
}

impl<'m> Operand<'m> {
    fn of(format: Format, number: Wire<'m>) -> Self {
        let magnitude = Magnitude::of(format, number);
        Self {
            sign: number.top(),
            exponent: magnitude.exponent(),
            fraction: magnitude.fraction(),
            zero: magnitude.is_zero(),
            infinite: magnitude.is_infinite(),
            nan: magnitude.is_nan(),
        }
    }

    fn one(format: Format, m: &'m Builder) -> Self {
        let no = m.constant(1, 0);
        Self {
            sign: no,
            exponent: m.parameter("One", format.exponent() + 1, Formula::from(1) << Constants(format).exp_bits()),
            fraction: m.constant(format.fraction_width(), 0),
            zero: no,
            infinite: no,
            nan: no,
        }
    }
}

/// The subtrahend of a digit, as long as `remainder`. `trial` is that of a root: the digits so far, a 0 at the place of
/// this digit, and a 1 behind it.
pub(crate) fn subtrahend<'m>(
    remainder: Wire<'m>,
    divisor: Option<Wire<'m>>,
    is_root: Option<Wire<'m>>,
    trial: impl FnOnce() -> Wire<'m>,
) -> Wire<'m> {
    let m = remainder.builder();
    let Some(divisor) = divisor else { return trial() };
    let mut divisor = m.concat(&[m.constant(2, 1), divisor]);
    if remainder.width() > divisor.width() {
        divisor = m.concat(&[divisor, m.constant(remainder.width() - divisor.width(), 0)]);
    }
    is_root.map_or(divisor, |is_root| is_root.mux(trial(), divisor))
}

/// One step: the digit, and the remainder for the next one. `name` ends the names of its signals.
pub(crate) fn step<'m>(remainder: Wire<'m>, subtrahend: Wire<'m>, name: u32) -> (Wire<'m>, Wire<'m>) {
    let m = remainder.builder();
    let difference = (remainder - subtrahend).named(&format!("difference_{name}"));
    let digit = (!difference.top()).named(&format!("digit_{name}"));
    let rest = remainder.width() - 1;
    let kept = digit.mux(difference.lower(rest), remainder.lower(rest));
    (digit, m.concat(&[kept, m.constant(1, 0)]).named(&format!("remainder_{name}")))
}
