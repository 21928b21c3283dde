//! Exact arithmetic for oracles: numbers as rationals, and as integers of the same order.

use num_bigint::BigInt;
use num_rational::BigRational;
use raypath_ops::{Binary32, Num, Vec3};

/// An integer of the same order as the number: equal for equal numbers, 0 for both zeros, `None` for a NaN.
pub fn order(number: Num<Binary32>) -> Option<i64> {
    let bits = i64::from(number.to_bits());
    let magnitude = bits & 0x7fff_ffff;
    (magnitude <= 0x7f80_0000).then_some(if bits == magnitude { magnitude } else { -magnitude })
}

/// The value of a number; `None` if it is not finite.
pub fn value(number: Num<Binary32>) -> Option<BigRational> {
    BigRational::from_float(f32::from(number))
}

/// The values of a vector; `None` if a coordinate is not finite.
pub fn values(vector: Vec3<Binary32>) -> Option<[BigRational; 3]> {
    Some([value(vector.x)?, value(vector.y)?, value(vector.z)?])
}

/// Two to the power of `exponent`.
pub fn power(exponent: i32) -> BigRational {
    let power = BigRational::from_integer(BigInt::from(1) << exponent.unsigned_abs());
    if exponent < 0 { power.recip() } else { power }
}

/// The absolute value.
pub fn absolute(number: &BigRational) -> BigRational {
    number.clone().max(-number)
}
