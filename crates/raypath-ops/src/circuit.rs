//! The arithmetic that operations are written in.

use crate::{Bit, Bundle, Num, Word};
use std::fmt::{Arguments, Debug};

/// An interpretation of operations: native arithmetic, software floating point, SIMD lanes, or a recorder that builds
/// hardware.
///
/// An operation is generic over its circuit, so an implementation of this trait interprets all operations. Arithmetic
/// is IEEE 754 with round to nearest even, and rounds once per operator. The sign of a NaN is unspecified: code that
/// reads a sign must also test [`Num::is_nan`] where a NaN matters.
pub trait Circuit: Copy + Debug + PartialEq {
    /// A floating-point number.
    type Num: Copy + Debug + PartialEq;
    /// A truth value.
    type Bit: Copy + Debug + PartialEq;
    /// An unsigned word of at most 32 bits.
    type Word: Copy + Debug + PartialEq;
    /// The result of one comparison, from which every [`Relation`] can be read.
    type Order: Copy + Debug + PartialEq;

    /// Marks the operators that follow as part of pipeline stage `number`, from 1. The printed schedule shows `what`.
    fn stage(self, _number: u32, _what: &'static str) {}

    /// Marks the operators that follow as part of stage `number`, or of stage `short` in the shorter pipeline of
    /// datapaths whose sums round once ([`Rounding::Sum`](crate::Rounding::Sum)).
    fn stage_or(self, number: u32, _short: u32, what: &'static str) {
        self.stage(number, what);
    }

    /// Requests automatic staging. An operation that calls this before its first operator marks no stages itself.
    fn auto(self) {}

    /// Names values in the generated hardware.
    fn label<B: Bundle<Self>>(self, _name: Arguments<'_>, _value: &B) {}

    /// A constant, which must be exact in the circuit's format.
    fn constant(self, value: f32) -> Self::Num;
    /// The number of this many units in the last place of 1: a power of two, at most 1.
    fn ulps(self, ulps: u32) -> Self::Num;
    /// Sum.
    fn add(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// The sum of 3 to 64 terms, rounded once. The terms are truncated to a window below the greatest of their
    /// exponents, and then added exactly (`docs/reference/semantics.md`). The order of the terms does not matter. The
    /// marked stage is the one in which the sum is available: it begins one stage earlier if there are 3 terms,
    /// otherwise two.
    fn sum(self, terms: &[Self::Num]) -> Self::Num;
    /// Difference.
    fn subtract(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// Product.
    fn multiply(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// What rounding took from `product`, the product of `a` and `b`: a word of [`RESIDUE_BITS`](crate::RESIDUE_BITS).
    /// Of two products that are equal after rounding, the one of the greater exact magnitude has the greater residue;
    /// but nothing is known of a product that is not 0 and below the normal range, whose residue has the bit
    /// [`RESIDUE_TINY`](crate::RESIDUE_TINY).
    fn residue(self, product: Self::Num, a: Self::Num, b: Self::Num) -> Self::Word;
    /// The number with its sign inverted.
    fn negate(self, a: Self::Num) -> Self::Num;
    /// The number rounded in one direction to a shorter significand.
    fn narrow(self, a: Self::Num, to: Narrowing) -> Self::Num;
    /// Compares two numbers; −0 equals +0.
    fn compare(self, a: Self::Num, b: Self::Num) -> Self::Order;
    /// Reads a relation from a comparison.
    fn relation(self, order: Self::Order, relation: Relation) -> Self::Bit;
    /// Converts a word of `width` bits (at most 16), each value of which must be exact in the format, without an adder.
    fn number_of(self, width: u32, word: Self::Word) -> Self::Num;
    /// Tests a number's sign and class, without a comparator.
    fn test(self, test: Test, a: Self::Num) -> Self::Bit;

    /// A constant truth value.
    fn constant_bit(self, value: bool) -> Self::Bit;
    /// Conjunction.
    fn and(self, a: Self::Bit, b: Self::Bit) -> Self::Bit;
    /// Disjunction.
    fn or(self, a: Self::Bit, b: Self::Bit) -> Self::Bit;
    /// Negation.
    fn not(self, a: Self::Bit) -> Self::Bit;

    /// A constant word of `width` bits.
    fn constant_word(self, width: u32, value: u32) -> Self::Word;
    /// Whether two words are equal.
    fn word_equal(self, a: Self::Word, b: Self::Word) -> Self::Bit;
    /// Whether the first word is less than the second, unsigned.
    fn word_less(self, a: Self::Word, b: Self::Word) -> Self::Bit;

    /// Selects `if_true` if `condition` holds, else `if_false`, bit for bit.
    fn select_num(self, condition: Self::Bit, if_true: Self::Num, if_false: Self::Num) -> Self::Num;
    /// Selects `if_true` if `condition` holds, else `if_false`.
    fn select_bit(self, condition: Self::Bit, if_true: Self::Bit, if_false: Self::Bit) -> Self::Bit;
    /// Selects `if_true` if `condition` holds, else `if_false`.
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word;

    /// +0.0.
    #[inline(always)]
    fn zero(self) -> Num<Self> {
        Num::new(self, self.constant(0.0))
    }
    /// +∞.
    #[inline(always)]
    fn infinity(self) -> Num<Self> {
        Num::new(self, self.constant(f32::INFINITY))
    }
    /// A constant truth value, as a handle.
    #[inline(always)]
    fn bit(self, value: bool) -> Bit<Self> {
        Bit::new(self, self.constant_bit(value))
    }
    /// A constant word, as a handle.
    #[inline(always)]
    fn word<const W: u32>(self, value: u32) -> Word<Self, W> {
        Word::new(self, self.constant_word(W, value))
    }
}

/// A relation that can be read from a comparison. Each is false if an operand is NaN.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Relation {
    /// a < b
    Less,
    /// a ≤ b
    LessOrEqual,
    /// a = b
    Equal,
    /// a ≥ b
    GreaterOrEqual,
    /// a > b
    Greater,
}

/// A rounding to a shorter significand in one direction ([`Circuit::narrow`]).
///
/// Infinities and NaN stay. The magnitude of any other number is moved by `margin` units in the last place of the
/// circuit's format in the direction, at most to zero, and then rounded in the direction to `bits` bits. A magnitude
/// below twice the least normal number becomes zero, and one that exceeds the largest number of the format infinite.
/// Numbers keep their signs. (Below twice the least normal number, and not below that number itself, because there a
/// product is rounded in the same places whether or not the exponent has a limit.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Narrowing {
    /// The bits of the significand, hidden bit included: from 3 to those of the circuit's format.
    pub bits: u32,
    /// The direction.
    pub direction: Direction,
    /// Units in the last place of the circuit's format, at most 4.
    pub margin: u32,
}

/// The direction in which a magnitude is rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// To a magnitude that is not greater.
    TowardZero,
    /// To a magnitude that is not less.
    AwayFromZero,
}

impl Narrowing {
    /// Rounding toward zero to `bits` bits.
    pub const fn toward_zero(bits: u32) -> Self {
        Self { bits, direction: Direction::TowardZero, margin: 0 }
    }

    /// Rounding away from zero to `bits` bits.
    pub const fn away_from_zero(bits: u32) -> Self {
        Self { bits, direction: Direction::AwayFromZero, margin: 0 }
    }

    /// The same with another margin.
    pub const fn margin(self, margin: u32) -> Self {
        Self { margin, ..self }
    }
}

/// A property that follows from a number's sign and class alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Test {
    /// The sign bit: set for −0 and −∞, unspecified for a NaN.
    SignBit,
    /// +0 or −0.
    Zero,
    /// NaN.
    Nan,
    /// ≥ 0: true for both zeros, false for a NaN.
    AtLeastZero,
    /// > 0: false for zeros and NaN.
    AboveZero,
    /// ≤ 0: true for both zeros, false for a NaN.
    AtMostZero,
    /// < 0: false for zeros and NaN.
    BelowZero,
}

/// A circuit that computes values: native arithmetic or software floating point. Its numbers convert to and from bits.
pub trait Concrete: Circuit<Bit = bool, Word = u32> {
    /// The number with these bits in the IEEE 754 layout. Bits beyond the format's width are ignored.
    fn number(self, ieee_bits: u64) -> Self::Num;

    /// The number's bits in the IEEE 754 layout. Every NaN becomes the canonical NaN.
    fn bits(self, number: Self::Num) -> u64;

    /// The number's bits, including the sign and payload of a NaN that was made by [`number`](Self::number).
    fn raw_bits(self, number: Self::Num) -> u64;
}
