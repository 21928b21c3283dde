//! Numbers of a format, and arithmetic that is exact before one rounding (`docs/reference/semantics.md`, "Numbers",
//! "Sums that round once", "Boxes in fewer bits" and "Exception flags"; `docs/reference/formats.md`).

use super::mistake::Mistake;
use raypath_float::Format;
use raypath_verify::dyadic::{Dyadic, Rounding};
use std::cell::Cell;
use std::cmp::Ordering;

/// A value of IEEE 754. A NaN has neither sign nor payload.
#[derive(Debug, Clone, PartialEq)]
pub enum Number {
    Nan,
    /// Zero, and whether it is −0.
    Zero(bool),
    /// A number other than zero.
    Finite(Dyadic),
    /// Infinity, and whether it is −∞.
    Infinite(bool),
}

impl Number {
    pub const ZERO: Self = Self::Zero(false);
    pub const INFINITY: Self = Self::Infinite(false);

    pub fn is_nan(&self) -> bool {
        matches!(self, Self::Nan)
    }

    /// Whether the sign is minus, also of −0.
    pub fn is_negative(&self) -> bool {
        match self {
            Self::Nan => false,
            Self::Zero(is_negative) | Self::Infinite(is_negative) => *is_negative,
            Self::Finite(value) => value.sign().is_lt(),
        }
    }

    pub fn negated(&self) -> Self {
        match self {
            Self::Nan => Self::Nan,
            Self::Zero(is_negative) => Self::Zero(!is_negative),
            Self::Finite(value) => Self::Finite(-value.clone()),
            Self::Infinite(is_negative) => Self::Infinite(!is_negative),
        }
    }

    /// The order of two numbers: −0 equals +0; `None` if one is NaN.
    pub fn order(&self, other: &Self) -> Option<Ordering> {
        let sign = |number: &Self| match number {
            Self::Nan => None,
            Self::Zero(_) => Some(0),
            Self::Finite(_) => Some(if number.is_negative() { -1 } else { 1 }),
            Self::Infinite(_) => Some(if number.is_negative() { -2 } else { 2 }),
        };
        match (self, other) {
            (Self::Finite(a), Self::Finite(b)) => Some(a.cmp(b)),
            _ => Some(sign(self)?.cmp(&sign(other)?)),
        }
    }

    pub fn order_to_zero(&self) -> Option<Ordering> {
        self.order(&Self::ZERO)
    }

    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Zero(_))
    }

    /// Whether it is greater than zero; false for NaN.
    pub fn is_above_zero(&self) -> bool {
        self.order_to_zero().is_some_and(Ordering::is_gt)
    }

    /// Whether it is zero or greater; false for NaN.
    pub fn is_at_least_zero(&self) -> bool {
        self.order_to_zero().is_some_and(Ordering::is_ge)
    }

    /// Whether it is less than zero; false for NaN.
    pub fn is_below_zero(&self) -> bool {
        self.order_to_zero().is_some_and(Ordering::is_lt)
    }
}

/// The exceptions, as bits of the port `exception_flags_o`.
const INEXACT: u64 = 1;
const UNDERFLOW: u64 = 2;
const OVERFLOW: u64 = 4;
const INVALID: u64 = 8;

/// The arithmetic of a format.
pub struct Arithmetic {
    format: Format,
    /// The exponents of the least normal and the greatest number.
    exponents: (i32, i32),
    /// The significand's bits, hidden bit included.
    significand: i32,
    /// The exceptions of the operations so far.
    pub raised: Cell<u64>,
    /// The deliberate mistake of a negative control.
    pub mistake: Option<Mistake>,
}

/// A rounding to fewer bits: which way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outward {
    TowardZero,
    AwayFromZero,
}

impl Arithmetic {
    pub fn new(format: Format) -> Self {
        let bias = (1 << (format.exponent() - 1)) - 1;
        let significand = format.significand() as i32;
        Self { format, exponents: (1 - bias, bias), significand, raised: Cell::new(0), mistake: None }
    }

    pub fn makes(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// The number with these bits in the layout of IEEE 754.
    pub fn number(&self, code: u64) -> Number {
        let fraction_bits = self.significand as u32 - 1;
        let (fraction, rest) = (code & ((1 << fraction_bits) - 1), code >> fraction_bits);
        let all_ones = (1 << self.format.exponent()) - 1;
        let (field, is_negative) = (rest & all_ones, rest >> self.format.exponent() & 1 == 1);
        let (least, _) = self.exponents;
        let (digits, exponent) = match field {
            0 if fraction == 0 => return Number::Zero(is_negative),
            0 => (fraction, least),
            _ if field == all_ones && fraction == 0 => return Number::Infinite(is_negative),
            _ if field == all_ones => return Number::Nan,
            _ => (fraction | 1 << fraction_bits, least + field as i32 - 1),
        };
        let magnitude = Dyadic::new(digits, exponent - fraction_bits as i32);
        Number::Finite(if is_negative { -magnitude } else { magnitude })
    }

    /// The bits of a number of the format. NaN is canonical.
    pub fn code(&self, number: &Number) -> u64 {
        let fraction_bits = self.significand as u32 - 1;
        let infinity = ((1 << self.format.exponent()) - 1) << fraction_bits;
        let magnitude = match number {
            Number::Nan => infinity | 1 << (fraction_bits - 1),
            Number::Zero(_) => 0,
            Number::Infinite(_) => infinity,
            Number::Finite(value) => {
                let place = self.last_place(value, self.significand);
                // The hidden bit adds one to the exponent field, which is 0 for subnormal numbers.
                let field = (place - self.last_place_of_subnormals()) as u64;
                (field << fraction_bits) + value.multiples_of(place)
            }
        };
        magnitude | u64::from(number.is_negative()) << (self.format.ieee_width() - 1)
    }

    /// The exponent of the last place of a number other than zero, with a significand of `bits` bits. Subnormal numbers
    /// have that of the least normal number.
    fn last_place(&self, value: &Dyadic, bits: i32) -> i32 {
        value.exponent().max(self.exponents.0) - bits + 1
    }

    fn last_place_of_subnormals(&self) -> i32 {
        self.exponents.0 - self.significand + 1
    }

    /// The nearest number of the format, ties to even.
    fn rounded(&self, exact: Dyadic) -> Number {
        let is_negative = exact.sign().is_lt();
        if exact.sign().is_eq() {
            return Number::ZERO;
        }
        let mut place = self.last_place(&exact, self.significand);
        if self.makes(Mistake::ShortSignificand) {
            place += 1;
        }
        let way = if self.makes(Mistake::TiesAway) { Rounding::NearestTiesAway } else { Rounding::NearestEven };
        let is_tiny = exact.exponent() < self.exponents.0;
        let rounded = exact.clone().rounded_to(place, way);
        if rounded != exact {
            self.raise(if is_tiny { INEXACT | UNDERFLOW } else { INEXACT });
        }
        match rounded.sign() {
            Ordering::Equal => Number::Zero(is_negative),
            _ if is_tiny && self.makes(Mistake::FlushedSubnormals) => Number::Zero(is_negative),
            _ if rounded.exponent() > self.exponents.1 => {
                self.raise(OVERFLOW | INEXACT);
                Number::Infinite(is_negative)
            }
            _ => Number::Finite(rounded),
        }
    }

    fn raise(&self, exceptions: u64) {
        let is_dropped = self.makes(Mistake::NoUnderflow) && exceptions & UNDERFLOW != 0;
        self.raised.set(self.raised.get() | if is_dropped { exceptions & !UNDERFLOW } else { exceptions });
    }

    fn invalid(&self) -> Number {
        self.raise(INVALID);
        Number::Nan
    }

    /// The sum, rounded.
    pub fn add(&self, a: &Number, b: &Number) -> Number {
        match (a, b) {
            (Number::Nan, _) | (_, Number::Nan) => Number::Nan,
            (Number::Infinite(x), Number::Infinite(y)) if x != y => self.invalid(),
            (Number::Infinite(_), _) => a.clone(),
            (_, Number::Infinite(_)) => b.clone(),
            (Number::Zero(x), Number::Zero(y)) => Number::Zero(*x && *y),
            (Number::Zero(_), _) => b.clone(),
            (_, Number::Zero(_)) => a.clone(),
            // A sum of zero is +0.
            (Number::Finite(x), Number::Finite(y)) => self.rounded(x + y),
        }
    }

    /// The difference, rounded.
    pub fn sub(&self, a: &Number, b: &Number) -> Number {
        self.add(a, &b.negated())
    }

    /// The product, rounded.
    pub fn mul(&self, a: &Number, b: &Number) -> Number {
        let is_negative = a.is_negative() != b.is_negative();
        match (a, b) {
            (Number::Nan, _) | (_, Number::Nan) => Number::Nan,
            (Number::Infinite(_), Number::Zero(_)) | (Number::Zero(_), Number::Infinite(_)) => self.invalid(),
            (Number::Infinite(_), _) | (_, Number::Infinite(_)) => Number::Infinite(is_negative),
            (Number::Zero(_), _) | (_, Number::Zero(_)) => Number::Zero(is_negative),
            (Number::Finite(x), Number::Finite(y)) => self.rounded(x * y),
        }
    }

    /// A small integer, converted without exceptions.
    pub fn integer(&self, value: u64) -> Number {
        let before = self.raised.get();
        let number = self.rounded(Dyadic::new(value, 0));
        self.raised.set(before);
        number
    }

    /// 1 + `ulps` units in the last place of 1.
    pub fn one_plus_ulps(&self, ulps: u64) -> Number {
        Number::Finite(&Dyadic::new(1, 0) + &Dyadic::new(ulps, 1 - self.significand))
    }

    /// The sum of the terms, truncated to a window and rounded once.
    pub fn sum(&self, terms: &[Number]) -> Number {
        match terms {
            [] => return Number::ZERO,
            [term] => return term.clone(),
            [a, b] => return self.add(a, b),
            _ => {}
        }
        let infinite = |is_negative: bool| terms.contains(&Number::Infinite(is_negative));
        if terms.contains(&Number::Nan) || infinite(false) && infinite(true) {
            return Number::Nan;
        }
        if infinite(false) || infinite(true) {
            return Number::Infinite(infinite(true));
        }
        let finite = |term: &Number| match term {
            Number::Finite(value) => Some(value.clone()),
            _ => None,
        };
        let values: Vec<Dyadic> = terms.iter().filter_map(finite).collect();
        let Some(greatest) = values.iter().map(Dyadic::exponent).max() else {
            return Number::Zero(terms.iter().all(Number::is_negative));
        };
        let log = terms.len().next_power_of_two().ilog2() as i32;
        let window = if self.makes(Mistake::ShortWindow) { self.significand } else { self.significand + log };
        let truncated = |value: Dyadic| value.rounded_to(greatest - window + 1, Rounding::TowardZero);
        let total = values.into_iter().map(truncated).fold(Dyadic::default(), |total, term| &total + &term);
        self.rounded(total)
    }

    /// The number rounded to `bits` bits, after its magnitude is moved by `margin` numbers of the format the same way.
    pub fn narrow(&self, number: &Number, bits: u32, way: Outward, margin: u64) -> Number {
        let Number::Finite(value) = number else { return number.clone() };
        let is_negative = value.sign().is_lt();
        let zero = Number::Zero(is_negative);
        // Neighbours have neighbouring codes.
        let code = self.code(&Number::Finite(value.abs()));
        let margin = if self.makes(Mistake::NoMargin) { 0 } else { margin };
        let moved = match way {
            Outward::TowardZero => code.saturating_sub(margin),
            Outward::AwayFromZero => code + margin,
        };
        let infinity = self.code(&Number::INFINITY);
        let Number::Finite(magnitude) = self.number(moved.min(infinity)) else {
            return if moved == 0 { zero } else { Number::Infinite(is_negative) };
        };
        let place = self.last_place(&magnitude, bits as i32);
        let rounding = if way == Outward::TowardZero { Rounding::TowardZero } else { Rounding::AwayFromZero };
        let rounded = magnitude.rounded_to(place, rounding);
        let (least, greatest) = self.exponents;
        if rounded.sign().is_eq() || rounded.exponent() <= least {
            return zero;
        }
        if rounded.exponent() > greatest {
            return Number::Infinite(is_negative);
        }
        Number::Finite(if is_negative { -rounded } else { rounded })
    }
}
