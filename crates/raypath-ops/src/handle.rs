//! Handles on the numbers, bits and words of a circuit. A handle contains its circuit, which allows expressions such as
//! `(bound - origin) * inv`.

use crate::RESIDUE_BITS;
use crate::circuit::{Circuit, Narrowing, Relation, Test};
use std::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Sub};

/// A number of a circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Num<C: Circuit> {
    /// The circuit.
    pub circuit: C,
    /// The circuit's representation.
    pub value: C::Num,
}

/// A truth value of a circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bit<C: Circuit> {
    /// The circuit.
    pub circuit: C,
    /// The circuit's representation.
    pub value: C::Bit,
}

/// An unsigned word of `W` bits (1 to 32).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Word<C: Circuit, const W: u32> {
    /// The circuit.
    pub circuit: C,
    /// The circuit's representation.
    pub value: C::Word,
}

/// `N` truth values (1 to 64) that share one port of `N` bits; element `i` is bit `i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flags<C: Circuit, const N: usize>(pub [Bit<C>; N]);

/// The result of comparing two numbers, from which relations are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order<C: Circuit> {
    circuit: C,
    value: C::Order,
}

/// A value that multiplexers can select.
pub trait Select<C: Circuit>: Copy {
    /// Selects `if_true` if `condition` holds, else `if_false`.
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self;

    /// The pair `(a, b)`, exchanged if `condition` holds.
    #[inline(always)]
    fn exchange(condition: Bit<C>, a: Self, b: Self) -> (Self, Self) {
        (Self::select(condition, b, a), Self::select(condition, a, b))
    }
}

impl<C: Circuit> Num<C> {
    /// A handle on `value`.
    #[inline(always)]
    pub fn new(circuit: C, value: C::Num) -> Self {
        Self { circuit, value }
    }

    /// Compares with `other`. All relations that are read from the result share one comparator.
    #[inline(always)]
    pub fn compare(self, other: Self) -> Order<C> {
        Order { circuit: self.circuit, value: self.circuit.compare(self.value, other.value) }
    }

    /// The larger of two numbers. If one is NaN, the result is the other; if they are equal, `other`.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        (self.compare(other).greater() | other.is_nan()).select(self, other)
    }

    /// The number without its sign.
    #[inline(always)]
    pub fn magnitude(self) -> Self {
        self.sign_bit().select(-self, self)
    }

    /// The number rounded in one direction to a shorter significand.
    #[inline(always)]
    pub fn narrow(self, to: Narrowing) -> Self {
        Self::new(self.circuit, self.circuit.narrow(self.value, to))
    }

    /// The sum of at most 64 terms, rounded once: by [`Circuit::sum`] from three terms on, and by an addition if there
    /// are two.
    #[inline(always)]
    pub fn sum<const N: usize>(terms: [Self; N]) -> Self {
        const { assert!(N >= 1 && N <= 64, "a sum has 1 to 64 terms") };
        match N {
            1 => terms[0],
            2 => terms[0] + terms[1],
            _ => {
                let values: [C::Num; N] = array_of!(i => terms[i].value);
                Self::new(terms[0].circuit, terms[0].circuit.sum(&values))
            }
        }
    }

    /// The residue of this product of `a` and `b` ([`Circuit::residue`]).
    #[inline(always)]
    pub fn residue(self, a: Self, b: Self) -> Word<C, RESIDUE_BITS> {
        Word::new(self.circuit, self.circuit.residue(self.value, a.value, b.value))
    }

    /// The smaller of two numbers. If one is NaN, the result is the other; if they are equal, `other`.
    #[inline(always)]
    pub fn smaller(self, other: Self) -> Self {
        (self.compare(other).less() | other.is_nan()).select(self, other)
    }
}

/// Declares methods of a handle without arguments, which read a bit by a method of the circuit.
macro_rules! bits {
    ($handle:ident, |$circuit:ident, $value:ident, $what:ident| $bit:expr; $($(#[$doc:meta])* $name:ident = $of:expr;)*) => {
        impl<C: Circuit> $handle<C> {
            $(
                $(#[$doc])*
                #[inline(always)]
                pub fn $name(self) -> Bit<C> {
                    let ($circuit, $value, $what) = (self.circuit, self.value, $of);
                    Bit::new($circuit, $bit)
                }
            )*
        }
    };
}

bits! {
    Num, |circuit, value, test| circuit.test(test, value);
    /// The sign bit; unspecified for a NaN.
    sign_bit = Test::SignBit;
    /// Whether the number is +0 or −0.
    is_zero = Test::Zero;
    /// Whether the number is a NaN.
    is_nan = Test::Nan;
    /// Whether the number is ≥ 0 (a NaN is not).
    is_at_least_zero = Test::AtLeastZero;
    /// Whether the number is > 0 (a NaN is not).
    is_above_zero = Test::AboveZero;
    /// Whether the number is ≤ 0 (a NaN is not).
    is_at_most_zero = Test::AtMostZero;
    /// Whether the number is < 0 (a NaN is not).
    is_below_zero = Test::BelowZero;
}

bits! {
    Order, |circuit, value, relation| circuit.relation(value, relation);
    /// a < b
    less = Relation::Less;
    /// a ≤ b
    less_or_equal = Relation::LessOrEqual;
    /// a = b
    equal = Relation::Equal;
    /// a ≥ b
    greater_or_equal = Relation::GreaterOrEqual;
    /// a > b
    greater = Relation::Greater;
}

impl<C: Circuit> Bit<C> {
    /// A handle on `value`.
    #[inline(always)]
    pub fn new(circuit: C, value: C::Bit) -> Self {
        Self { circuit, value }
    }

    /// Selects `if_true` if this bit is set, else `if_false`.
    #[inline(always)]
    pub fn select<T: Select<C>>(self, if_true: T, if_false: T) -> T {
        T::select(self, if_true, if_false)
    }

    /// The pair `(a, b)`, exchanged if this bit is set.
    #[inline(always)]
    pub fn exchange<T: Select<C>>(self, a: T, b: T) -> (T, T) {
        T::exchange(self, a, b)
    }

    /// Whether both bits are set or both are clear.
    #[inline(always)]
    pub fn same_as(self, other: Self) -> Self {
        self.select(other, !other)
    }
}

impl<C: Circuit, const W: u32> Word<C, W> {
    /// A handle on `value`.
    #[inline(always)]
    pub fn new(circuit: C, value: C::Word) -> Self {
        Self { circuit, value }
    }

    /// The word's value as a number. `W` must be at most 16, and every value of `W` bits exact in the circuit's format.
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

/// Implements operators of a handle by methods of the circuit.
macro_rules! operators {
    ($($handle:ident: $operator:ident::$method:ident($($other:ident)?) = $by:ident;)*) => {$(
        impl<C: Circuit> $operator for $handle<C> {
            type Output = Self;
            #[inline(always)]
            fn $method(self $(, $other: Self)?) -> Self {
                Self::new(self.circuit, self.circuit.$by(self.value $(, $other.value)?))
            }
        }
    )*};
}

operators! {
    Num: Add::add(other) = add;
    Num: Sub::sub(other) = subtract;
    Num: Mul::mul(other) = multiply;
    Num: Neg::neg() = negate;
    Bit: BitAnd::bitand(other) = and;
    Bit: BitOr::bitor(other) = or;
    Bit: Not::not() = not;
}

impl<C: Circuit> Select<C> for Num<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_num(condition.value, if_true.value, if_false.value))
    }
}

impl<C: Circuit> Select<C> for Bit<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_bit(condition.value, if_true.value, if_false.value))
    }
}

impl<C: Circuit, const W: u32> Select<C> for Word<C, W> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        let c = condition.circuit;
        Self::new(c, c.select_word(condition.value, if_true.value, if_false.value))
    }
}
