//! A second oracle, in integers, for formats beyond the reach of the first: a finite number is `factor * 2^exponent`.

use raypath_float::Format;
use raypath_verify::units::bench::UnitResults;

/// The expected results for two IEEE 754 codes.
pub fn results(format: Format, a: u64, b: u64) -> UnitResults {
    let (x, y) = (Number::of(format, a), Number::of(format, b));
    match (x, y) {
        (Number::Finite(x), Number::Finite(y)) => {
            let (sum, difference) = (x.plus(y), x.plus(Finite { negative: !y.negative, ..y }));
            UnitResults {
                sum: sum.code(format),
                difference: difference.code(format),
                product: x.times(y).code(format),
                less: difference.factor != 0 && difference.negative,
                equal: difference.factor == 0,
                unordered: false,
                parts_differ: 0,
            }
        }
        _ => {
            // With an infinity or a NaN among them, only signs and zeros matter.
            let (x, y) = (x.representative(), y.representative());
            UnitResults {
                sum: special_code(format, x + y),
                difference: special_code(format, x - y),
                product: special_code(format, x * y),
                less: x < y,
                equal: x == y,
                unordered: x.is_nan() || y.is_nan(),
                parts_differ: 0,
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Number {
    Finite(Finite),
    Infinite { negative: bool },
    Nan,
}

#[derive(Clone, Copy)]
struct Finite {
    negative: bool,
    factor: u128,
    exponent: i32,
}

impl Number {
    fn of(format: Format, code: u64) -> Self {
        let fraction_width = format.significand() - 1;
        let fraction = code & ((1 << fraction_width) - 1);
        let biased = code >> fraction_width & ((1 << format.exponent()) - 1);
        let negative = code >> (format.ieee_width() - 1) & 1 == 1;
        if biased == (1 << format.exponent()) - 1 {
            return if fraction == 0 { Self::Infinite { negative } } else { Self::Nan };
        }
        let hidden = if biased == 0 { 0 } else { 1 << fraction_width };
        let exponent = least_exponent(format) + biased.max(1) as i32 - 1;
        Self::Finite(Finite { negative, factor: (hidden | fraction).into(), exponent })
    }

    fn representative(self) -> f64 {
        match self {
            Self::Nan => f64::NAN,
            Self::Infinite { negative } => f64::INFINITY.copysign(sign(negative)),
            Self::Finite(finite) if finite.factor == 0 => 0.0_f64.copysign(sign(finite.negative)),
            Self::Finite(finite) => sign(finite.negative),
        }
    }
}

impl Finite {
    fn times(self, other: Self) -> Self {
        Self {
            negative: self.negative != other.negative,
            factor: self.factor * other.factor,
            exponent: self.exponent + other.exponent,
        }
    }

    /// The sum, or a number that rounds as the sum does if the addends are more than 80 bits apart.
    fn plus(self, other: Self) -> Self {
        let (high, low) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let distance = high.exponent - low.exponent;
        let exponent = high.exponent - distance.min(80);
        let low_factor = if distance <= 80 { low.factor } else { low.factor.min(1) };
        let high = signed(high.negative, high.factor << distance.min(80));
        let total = high + signed(low.negative, low_factor);
        let both_negative = self.negative && other.negative;
        Self { negative: total < 0 || total == 0 && both_negative, factor: total.unsigned_abs(), exponent }
    }

    /// The code nearest to it, ties to even.
    fn code(self, format: Format) -> u64 {
        let s = format.significand() as i32;
        let length = 128 - self.factor.leading_zeros() as i32;
        let last_place = (self.exponent + length - s).max(least_exponent(format));
        let lost = last_place - self.exponent;
        let significand = match lost {
            ..=0 => self.factor << -lost,
            1..=127 => {
                let (kept, rest, half) = (self.factor >> lost, self.factor & ((1 << lost) - 1), 1 << (lost - 1));
                kept + u128::from(rest > half || rest == half && kept % 2 == 1)
            }
            _ => 0,
        };
        // A hidden bit, or a carry out of the significand, adds one to the exponent field.
        let steps = if self.factor == 0 { 0 } else { (last_place - least_exponent(format)) as u64 };
        let magnitude = (steps << (s - 1)) + significand as u64;
        u64::from(self.negative) << (format.ieee_width() - 1) | magnitude.min(infinity(format))
    }
}

fn special_code(format: Format, result: f64) -> u64 {
    if result.is_nan() {
        return infinity(format) | 1 << (format.significand() - 2);
    }
    assert!(result.is_infinite());
    u64::from(result < 0.0) << (format.ieee_width() - 1) | infinity(format)
}

/// The exponent of the last bit of subnormal numbers.
fn least_exponent(format: Format) -> i32 {
    3 - (1 << (format.exponent() - 1)) - format.significand() as i32
}

fn infinity(format: Format) -> u64 {
    ((1 << format.exponent()) - 1) << (format.significand() - 1)
}

fn sign(negative: bool) -> f64 {
    if negative { -1.0 } else { 1.0 }
}

fn signed(negative: bool, factor: u128) -> i128 {
    if negative { -(factor as i128) } else { factor as i128 }
}
