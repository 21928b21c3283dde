//! Units of rounding errors.

/// The unit roundoff of binary32.
pub const U: f64 = 1.0 / 16_777_216.0;

/// The number of ulps of binary32 in a number of this size.
pub fn ulps_of(x: f64) -> f64 {
    let binade = x.abs().log2().floor().max(-126.0);
    x.abs() / (binade - 23.0).exp2()
}
