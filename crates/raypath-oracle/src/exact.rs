//! What judges compute with: numbers as rationals, and as integers in their order.

use num_bigint::BigInt;
use num_rational::BigRational;
use raypath_ops::{Binary32, Num, Vec3};

/// A number's place among all numbers: less where the number is less, equal where it is equal, so that both zeros are
/// 0. None for a NaN.
pub fn order(number: Num<Binary32>) -> Option<i64> {
    let bits = i64::from(number.to_bits());
    let magnitude = bits & 0x7fff_ffff;
    (magnitude <= 0x7f80_0000).then_some(if bits == magnitude { magnitude } else { -magnitude })
}

/// A finite number's value.
pub fn value(number: Num<Binary32>) -> Option<BigRational> {
    BigRational::from_float(f32::from(number))
}

/// The values of three finite numbers.
pub fn values(vector: Vec3<Binary32>) -> Option<[BigRational; 3]> {
    Some([value(vector.x)?, value(vector.y)?, value(vector.z)?])
}

/// Two to the power of `exponent`.
pub fn power(exponent: i32) -> BigRational {
    let power = BigRational::from_integer(BigInt::from(1) << exponent.unsigned_abs());
    if exponent < 0 { power.recip() } else { power }
}

/// Without its sign.
pub fn absolute(number: &BigRational) -> BigRational {
    greater(number.clone(), -number)
}

/// The greater one; the first where they are equal.
pub fn greater(a: BigRational, b: BigRational) -> BigRational {
    if b > a { b } else { a }
}

/// The lesser one; the first where they are equal.
pub fn lesser(a: BigRational, b: BigRational) -> BigRational {
    if b < a { b } else { a }
}
