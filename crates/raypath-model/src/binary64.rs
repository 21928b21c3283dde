use crate::kernels::ModelCircuit;
use raypath_ops::{Circuit, Concrete, Portable, Relation, Test};

/// IEEE 754 binary64, computed by the machine's floating-point instructions. The accuracy of other formats is measured
/// against it.
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
    type Num = Double;
    type Bit = bool;
    type Word = u32;
    type Order = (f64, f64);

    #[inline]
    fn constant(self, value: f32) -> Double {
        Double(value.into())
    }
    #[inline]
    fn one_plus_ulps(self, ulps: u32) -> Double {
        Double(1.0 + f64::from(ulps) * f64::EPSILON)
    }
    #[inline]
    fn add(self, a: Double, b: Double) -> Double {
        Double(a.0 + b.0)
    }
    #[inline]
    fn subtract(self, a: Double, b: Double) -> Double {
        Double(a.0 - b.0)
    }
    #[inline]
    fn multiply(self, a: Double, b: Double) -> Double {
        Double(a.0 * b.0)
    }
    #[inline]
    fn negate(self, a: Double) -> Double {
        Double(-a.0)
    }
    #[inline]
    fn compare(self, a: Double, b: Double) -> (f64, f64) {
        (a.0, b.0)
    }
    #[inline]
    fn relation(self, (a, b): (f64, f64), relation: Relation) -> bool {
        match relation {
            Relation::Less => a < b,
            Relation::LessOrEqual => a <= b,
            Relation::Equal => a == b,
            Relation::GreaterOrEqual => a >= b,
            Relation::Greater => a > b,
        }
    }
    #[inline]
    fn number_of(self, _width: u32, word: u32) -> Double {
        Double(word.into())
    }
    #[inline]
    fn test(self, test: Test, a: Double) -> bool {
        match test {
            Test::SignBit => a.0.is_sign_negative(),
            Test::Zero => a.0 == 0.0,
            Test::Nan => a.0.is_nan(),
            Test::AtLeastZero => a.0 >= 0.0,
            Test::AboveZero => a.0 > 0.0,
            Test::AtMostZero => a.0 <= 0.0,
            Test::BelowZero => a.0 < 0.0,
        }
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
