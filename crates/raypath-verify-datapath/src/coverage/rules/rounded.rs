//! Arithmetic of a format, for the rules of all operations.

use raypath_float::Format;

/// A format's arithmetic: each operation is computed in binary64 and rounded into the format.
#[derive(Debug, Clone, Copy)]
pub struct Rounded(pub Format);

impl Rounded {
    #[inline]
    pub fn value(self, code: u64) -> f64 {
        if self.0 == Format::BINARY32 { f32::from_bits(code as u32).into() } else { self.0.to_f64(code) }
    }
    #[inline]
    pub fn round(self, number: f64) -> f64 {
        if self.0 == Format::BINARY32 { (number as f32).into() } else { self.0.to_f64(self.0.from_f64(number)) }
    }
    #[inline]
    pub fn add(self, a: f64, b: f64) -> f64 {
        self.round(a + b)
    }
    #[inline]
    pub fn sub(self, a: f64, b: f64) -> f64 {
        self.round(a - b)
    }
    #[inline]
    pub fn mul(self, a: f64, b: f64) -> f64 {
        self.round(a * b)
    }
}
