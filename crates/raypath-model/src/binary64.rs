use crate::kernels::ModelCircuit;
use raypath_ops::{Circuit, Concrete, Layout, Portable};

/// IEEE 754 binary64, computed by the machine: the reference for the accuracy of other formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Binary64;

/// A binary64 number. Two are equal if their bits are; all NaNs are equal.
#[derive(Debug, Clone, Copy, Default)]
pub struct Double(pub f64);

impl Double {
    /// The number's bits; a NaN becomes the canonical NaN.
    #[inline]
    pub fn to_bits(self) -> u64 {
        if self.0.is_nan() { 0x7ff8_0000_0000_0000 } else { self.0.to_bits() }
    }
}

impl PartialEq for Double {
    fn eq(&self, other: &Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl Circuit for Binary64 {
    raypath_ops::native_numbers!(Double(f64));

    #[inline(always)]
    fn add(self, a: Double, b: Double) -> Double {
        Double(a.0 + b.0)
    }
    #[inline]
    fn sum(self, terms: &[Double]) -> Double {
        Double(f64::from_bits(Layout::BINARY64.sum(terms.iter().map(|term| term.0.to_bits()))))
    }
    #[inline(always)]
    fn subtract(self, a: Double, b: Double) -> Double {
        Double(a.0 - b.0)
    }
    #[inline(always)]
    fn multiply(self, a: Double, b: Double) -> Double {
        Double(a.0 * b.0)
    }

    raypath_ops::known_bits_and_words!();
}

impl Concrete for Binary64 {
    #[inline]
    fn number(self, ieee_bits: u64) -> Double {
        Double(f64::from_bits(ieee_bits))
    }
    #[inline]
    fn bits(self, number: Double) -> u64 {
        number.to_bits()
    }
    #[inline]
    fn raw_bits(self, number: Double) -> u64 {
        number.0.to_bits()
    }
}

impl ModelCircuit for Binary64 {
    type Kernels = Portable;
    const KERNELS: Portable = Portable;
}
