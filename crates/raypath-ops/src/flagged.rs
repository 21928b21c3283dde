//! Binary32 arithmetic with exception flags.

use crate::{Circuit, Concrete, Layout, Single};
use std::cell::Cell;

/// IEEE 754 binary32 that records the exceptions of additions, subtractions and multiplications in a cell. Set the cell
/// to 0 before a job; after the job it holds the value of the datapath's `exception_flags` port.
///
/// Tininess is detected before rounding, and underflow is raised only together with inexact. No NaN is signaling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flagged<'f> {
    /// The exceptions raised so far, as the bitwise OR of the constants below.
    pub raised: &'f Cell<u64>,
}

impl Flagged<'_> {
    /// A result was rounded to another number.
    pub const INEXACT: u64 = 1;
    /// A result below the normal range was rounded.
    pub const UNDERFLOW: u64 = 2;
    /// A rounded result exceeds the largest finite number.
    pub const OVERFLOW: u64 = 4;
    /// Infinity minus infinity, or zero times infinity.
    pub const INVALID: u64 = 8;

    /// Records the exceptions of `result`. Its exact value is `exact + more`, because `exact` alone may be rounded.
    #[inline]
    fn note(self, [a, b]: [Single; 2], result: Single, exact: f64, more: f64) -> Single {
        let rounded = f64::from(result.0);
        let flags = if rounded.is_nan() {
            if a.0.is_nan() || b.0.is_nan() { 0 } else { Self::INVALID }
        } else if a.0.is_infinite() || b.0.is_infinite() {
            0
        } else if rounded.is_infinite() {
            Self::OVERFLOW | Self::INEXACT
        } else if rounded == exact && more == 0.0 {
            0
        } else if exact.abs() < f64::from(f32::MIN_POSITIVE) {
            Self::UNDERFLOW | Self::INEXACT
        } else {
            Self::INEXACT
        };
        self.raised.set(self.raised.get() | flags);
        result
    }
}

impl Circuit for Flagged<'_> {
    // A sum that rounds once records none: no configuration has both.
    crate::native_numbers!(Single(f32), u32, Layout::BINARY32);

    #[inline]
    fn add(self, a: Single, b: Single) -> Single {
        let (x, y) = (f64::from(a.0), f64::from(b.0));
        let sum = x + y;
        // The rounding error of the binary64 sum (Knuth's two-sum).
        let rounded_y = sum - x;
        let lost = (x - (sum - rounded_y)) + (y - rounded_y);
        self.note([a, b], Single(a.0 + b.0), sum, lost)
    }
    #[inline]
    fn subtract(self, a: Single, b: Single) -> Single {
        self.add(a, Single(-b.0))
    }
    #[inline]
    fn multiply(self, a: Single, b: Single) -> Single {
        self.note([a, b], Single(a.0 * b.0), f64::from(a.0) * f64::from(b.0), 0.0)
    }

    crate::known_bits_and_words!();
}

impl Concrete for Flagged<'_> {
    crate::native_bits!(Single(f32), u32);
}
