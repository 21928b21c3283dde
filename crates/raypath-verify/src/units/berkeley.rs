//! Berkeley SoftFloat 3e, the C library, as the oracle for binary32. Its calls are all that is `unsafe` in this crate.
#![allow(unsafe_code)]

use super::bench::UnitResults;
use softfloat_rs::{f32_add, f32_eq, f32_le_quiet, f32_lt_quiet, f32_mul, f32_sub, float32_t};

/// SoftFloat's results for two binary32 words, and whether the first is less than or equal to the second.
///
/// SoftFloat rounds to nearest, ties to even, unless a thread sets another rounding mode. This crate never sets one.
pub(super) fn oracle(a: u32, b: u32) -> (UnitResults, bool) {
    let (x, y) = (float32_t { v: a }, float32_t { v: b });
    // SAFETY: the C functions take and return words by value and have no preconditions. The state that they read and
    // write (rounding mode, exception flags) belongs to the thread.
    let (sum, difference, product) = unsafe { (f32_add(x, y), f32_sub(x, y), f32_mul(x, y)) };
    // SAFETY: as above.
    let (equal, less, less_or_equal, greater_or_equal) =
        unsafe { (f32_eq(x, y), f32_lt_quiet(x, y), f32_le_quiet(x, y), f32_le_quiet(y, x)) };
    let results = UnitResults {
        sum: canonical(sum),
        difference: canonical(difference),
        product: canonical(product),
        less,
        equal,
        unordered: !less_or_equal && !greater_or_equal,
        parts_differ: 0,
    };
    (results, less_or_equal)
}

/// The bits of a result, with every NaN replaced by the canonical one. SoftFloat propagates the payloads of NaNs, as
/// x86 processors do; the datapath has one NaN.
fn canonical(number: float32_t) -> u64 {
    if number.v & 0x7fff_ffff > 0x7f80_0000 { 0x7fc0_0000 } else { number.v.into() }
}
