//! What an operation may do with numbers, bits and words. A new interpretation of all operations is one implementation of
//! [`Circuit`].

use crate::alike::{Alike, Of};
use crate::bundle::Bundle;
use crate::handle::{Bit, Num, Word};
use crate::rules::{self, Place};
use std::fmt::{Arguments, Debug};

/// An interpretation of operations: native arithmetic, soft float, or a recorder that turns them into hardware.
///
/// Arithmetic is IEEE 754, round to nearest even, one rounding an operation. The sign of a NaN is unspecified: a rule
/// that reads a sign asks [`Num::is_nan`] too where it matters.
pub trait Circuit: Copy + Debug + PartialEq {
    /// A floating-point number.
    type Num: Copy + Debug + PartialEq;
    /// A truth value.
    type Bit: Copy + Debug + PartialEq;
    /// A small unsigned word.
    type Word: Copy + Debug + PartialEq;
    /// The outcome of one comparison, from which every [`Relation`] can be read.
    type Order: Copy + Debug + PartialEq;

    /// What follows belongs to pipeline stage `number` (1 is the first); `what` says it in the schedule.
    fn stage(self, _number: u32, _what: &'static str) {}

    /// Asks whoever makes hardware of it to find the pipeline stages. An operation that says so, before its first
    /// operator, marks none itself.
    fn auto(self) {}

    /// Names values for those who read the hardware.
    fn label<B: Bundle<Self>>(self, _name: Arguments<'_>, _value: &B) {}

    /// A number that is exact in the circuit's format.
    fn constant(self, value: f32) -> Self::Num;
    /// The number of the circuit's format that lies `ulps` places above 1; `ulps` is less than 2 to the power of the
    /// fraction's bits.
    fn one_plus_ulps(self, ulps: u32) -> Self::Num;
    /// Sum.
    fn add(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// Difference.
    fn subtract(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// Product.
    fn multiply(self, a: Self::Num, b: Self::Num) -> Self::Num;
    /// The number with its sign inverted.
    fn negate(self, a: Self::Num) -> Self::Num;
    /// Compares two numbers; −0 equals +0.
    fn compare(self, a: Self::Num, b: Self::Num) -> Self::Order;
    /// Reads a relation from a comparison.
    fn relation(self, order: Self::Order, relation: Relation) -> Self::Bit;
    /// A word of `width` bits, at most 16, as a number; costs no adder. It is exact in the circuit's format, which must
    /// have every value of such a word: as many bits of significand, and exponents for them.
    fn number_of(self, width: u32, word: Self::Word) -> Self::Num;
    /// Reads a number's sign and class; costs no comparator.
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
    /// The words are equal.
    fn word_equal(self, a: Self::Word, b: Self::Word) -> Self::Bit;
    /// The first word is less, unsigned.
    fn word_less(self, a: Self::Word, b: Self::Word) -> Self::Bit;

    /// `if_true` where `condition` holds, else `if_false`, bit for bit.
    fn select_num(self, condition: Self::Bit, if_true: Self::Num, if_false: Self::Num) -> Self::Num;
    /// `if_true` where `condition` holds, else `if_false`.
    fn select_bit(self, condition: Self::Bit, if_true: Self::Bit, if_false: Self::Bit) -> Self::Bit;
    /// `if_true` where `condition` holds, else `if_false`.
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word;

    /// The larger of two numbers; the other where one is NaN; `b` where they are equal.
    #[inline(always)]
    fn larger(self, a: Self::Num, b: Self::Num) -> Self::Num {
        let greater = self.relation(self.compare(a, b), Relation::Greater);
        self.select_num(self.or(greater, self.test(Test::Nan, b)), a, b)
    }
    /// The smaller of two numbers; the other where one is NaN; `b` where they are equal.
    #[inline(always)]
    fn smaller(self, a: Self::Num, b: Self::Num) -> Self::Num {
        let less = self.relation(self.compare(a, b), Relation::Less);
        self.select_num(self.or(less, self.test(Test::Nan, b)), a, b)
    }
    /// The largest of three numbers and zero, NaNs left out, a zero being +0; `name` is whose it is.
    #[inline(always)]
    fn largest_or_zero(self, name: Arguments<'_>, numbers: [Num<Self>; 3]) -> Num<Self> {
        rules::largest_or_zero(self, name, numbers)
    }
    /// The smallest of three numbers and the extent, NaNs left out, of zeros any; NaN where there is nothing else.
    #[inline(always)]
    fn smallest_or_extent(self, name: Arguments<'_>, numbers: [Num<Self>; 3], extent: Num<Self>) -> Num<Self> {
        rules::smallest_or_extent(self, name, numbers, extent)
    }
    /// Boxes, nearest hit first and misses last; no distance is negative or NaN, none is −0.
    #[inline(always)]
    fn sort(self, boxes: [Place<Self, 2>; 4]) -> [Place<Self, 2>; 4] {
        rules::sort(self, boxes)
    }
    /// The numbers, exchanged where `condition` holds.
    #[inline(always)]
    fn exchange_num(self, condition: Self::Bit, a: Self::Num, b: Self::Num) -> (Self::Num, Self::Num) {
        (self.select_num(condition, b, a), self.select_num(condition, a, b))
    }
    /// The truth values, exchanged where `condition` holds.
    #[inline(always)]
    fn exchange_bit(self, condition: Self::Bit, a: Self::Bit, b: Self::Bit) -> (Self::Bit, Self::Bit) {
        (self.select_bit(condition, b, a), self.select_bit(condition, a, b))
    }
    /// The words, exchanged where `condition` holds.
    #[inline(always)]
    fn exchange_word(self, condition: Self::Bit, a: Self::Word, b: Self::Word) -> (Self::Word, Self::Word) {
        (self.select_word(condition, b, a), self.select_word(condition, a, b))
    }
    /// A part of an operation that is the same for each of several things.
    #[inline(always)]
    fn alike<A: Alike, const N: usize>(
        self,
        part: &A,
        shared: &Of<A::Shared, Self>,
        each: &[Of<A::Each, Self>; N],
    ) -> [Of<A::Answer, Self>; N] {
        part.run(self, shared, each)
    }

    /// +0.0.
    fn zero(self) -> Num<Self> {
        Num::new(self, self.constant(0.0))
    }
    /// +∞.
    fn infinity(self) -> Num<Self> {
        Num::new(self, self.constant(f32::INFINITY))
    }
    /// A constant truth value, as a handle.
    fn bit(self, value: bool) -> Bit<Self> {
        Bit::new(self, self.constant_bit(value))
    }
    /// A constant word, as a handle.
    fn word<const W: u32>(self, value: u32) -> Word<Self, W> {
        Word::new(self, self.constant_word(W, value))
    }
}

/// What a comparison can answer; every relation with a NaN but `Unordered` is false.
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

/// What can be read from a number's sign and class alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Test {
    /// The sign bit; −0 and −∞ have it, a NaN may.
    SignBit,
    /// +0 or −0.
    Zero,
    /// Not a number.
    Nan,
    /// ≥ 0: either zero counts, a NaN does not.
    AtLeastZero,
    /// > 0: a zero and a NaN do not count.
    AboveZero,
    /// ≤ 0: either zero counts, a NaN does not.
    AtMostZero,
    /// < 0: a zero and a NaN do not count.
    BelowZero,
}
