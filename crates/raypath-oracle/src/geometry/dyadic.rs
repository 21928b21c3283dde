//! Exact arithmetic on dyadic numbers, integers times powers of two: binary32 numbers, their sums and products.

use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

/// `significand` · 2^`exponent`, exactly.
#[derive(Debug, Clone, Default)]
pub struct Dyadic {
    significand: BigInt,
    exponent: i32,
}

/// How a number is rounded to a multiple of a power of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// The nearest; of two, the one with an even significand.
    NearestEven,
    /// The nearest; of two, the one away from zero.
    NearestTiesAway,
    /// The nearest one that is not farther from zero.
    TowardZero,
    /// The nearest one that is not closer to zero.
    AwayFromZero,
}

impl Dyadic {
    /// `significand` · 2^`exponent`.
    pub fn new(significand: u64, exponent: i32) -> Self {
        Self { significand: significand.into(), exponent }
    }

    /// 2^`exponent`.
    pub fn power_of_two(exponent: i32) -> Self {
        Self::new(1, exponent)
    }

    /// e of 2^e ≤ |x| < 2^(e+1); the least exponent for zero.
    pub fn exponent(&self) -> i32 {
        match self.significand.bits() {
            0 => i32::MIN,
            bits => self.exponent + bits as i32 - 1,
        }
    }

    /// The magnitude in units of 2^`place`, of which it is a multiple below 2^64.
    pub fn multiples_of(&self, place: i32) -> u64 {
        let magnitude = self.significand.magnitude();
        let units = match self.exponent - place {
            distance @ 0.. => magnitude << distance,
            distance => magnitude >> distance.unsigned_abs(),
        };
        units.iter_u64_digits().next().unwrap_or(0)
    }

    /// The number rounded to a multiple of 2^`place`.
    pub fn rounded_to(self, place: i32, rounding: Rounding) -> Self {
        let distance = i64::from(place) - i64::from(self.exponent);
        if distance <= 0 {
            return self;
        }
        let magnitude = self.significand.magnitude();
        let (mut kept, half) = (magnitude >> distance, distance as u64 - 1);
        // The bits that are lost: whether there are any, whether the first is set, and whether others are.
        let lowest = magnitude.trailing_zeros().unwrap_or(u64::MAX);
        let (is_exact, is_half, is_more) = (lowest > half, magnitude.bit(half), lowest < half);
        let is_up = match rounding {
            Rounding::NearestEven => is_half && (is_more || kept.bit(0)),
            Rounding::NearestTiesAway => is_half,
            Rounding::TowardZero => false,
            Rounding::AwayFromZero => !is_exact,
        };
        kept += u32::from(is_up);
        Self { significand: BigInt::from_biguint(self.significand.sign(), kept), exponent: place }
    }

    /// How the number compares with zero.
    pub fn sign(&self) -> Ordering {
        match self.significand.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }

    /// The absolute value.
    pub fn abs(&self) -> Self {
        let significand = BigInt::from(self.significand.magnitude().clone());
        Self { significand, exponent: self.exponent }
    }

    /// The number rounded towards zero to binary64, or infinity: for reports.
    pub fn to_f64(&self) -> f64 {
        let surplus = self.significand.bits().saturating_sub(53);
        let top = self.significand.magnitude() >> surplus;
        let top = top.iter_u64_digits().next().unwrap_or(0) as f64;
        let exponent = i64::from(self.exponent) + surplus as i64;
        // Two factors, because one power of two could be out of range although the product is not.
        let half = (exponent / 2).clamp(-1100, 1100) as i32;
        let rest = (exponent - i64::from(half)).clamp(-1100, 1100) as i32;
        let magnitude = top * 2_f64.powi(half) * 2_f64.powi(rest);
        if self.sign().is_lt() { -magnitude } else { magnitude }
    }

    /// The significand in units of 2^`exponent`, which is at most the number's exponent.
    fn scaled(&self, exponent: i32) -> BigInt {
        &self.significand << (self.exponent - exponent)
    }
}

impl From<f64> for Dyadic {
    /// Converts a finite number; panics for others.
    fn from(x: f64) -> Self {
        assert!(x.is_finite(), "{x} is no number");
        if x == 0.0 {
            return Self::default();
        }
        let bits = x.to_bits();
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
        let magnitude = if field == 0 { fraction } else { fraction | 1 << 52 };
        let zeros = magnitude.trailing_zeros();
        let significand = BigInt::from(magnitude >> zeros);
        let significand = if x.is_sign_negative() { -significand } else { significand };
        Self { significand, exponent: field.max(1) - 1075 + zeros as i32 }
    }
}

impl From<f32> for Dyadic {
    /// Converts a finite number; panics for others.
    fn from(x: f32) -> Self {
        f64::from(x).into()
    }
}

impl From<u32> for Dyadic {
    fn from(x: u32) -> Self {
        Self { significand: x.into(), exponent: 0 }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        let exponent = self.exponent.min(other.exponent);
        self.scaled(exponent).cmp(&other.scaled(exponent))
    }
}

impl Neg for Dyadic {
    type Output = Self;
    fn neg(self) -> Self {
        Self { significand: -self.significand, exponent: self.exponent }
    }
}

/// Implements an operator for references and values.
macro_rules! operator {
    ($trait:ident, $name:ident, |$a:ident, $b:ident| $result:expr) => {
        impl $trait<&Dyadic> for &Dyadic {
            type Output = Dyadic;
            fn $name(self, other: &Dyadic) -> Dyadic {
                let ($a, $b) = (self, other);
                $result
            }
        }
        impl $trait<Dyadic> for Dyadic {
            type Output = Dyadic;
            fn $name(self, other: Dyadic) -> Dyadic {
                (&self).$name(&other)
            }
        }
        impl $trait<&Dyadic> for Dyadic {
            type Output = Dyadic;
            fn $name(self, other: &Dyadic) -> Dyadic {
                (&self).$name(other)
            }
        }
    };
}

operator!(Add, add, |a, b| {
    let exponent = a.exponent.min(b.exponent);
    Dyadic { significand: a.scaled(exponent) + b.scaled(exponent), exponent }
});
operator!(Sub, sub, |a, b| {
    let exponent = a.exponent.min(b.exponent);
    Dyadic { significand: a.scaled(exponent) - b.scaled(exponent), exponent }
});
operator!(Mul, mul, |a, b| Dyadic { significand: &a.significand * &b.significand, exponent: a.exponent + b.exponent });

/// The unit roundoff of binary32.
pub const U: f64 = 1.0 / 16_777_216.0;

/// The number of ulps of binary32 in a number of this size.
pub fn ulps_of(x: f64) -> f64 {
    let binade = x.abs().log2().floor().max(-126.0);
    x.abs() / (binade - 23.0).exp2()
}

/// Whether `error` is at most γₙ times `magnitude`, γₙ = n·u / (1 − n·u) with u = 2⁻²⁴: the bound of
/// n roundings to binary32 (Higham, Accuracy and Stability of Numerical Algorithms, lemma 3.1).
pub fn within_gamma(n: u32, error: &Dyadic, magnitude: &Dyadic) -> bool {
    &Dyadic::from((1 << 24) - n) * error <= &Dyadic::from(n) * magnitude
}

#[cfg(test)]
mod tests {
    use super::{Dyadic, Rounding, within_gamma};
    use num_rational::Ratio;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    fn ratio(x: f32) -> Ratio<i128> {
        Ratio::new((f64::from(x) * f64::from(1 << 20)) as i128, 1 << 20)
    }

    fn is(value: &Dyadic, expected: Ratio<i128>) -> bool {
        // 2^80 times an integer of this size is one.
        let scaled = value * &Dyadic::power_of_two(80);
        scaled.scaled(0) == num_bigint::BigInt::from(*(expected * (1_i128 << 80)).numer())
    }

    /// Against rational numbers of another crate.
    #[test]
    fn it_agrees_with_rational_numbers() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..10_000 {
            let mut draw = || rng.random_range(-1000..=1000) as f32 / [1.0, 4.0, 1024.0][rng.random_range(0..3)];
            let [a, b, c] = [draw(), draw(), draw()];
            let [x, y, z] = [a, b, c].map(Dyadic::from);
            assert!(is(&(&(&x * &y) - &z), ratio(a) * ratio(b) - ratio(c)), "{a} {b} {c}");
            assert!(is(&((&x + &y) * &z), (ratio(a) + ratio(b)) * ratio(c)), "{a} {b} {c}");
            assert_eq!((&x * &y).cmp(&z), (ratio(a) * ratio(b)).cmp(&ratio(c)));
            assert_eq!(x.sign(), ratio(a).cmp(&ratio(0.0)));
            assert_eq!((x.abs().to_f64(), y.to_f64()), (f64::from(a.abs()), f64::from(b)));
        }
    }

    /// Against the host's rounding to integers.
    #[test]
    fn multiples_are_rounded() {
        for quarters in -40..=40_i32 {
            let number = f64::from(quarters) / 4.0;
            let rounded = |rounding| Dyadic::from(number).rounded_to(0, rounding);
            assert_eq!(rounded(Rounding::NearestEven), Dyadic::from(number.round_ties_even()), "{number}");
            assert_eq!(rounded(Rounding::NearestTiesAway), Dyadic::from(number.round()), "{number}");
            assert_eq!(rounded(Rounding::TowardZero), Dyadic::from(number.trunc()), "{number}");
            assert_eq!(rounded(Rounding::AwayFromZero), Dyadic::from(number.abs().ceil().copysign(number)), "{number}");
            assert_eq!(Dyadic::from(number).multiples_of(-2), u64::from(quarters.unsigned_abs()));
            if quarters != 0 {
                assert_eq!(Dyadic::from(number).exponent(), number.abs().log2().floor() as i32, "{number}");
            }
        }
        assert_eq!(Dyadic::new(3, -40).rounded_to(0, Rounding::AwayFromZero), Dyadic::new(1, 0));
        assert_eq!(Dyadic::new(3, -40).rounded_to(0, Rounding::NearestEven).sign(), std::cmp::Ordering::Equal);
    }

    #[test]
    fn gamma_is_a_little_more_than_n_roundings() {
        let (one, u) = (Dyadic::from(1.0), Dyadic::power_of_two(-24));
        assert!(within_gamma(3, &(&Dyadic::from(3) * &u), &one));
        assert!(!within_gamma(3, &(&Dyadic::from(3.0001) * &u), &one));
    }
}
