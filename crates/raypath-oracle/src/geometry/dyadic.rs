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

impl Dyadic {
    /// 2^`exponent`.
    pub fn power_of_two(exponent: i32) -> Self {
        Self { significand: 1.into(), exponent }
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
    use super::{Dyadic, within_gamma};
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

    #[test]
    fn gamma_is_a_little_more_than_n_roundings() {
        let (one, u) = (Dyadic::from(1.0), Dyadic::power_of_two(-24));
        assert!(within_gamma(3, &(&Dyadic::from(3) * &u), &one));
        assert!(!within_gamma(3, &(&Dyadic::from(3.0001) * &u), &one));
    }
}
