//! Arithmetic on codes: exact in integers, then one rounding.
//!
//! Every operation decodes its operands to [`Value`]s, computes with those exactly, and encodes the result with
//! [`Format::code`], the only function that rounds. The hardware's units use other algorithms; tests compare their
//! results with these.
//!
//! Tests: `tests/host.rs` (the host's `f32`), `tests/exhaustive.rs` (all operands, by search among all numbers),
//! `tests/apfloat.rs` (LLVM's soft float).

use crate::format::{Format, mask};
use std::cmp::Ordering;

/// The value of a code.
#[derive(Clone, Copy)]
enum Value {
    Nan,
    Infinite { negative: bool },
    Finite(Finite),
}

/// The number `significand * 2^exponent`, negated if `negative`; zeros have a sign too.
#[derive(Clone, Copy)]
struct Finite {
    negative: bool,
    significand: u64,
    exponent: i32,
}

/// IEEE 754 arithmetic on codes, rounded to nearest, ties to even, with subnormals. An operand that is NaN may have any
/// sign and payload; a result that is NaN is always [`Format::nan`].
impl Format {
    /// The sum. An exact zero is +0, except that -0 + -0 is -0.
    #[inline]
    pub fn add(self, a: u64, b: u64) -> u64 {
        self.code(self.value(a).plus(self.value(b)))
    }

    /// The difference `a - b`: the sum of `a` and `b` with its sign inverted.
    #[inline]
    pub fn sub(self, a: u64, b: u64) -> u64 {
        self.add(a, b ^ self.sign_bit())
    }

    /// The product.
    #[inline]
    pub fn mul(self, a: u64, b: u64) -> u64 {
        self.code(self.value(a).times(self.value(b)))
    }

    /// The quotient `a / b`. A finite number divided by zero is infinite; 0 / 0 and infinity / infinity are NaN.
    #[inline]
    pub fn div(self, a: u64, b: u64) -> u64 {
        self.code(self.value(a).divided_by(self.value(b)))
    }

    /// The square root. That of -0 is -0; that of any other negative number is NaN.
    #[inline]
    pub fn sqrt(self, a: u64) -> u64 {
        self.code(self.value(a).root())
    }

    /// The number with its sign inverted.
    #[inline]
    pub fn neg(self, a: u64) -> u64 {
        self.canonical(a ^ self.sign_bit())
    }

    /// The number rounded toward zero to a significand of `bits` bits, after its magnitude is reduced by `margin` units
    /// in the last place. Results below twice the least normal number are zeros of its sign; infinities and NaN stay.
    #[inline]
    pub fn narrow_toward_zero(self, a: u64, bits: u32, margin: u32) -> u64 {
        self.narrow(a, |magnitude| magnitude.saturating_sub(margin.into()) & !mask(self.significand() - bits))
    }

    /// The number rounded away from zero to a significand of `bits` bits, after its magnitude is increased by `margin`
    /// units in the last place. Results below twice the least normal number are zeros of its sign; infinities and NaN
    /// stay.
    #[inline]
    pub fn narrow_away_from_zero(self, a: u64, bits: u32, margin: u32) -> u64 {
        let low = mask(self.significand() - bits);
        self.narrow(a, |magnitude| ((magnitude + u64::from(margin) + low) & !low).min(self.infinity()))
    }

    /// Rounds the magnitude of a finite number, as a code.
    #[inline]
    fn narrow(self, a: u64, round: impl Fn(u64) -> u64) -> u64 {
        // Codes of magnitudes are in the order of the magnitudes, and a step of one is a unit in the last place.
        let magnitude = self.magnitude(a) as u64;
        if magnitude >= self.infinity() {
            return self.canonical(a);
        }
        let rounded = round(magnitude);
        let least_kept = 2 << self.fraction_width();
        (if rounded < least_kept { 0 } else { rounded }) | a & self.sign_bit()
    }

    /// The order of `a` and `b`: -0 equals +0; `None` if one of them is NaN.
    #[inline]
    pub fn compare(self, a: u64, b: u64) -> Option<Ordering> {
        // Codes of magnitudes are in the order of the magnitudes.
        let rank = |code: u64| if self.is_sign_negative(code) { -self.magnitude(code) } else { self.magnitude(code) };
        let unordered = self.is_nan(a) || self.is_nan(b);
        (!unordered).then(|| rank(a).cmp(&rank(b)))
    }

    /// Whether it is a NaN.
    #[inline]
    pub fn is_nan(self, a: u64) -> bool {
        self.magnitude(a) > self.infinity() as i64
    }

    /// Whether it is +0 or -0.
    #[inline]
    pub fn is_zero(self, a: u64) -> bool {
        self.magnitude(a) == 0
    }

    /// Its sign bit; a NaN may have it.
    #[inline]
    pub fn is_sign_negative(self, a: u64) -> bool {
        a & self.sign_bit() != 0
    }

    /// The same number; a NaN becomes [`Format::nan`].
    #[inline]
    pub fn canonical(self, a: u64) -> u64 {
        if self.is_nan(a) { self.nan() } else { a & mask(self.ieee_width()) }
    }

    /// The code nearest to a number, ties to even.
    #[inline]
    pub fn from_f64(self, number: f64) -> u64 {
        self.code(Self::BINARY64.value(number.to_bits()))
    }

    /// The code nearest to a number, ties to even.
    #[inline]
    pub fn from_f32(self, number: f32) -> u64 {
        self.code(Self::BINARY32.value(number.to_bits().into()))
    }

    /// The number of this many units in the last place of 1: a power of two, at most 1.
    pub fn ulps(self, ulps: u32) -> u64 {
        self.from_f32(ulps as f32 * 2.0_f32.powi(1 - self.significand() as i32))
    }

    /// The number, exact: binary64 has all numbers of all formats.
    #[inline]
    pub fn to_f64(self, a: u64) -> f64 {
        f64::from_bits(Self::BINARY64.code(self.value(a)))
    }

    /// The unit in the last place: the distance between the format's numbers near `number`, as if the format had no
    /// largest number. At a power of two it is the distance to the next larger number. `number` must be finite.
    #[inline]
    pub fn ulp(self, number: f64) -> f64 {
        let biased = (number.to_bits() >> Self::BINARY64.fraction_width() & mask(Self::BINARY64.exponent())) as i32;
        let last_place = (biased - 1023 - self.fraction_width() as i32).max(self.least_exponent());
        f64::from_bits(Self::BINARY64.round(1, last_place))
    }

    /// The value of a code.
    #[inline]
    fn value(self, code: u64) -> Value {
        let (sign, exponent, fraction) = self.split(code, self.exponent());
        let negative = sign == 1;
        let finite = |significand, steps: u64| {
            Value::Finite(Finite { negative, significand, exponent: self.least_exponent() + steps as i32 })
        };
        match (exponent, fraction) {
            (0, _) => finite(fraction, 0),
            (all_ones, 0) if all_ones == mask(self.exponent()) => Value::Infinite { negative },
            (all_ones, _) if all_ones == mask(self.exponent()) => Value::Nan,
            _ => finite(fraction | 1 << self.fraction_width(), exponent - 1),
        }
    }

    /// The code nearest to a value.
    #[inline]
    fn code(self, value: Value) -> u64 {
        let (negative, magnitude) = match value {
            Value::Nan => return self.nan(),
            Value::Infinite { negative } => (negative, self.infinity()),
            Value::Finite(number) if number.significand == 0 => (number.negative, 0),
            Value::Finite(number) => (number.negative, self.round(number.significand, number.exponent)),
        };
        if negative { magnitude | self.sign_bit() } else { magnitude }
    }

    /// The magnitude code nearest to `factor * 2^exponent`, ties to even; infinity from half a last place above the
    /// largest number on. `factor` is not zero and has at most 62 bits.
    #[inline]
    fn round(self, factor: u64, exponent: i32) -> u64 {
        let leading_one = exponent + 63 - factor.leading_zeros() as i32;
        let last_place = (leading_one - self.fraction_width() as i32).max(self.least_exponent());
        let significand = match last_place - exponent {
            missing @ ..=0 => factor << -missing,
            lost => {
                let lost = lost.min(63);
                let (kept, rest, half) = (factor >> lost, factor & mask(lost as u32), 1 << (lost - 1));
                kept + u64::from(rest > half || rest == half && kept % 2 == 1)
            }
        };
        // A hidden bit, or a carry out of the significand, steps the exponent field by one; the largest number's carry
        // steps it to infinity.
        let steps = (last_place - self.least_exponent()) as u64;
        ((steps << self.fraction_width()) + significand).min(self.infinity())
    }

    /// The exponent of the last place of subnormal numbers.
    #[inline]
    fn least_exponent(self) -> i32 {
        3 - (1 << (self.exponent() - 1)) - self.significand() as i32
    }

    /// A code without its sign.
    #[inline]
    fn magnitude(self, code: u64) -> i64 {
        (code & mask(self.ieee_width() - 1)) as i64
    }
}

impl Value {
    /// The sum, or a number that rounds like it.
    #[inline]
    fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Nan, _) | (_, Self::Nan) => Self::Nan,
            (Self::Infinite { negative: a }, Self::Infinite { negative: b }) if a != b => Self::Nan,
            (infinite @ Self::Infinite { .. }, _) | (_, infinite @ Self::Infinite { .. }) => infinite,
            (Self::Finite(a), Self::Finite(b)) => Self::Finite(a.plus(b)),
        }
    }

    /// The product.
    #[inline]
    fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Nan, _) | (_, Self::Nan) => Self::Nan,
            (Self::Infinite { .. }, Self::Finite(x)) | (Self::Finite(x), Self::Infinite { .. })
                if x.significand == 0 =>
            {
                Self::Nan
            }
            (Self::Finite(a), Self::Finite(b)) => Self::Finite(a.times(b)),
            _ => Self::Infinite { negative: self.is_negative() != other.is_negative() },
        }
    }

    /// The quotient, or a number that rounds like it.
    #[inline]
    fn divided_by(self, other: Self) -> Self {
        let negative = self.is_negative() != other.is_negative();
        let zero = Self::Finite(Finite { negative, significand: 0, exponent: 0 });
        match (self, other) {
            (Self::Nan, _) | (_, Self::Nan) | (Self::Infinite { .. }, Self::Infinite { .. }) => Self::Nan,
            (Self::Infinite { .. }, Self::Finite(_)) => Self::Infinite { negative },
            (Self::Finite(_), Self::Infinite { .. }) => zero,
            (Self::Finite(a), Self::Finite(b)) => match (a.significand, b.significand) {
                (0, 0) => Self::Nan,
                (0, _) => zero,
                (_, 0) => Self::Infinite { negative },
                _ => Self::Finite(a.divided_by(b)),
            },
        }
    }

    /// The square root, or a number that rounds like it.
    #[inline]
    fn root(self) -> Self {
        match self {
            Self::Infinite { negative: false } => self,
            Self::Finite(number) if number.significand == 0 => self,
            Self::Finite(number) if !number.negative => Self::Finite(number.root()),
            _ => Self::Nan,
        }
    }

    #[inline]
    fn is_negative(self) -> bool {
        match self {
            Self::Nan => false,
            Self::Infinite { negative } | Self::Finite(Finite { negative, .. }) => negative,
        }
    }
}

impl Finite {
    /// The sum, or a number that rounds like it. Significands have at most 24 bits.
    #[inline]
    fn plus(self, other: Self) -> Self {
        let (high, low) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let distance = high.exponent - low.exponent;
        if distance > 25 {
            // `low` is less than a quarter of the last place of `high`. `high` is normal, so the sum rounds to it.
            return high;
        }
        let total = (high.signed() << distance) + low.signed();
        let negative = total < 0 || total == 0 && self.negative && other.negative;
        Self { negative, significand: total.unsigned_abs(), exponent: low.exponent }
    }

    /// The product.
    #[inline]
    fn times(self, other: Self) -> Self {
        Self {
            negative: self.negative != other.negative,
            significand: self.significand * other.significand,
            exponent: self.exponent + other.exponent,
        }
    }

    /// The quotient, or a number that rounds like it: its first digits, at least 37, and a last bit that is set if
    /// further digits are not zero. No significand is zero.
    #[inline]
    fn divided_by(self, other: Self) -> Self {
        let shift = self.significand.leading_zeros() - 3;
        let dividend = self.significand << shift;
        let inexact = u64::from(!dividend.is_multiple_of(other.significand));
        Self {
            negative: self.negative != other.negative,
            significand: (dividend / other.significand) << 1 | inexact,
            exponent: self.exponent - other.exponent - shift as i32 - 1,
        }
    }

    /// The square root, or a number that rounds like it: its first digits, at least 30, and a last bit as in
    /// [`divided_by`](Self::divided_by). The number is positive.
    #[inline]
    fn root(self) -> Self {
        let most = self.significand.leading_zeros();
        // The square of an integer times an even power of two has an even exponent.
        let shift = most - u32::from((self.exponent - most as i32) % 2 != 0);
        let radicand = self.significand << shift;
        let root = radicand.isqrt();
        Self {
            negative: false,
            significand: root << 1 | u64::from(root * root != radicand),
            exponent: (self.exponent - shift as i32) / 2 - 1,
        }
    }

    #[inline]
    fn signed(self) -> i64 {
        if self.negative { -(self.significand as i64) } else { self.significand as i64 }
    }
}
