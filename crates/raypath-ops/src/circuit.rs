//! What an operation may do with numbers, bits and words, and the handles that it does it with.
//!
//! A new interpretation of all operations is one implementation of [`Circuit`]. Handles carry their circuit, so that
//! arithmetic reads as arithmetic: `(bound - origin) * inv`.

use crate::alike::{Alike, Of};
use crate::bundle::Bundle;
use crate::rules::{self, Place};
use std::fmt::{Arguments, Debug};
use std::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Sub};

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

/// A number of a circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Num<C: Circuit> {
    pub(crate) circuit: C,
    pub(crate) value: C::Num,
}

/// A truth value of a circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bit<C: Circuit> {
    pub(crate) circuit: C,
    pub(crate) value: C::Bit,
}

/// An unsigned word of `W` bits (1 to 32).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Word<C: Circuit, const W: u32> {
    pub(crate) circuit: C,
    pub(crate) value: C::Word,
}

/// `N` truth values (1 to 64) that travel as one port of `N` bits; element `i` is bit `i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flags<C: Circuit, const N: usize>(pub [Bit<C>; N]);

/// The outcome of one comparison of two numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order<C: Circuit> {
    circuit: C,
    value: C::Order,
}

/// What a multiplexer can choose between.
pub trait Select<C: Circuit>: Copy {
    /// `if_true` where `condition` holds, else `if_false`.
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self;

    /// The two, exchanged where `condition` holds.
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self);
}

impl<C: Circuit> Num<C> {
    /// A handle on `value`.
    pub fn new(circuit: C, value: C::Num) -> Self {
        Self { circuit, value }
    }

    /// What the circuit knows it by.
    pub fn value(self) -> C::Num {
        self.value
    }

    /// Compares with `other`: one comparator, however many relations are read from it.
    #[inline(always)]
    pub fn compare(self, other: Self) -> Order<C> {
        Order { circuit: self.circuit, value: self.circuit.compare(self.value, other.value) }
    }

    /// The larger of the two; the other where one is NaN; `other` where they are equal.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.larger(self.value, other.value))
    }

    /// The smaller of the two; the other where one is NaN; `other` where they are equal.
    #[inline(always)]
    pub fn smaller(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.smaller(self.value, other.value))
    }

    /// The sign bit; unspecified for a NaN.
    #[inline(always)]
    pub fn sign_bit(self) -> Bit<C> {
        self.test(Test::SignBit)
    }

    /// Whether it is +0 or −0.
    #[inline(always)]
    pub fn is_zero(self) -> Bit<C> {
        self.test(Test::Zero)
    }

    /// Whether it is a NaN.
    #[inline(always)]
    pub fn is_nan(self) -> Bit<C> {
        self.test(Test::Nan)
    }

    /// Whether it is ≥ 0 (a NaN is not).
    #[inline(always)]
    pub fn is_at_least_zero(self) -> Bit<C> {
        self.test(Test::AtLeastZero)
    }

    /// Whether it is > 0 (a NaN is not).
    #[inline(always)]
    pub fn is_above_zero(self) -> Bit<C> {
        self.test(Test::AboveZero)
    }

    /// Whether it is ≤ 0 (a NaN is not).
    #[inline(always)]
    pub fn is_at_most_zero(self) -> Bit<C> {
        self.test(Test::AtMostZero)
    }

    /// Whether it is < 0 (a NaN is not).
    #[inline(always)]
    pub fn is_below_zero(self) -> Bit<C> {
        self.test(Test::BelowZero)
    }

    #[inline(always)]
    fn test(self, test: Test) -> Bit<C> {
        Bit::new(self.circuit, self.circuit.test(test, self.value))
    }
}

impl<C: Circuit> Order<C> {
    /// a < b
    #[inline(always)]
    pub fn less(self) -> Bit<C> {
        self.relation(Relation::Less)
    }

    /// a ≤ b
    #[inline(always)]
    pub fn less_or_equal(self) -> Bit<C> {
        self.relation(Relation::LessOrEqual)
    }

    /// a = b
    #[inline(always)]
    pub fn equal(self) -> Bit<C> {
        self.relation(Relation::Equal)
    }

    /// a ≥ b
    #[inline(always)]
    pub fn greater_or_equal(self) -> Bit<C> {
        self.relation(Relation::GreaterOrEqual)
    }

    /// a > b
    #[inline(always)]
    pub fn greater(self) -> Bit<C> {
        self.relation(Relation::Greater)
    }

    #[inline(always)]
    fn relation(self, relation: Relation) -> Bit<C> {
        Bit::new(self.circuit, self.circuit.relation(self.value, relation))
    }
}

impl<C: Circuit> Bit<C> {
    /// A handle on `value`.
    pub fn new(circuit: C, value: C::Bit) -> Self {
        Self { circuit, value }
    }

    /// What the circuit knows it by.
    pub fn value(self) -> C::Bit {
        self.value
    }

    /// `if_true` where it holds, else `if_false`.
    #[inline(always)]
    pub fn select<T: Select<C>>(self, if_true: T, if_false: T) -> T {
        T::select(self, if_true, if_false)
    }

    /// The two, exchanged where it holds.
    #[inline(always)]
    pub fn exchange<T: Select<C>>(self, a: T, b: T) -> (T, T) {
        T::exchange(self, a, b)
    }

    /// Both or neither.
    #[inline(always)]
    pub fn same_as(self, other: Self) -> Self {
        self.select(other, !other)
    }
}

impl<C: Circuit, const W: u32> Word<C, W> {
    /// A handle on `value`.
    pub fn new(circuit: C, value: C::Word) -> Self {
        Self { circuit, value }
    }

    /// What the circuit knows it by.
    pub fn value(self) -> C::Word {
        self.value
    }

    /// Its value as a number, exact: the circuit's format must have every value of a word of `W` bits, 16 at most.
    #[inline(always)]
    pub fn number(self) -> Num<C> {
        const { assert!(W <= 16, "a word of at most 16 bits becomes a number") };
        Num::new(self.circuit, self.circuit.number_of(W, self.value))
    }

    /// Whether it equals a constant.
    #[inline(always)]
    pub fn is(self, value: u32) -> Bit<C> {
        Bit::new(self.circuit, self.circuit.word_equal(self.value, self.circuit.constant_word(W, value)))
    }

    /// Whether it is less than `other`, unsigned.
    #[inline(always)]
    pub fn less(self, other: Self) -> Bit<C> {
        Bit::new(self.circuit, self.circuit.word_less(self.value, other.value))
    }
}

impl<C: Circuit> Add for Num<C> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.add(self.value, other.value))
    }
}

impl<C: Circuit> Sub for Num<C> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.subtract(self.value, other.value))
    }
}

impl<C: Circuit> Mul for Num<C> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.multiply(self.value, other.value))
    }
}

impl<C: Circuit> Neg for Num<C> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.circuit, self.circuit.negate(self.value))
    }
}

impl<C: Circuit> BitAnd for Bit<C> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.and(self.value, other.value))
    }
}

impl<C: Circuit> BitOr for Bit<C> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self::new(self.circuit, self.circuit.or(self.value, other.value))
    }
}

impl<C: Circuit> Not for Bit<C> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self::new(self.circuit, self.circuit.not(self.value))
    }
}

impl<C: Circuit> Select<C> for Num<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_num(condition.value, if_true.value, if_false.value))
    }

    #[inline(always)]
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self) {
        let c = condition.circuit;
        let (a, b) = c.exchange_num(condition.value, a.value, b.value);
        (Self::new(c, a), Self::new(c, b))
    }
}

impl<C: Circuit> Select<C> for Bit<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_bit(condition.value, if_true.value, if_false.value))
    }

    #[inline(always)]
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self) {
        let c = condition.circuit;
        let (a, b) = c.exchange_bit(condition.value, a.value, b.value);
        (Self::new(c, a), Self::new(c, b))
    }
}

impl<C: Circuit, const W: u32> Select<C> for Word<C, W> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_word(condition.value, if_true.value, if_false.value))
    }

    #[inline(always)]
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self) {
        let c = condition.circuit;
        let (a, b) = c.exchange_word(condition.value, a.value, b.value);
        (Self::new(c, a), Self::new(c, b))
    }
}
