//! Matrices in registers.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

/// The transposed 4 × 4 matrix.
#[inline(always)]
pub fn transposed<S: Simd>([a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (ac, ac_high) = a.interleave(c);
    let (bd, bd_high) = b.interleave(d);
    let (column_0, column_1) = ac.interleave(bd);
    let (column_2, column_3) = ac_high.interleave(bd_high);
    [column_0, column_1, column_2, column_3]
}
