//! Rational arithmetic that records whether binary32 computes the same without rounding.

use num_rational::Ratio;
use std::ops::{Add, Mul, Sub};

pub type Rational = Ratio<i128>;

/// A number, and whether it and all its operands are binary32 numbers.
#[derive(Debug, Clone, Copy)]
pub struct Exact {
    pub value: Rational,
    pub all_exact: bool,
}

impl Exact {
    fn new(value: Rational, operands_exact: bool) -> Self {
        Self { value, all_exact: operands_exact && to_f32(value).is_some() }
    }
}

impl From<f32> for Exact {
    fn from(value: f32) -> Self {
        Self { value: rational(value), all_exact: true }
    }
}

impl Add for Exact {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.all_exact && other.all_exact)
    }
}

impl Sub for Exact {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.all_exact && other.all_exact)
    }
}

impl Mul for Exact {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.all_exact && other.all_exact)
    }
}

/// The value of a binary32 number of moderate size.
pub fn rational(x: f32) -> Rational {
    let scaled = f64::from(x) * f64::from(1 << 20);
    assert!(scaled.fract() == 0.0 && scaled.abs() < 2f64.powi(62), "{x:e} is no number of moderate size");
    Rational::new(scaled as i128, 1 << 20)
}

/// The binary32 number of this value, if there is one.
pub fn to_f32(x: Rational) -> Option<f32> {
    let significand = x.numer().unsigned_abs();
    let significand = if significand == 0 { 0 } else { significand >> significand.trailing_zeros() };
    let is_dyadic = x.denom().count_ones() == 1 && *x.denom() <= 1 << 60;
    (is_dyadic && significand < 1 << 24 && x.numer().unsigned_abs() < 1 << 60)
        .then(|| (*x.numer() as f64 / *x.denom() as f64) as f32)
}

#[test]
fn a_third_and_25_bits_are_no_binary32_numbers() {
    assert_eq!(to_f32(Rational::new(1, 3)), None);
    assert_eq!(to_f32(Rational::from_integer((1 << 24) + 1)), None);
    assert_eq!(to_f32(Rational::from_integer((1 << 25) + 2)), None);
    assert_eq!(to_f32(Rational::from_integer((1 << 24) + 2)), Some(16_777_218.0));
    assert_eq!(to_f32(Rational::new(-3, 8)), Some(-0.375));
    let third = Exact::new(Rational::new(1, 3), true);
    assert!(!(third + third + third).all_exact, "1 is representable, but was not computed exactly");
}
