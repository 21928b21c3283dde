//! Exact signs with big integers: binary32 numbers are integers times 2⁻¹⁴⁹.

use num_bigint::{BigInt, Sign};

/// The exact sign of (p × q) · d, where p = a − o and q = b − o.
pub fn side(o: [f32; 3], d: [f32; 3], a: [f32; 3], b: [f32; 3]) -> i32 {
    let difference = |v: [f32; 3]| -> [BigInt; 3] { std::array::from_fn(|k| integer(v[k]) - integer(o[k])) };
    let (p, q, d) = (difference(a), difference(b), d.map(integer));
    let cross = |i: usize, j: usize| &p[i] * &q[j] - &p[j] * &q[i];
    match (cross(1, 2) * &d[0] + cross(2, 0) * &d[1] + cross(0, 1) * &d[2]).sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

/// A number times 2¹⁴⁹.
fn integer(x: f32) -> BigInt {
    let bits = x.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
    let magnitude =
        if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction | 0x80_0000) << (exponent - 1) };
    if x.is_sign_negative() { -magnitude } else { magnitude }
}
