use crate::kernels::ModelCircuit;
use raypath_float::Format;
use raypath_ops::{Circuit, Concrete, Direction, Layout, Narrowing, Portable, Relation, Test};
use std::cmp::Ordering;

/// Software arithmetic in any format. The operations over it are the golden model of a datapath in that format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Soft {
    /// The format.
    pub format: Format,
}

/// A number of a [`Soft`] circuit in the IEEE 754 layout. Two are equal if their bits are; a computed NaN is canonical.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SoftNumber(pub u64);

impl Circuit for Soft {
    type Num = SoftNumber;
    type Bit = bool;
    type Word = u32;
    type Order = Option<Ordering>;

    #[inline]
    fn constant(self, value: f32) -> SoftNumber {
        SoftNumber(self.format.from_f32(value))
    }
    #[inline]
    fn ulps(self, ulps: u32) -> SoftNumber {
        SoftNumber(self.format.ulps(ulps))
    }
    #[inline]
    fn add(self, a: SoftNumber, b: SoftNumber) -> SoftNumber {
        SoftNumber(self.format.add(a.0, b.0))
    }
    #[inline]
    fn sum(self, terms: &[SoftNumber]) -> SoftNumber {
        let layout = Layout { exponent: self.format.exponent(), significand: self.format.significand() };
        SoftNumber(layout.sum(terms.iter().map(|term| term.0)))
    }
    #[inline]
    fn subtract(self, a: SoftNumber, b: SoftNumber) -> SoftNumber {
        SoftNumber(self.format.sub(a.0, b.0))
    }
    #[inline]
    fn multiply(self, a: SoftNumber, b: SoftNumber) -> SoftNumber {
        SoftNumber(self.format.mul(a.0, b.0))
    }
    #[inline]
    fn residue(self, _product: SoftNumber, a: SoftNumber, b: SoftNumber) -> u32 {
        let layout = Layout { exponent: self.format.exponent(), significand: self.format.significand() };
        layout.residue(a.0, b.0)
    }
    #[inline]
    fn negate(self, a: SoftNumber) -> SoftNumber {
        SoftNumber(self.format.neg(a.0))
    }
    #[inline]
    fn narrow(self, a: SoftNumber, to: Narrowing) -> SoftNumber {
        SoftNumber(match to.direction {
            Direction::TowardZero => self.format.narrow_toward_zero(a.0, to.bits, to.margin),
            Direction::AwayFromZero => self.format.narrow_away_from_zero(a.0, to.bits, to.margin),
        })
    }
    #[inline]
    fn compare(self, a: SoftNumber, b: SoftNumber) -> Option<Ordering> {
        self.format.compare(a.0, b.0)
    }
    #[inline]
    fn relation(self, order: Option<Ordering>, relation: Relation) -> bool {
        order.is_some_and(match relation {
            Relation::Less => Ordering::is_lt,
            Relation::LessOrEqual => Ordering::is_le,
            Relation::Equal => Ordering::is_eq,
            Relation::GreaterOrEqual => Ordering::is_ge,
            Relation::Greater => Ordering::is_gt,
        })
    }
    #[inline]
    fn number_of(self, _width: u32, word: u32) -> SoftNumber {
        SoftNumber(self.format.from_f64(word.into()))
    }
    #[inline]
    fn test(self, test: Test, a: SoftNumber) -> bool {
        let against_zero = |relation| self.relation(self.compare(a, SoftNumber(0)), relation);
        match test {
            Test::SignBit => self.format.is_sign_negative(a.0),
            Test::Zero => self.format.is_zero(a.0),
            Test::Nan => self.format.is_nan(a.0),
            Test::AtLeastZero => against_zero(Relation::GreaterOrEqual),
            Test::AboveZero => against_zero(Relation::Greater),
            Test::AtMostZero => against_zero(Relation::LessOrEqual),
            Test::BelowZero => against_zero(Relation::Less),
        }
    }

    raypath_ops::known_bits_and_words!();
}

impl Concrete for Soft {
    #[inline]
    fn number(self, ieee_bits: u64) -> SoftNumber {
        SoftNumber(ieee_bits & (u64::MAX >> (64 - self.format.ieee_width())))
    }
    #[inline]
    fn bits(self, number: SoftNumber) -> u64 {
        self.format.canonical(number.0)
    }
    #[inline]
    fn raw_bits(self, number: SoftNumber) -> u64 {
        number.0
    }
}

impl ModelCircuit for Soft {
    type Kernels = Portable;
    const KERNELS: Portable = Portable;
}
