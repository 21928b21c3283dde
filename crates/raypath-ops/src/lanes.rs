//! Operations over SIMD lanes: one instruction computes the same number of several jobs.

use crate::circuit::{Circuit, Relation, Test};
use fearless_simd::prelude::*;
use fearless_simd::{Select, Simd, f32x4, mask32x4, u32x4};
use std::fmt;
use std::marker::PhantomData;

/// Binary32 numbers side by side in SIMD registers: what a job computes over [`Binary32`](crate::Binary32), each lane
/// computes, bit for bit but for the signs and payloads of NaNs.
///
/// `S` is the proof that the machine has the instructions, `W` says how many lanes a register has. Code over it must be
/// inlined into a function that has those instructions: call it inside [`Simd::vectorize`] or
/// [`fearless_simd::dispatch`].
#[derive(Clone, Copy)]
pub struct Lanes<S, W = Native> {
    simd: S,
    width: PhantomData<W>,
}

/// How many lanes there are.
pub trait Width<S: Simd>: 'static {
    /// A register of numbers.
    type Nums: SimdFloat<S, Element = f32, Mask = Self::Bits>;
    /// A register of words.
    type Words: SimdInt<S, Element = u32, Mask = Self::Bits>;
    /// A register of truth values.
    type Bits: SimdMask<S> + Select<Self::Nums> + Select<Self::Words>;
}

/// As many lanes as the machine's registers have.
#[derive(Debug, Clone, Copy)]
pub struct Native;

/// Four lanes.
#[derive(Debug, Clone, Copy)]
pub struct Four;

/// What a lane circuit computes with. Equality is of no use to it: it holds for no two.
#[derive(Clone, Copy)]
pub struct Row<T>(pub T);

impl<S: Simd> Width<S> for Native {
    type Nums = S::f32s;
    type Words = S::u32s;
    type Bits = S::mask32s;
}

impl<S: Simd> Width<S> for Four {
    type Nums = f32x4<S>;
    type Words = u32x4<S>;
    type Bits = mask32x4<S>;
}

impl<S: Simd, W: Width<S>> Lanes<S, W> {
    /// How many lanes there are.
    pub const COUNT: usize = W::Nums::LEN;

    /// The circuit over the instructions of `simd`.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        Self { simd, width: PhantomData }
    }

    /// The proof that the machine has the instructions.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }
}

impl<S: Simd, W: Width<S>> Circuit for Lanes<S, W>
where
    Self: Copy,
{
    type Num = Row<W::Nums>;
    type Bit = Row<W::Bits>;
    type Word = Row<W::Words>;
    type Order = (Row<W::Nums>, Row<W::Nums>);

    #[inline(always)]
    fn constant(self, value: f32) -> Self::Num {
        Row(W::Nums::simd_from(self.simd, value))
    }
    #[inline(always)]
    fn add(self, a: Self::Num, b: Self::Num) -> Self::Num {
        Row(a.0 + b.0)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Num, b: Self::Num) -> Self::Num {
        Row(a.0 - b.0)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Num, b: Self::Num) -> Self::Num {
        Row(a.0 * b.0)
    }
    #[inline(always)]
    fn negate(self, a: Self::Num) -> Self::Num {
        Row(-a.0)
    }
    #[inline(always)]
    fn compare(self, a: Self::Num, b: Self::Num) -> Self::Order {
        (a, b)
    }
    #[inline(always)]
    fn relation(self, (a, b): Self::Order, relation: Relation) -> Self::Bit {
        Row(match relation {
            Relation::Less => a.0.simd_lt(b.0),
            Relation::LessOrEqual => a.0.simd_le(b.0),
            Relation::Equal => a.0.simd_eq(b.0),
            Relation::GreaterOrEqual => a.0.simd_ge(b.0),
            Relation::Greater => a.0.simd_gt(b.0),
        })
    }
    #[inline(always)]
    fn test(self, test: Test, a: Self::Num) -> Self::Bit {
        let zero = self.constant(0.0).0;
        Row(match test {
            Test::SignBit => a.0.is_sign_negative(),
            Test::Zero => a.0.simd_eq(zero),
            Test::Nan => a.0.is_nan(),
            Test::AtLeastZero => a.0.simd_ge(zero),
            Test::AboveZero => a.0.simd_gt(zero),
        })
    }

    #[inline(always)]
    fn constant_bit(self, value: bool) -> Self::Bit {
        Row(W::Bits::splat(self.simd, value))
    }
    #[inline(always)]
    fn and(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        Row(a.0 & b.0)
    }
    #[inline(always)]
    fn or(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        Row(a.0 | b.0)
    }
    #[inline(always)]
    fn not(self, a: Self::Bit) -> Self::Bit {
        Row(!a.0)
    }

    #[inline(always)]
    fn constant_word(self, _width: u32, value: u32) -> Self::Word {
        Row(W::Words::simd_from(self.simd, value))
    }
    #[inline(always)]
    fn word_equal(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        Row(a.0.simd_eq(b.0))
    }
    #[inline(always)]
    fn word_less(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        Row(a.0.simd_lt(b.0))
    }

    #[inline(always)]
    fn select_num(self, condition: Self::Bit, if_true: Self::Num, if_false: Self::Num) -> Self::Num {
        Row(condition.0.select(if_true.0, if_false.0))
    }
    #[inline(always)]
    fn select_bit(self, condition: Self::Bit, if_true: Self::Bit, if_false: Self::Bit) -> Self::Bit {
        Row((condition.0 & if_true.0) | (!condition.0 & if_false.0))
    }
    #[inline(always)]
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word {
        Row(condition.0.select(if_true.0, if_false.0))
    }
}

impl<S: Simd, W: Width<S>> fmt::Debug for Lanes<S, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} lanes of {:?}", Self::COUNT, self.simd.level())
    }
}

impl<S, W> PartialEq for Lanes<S, W> {
    /// There is one of each type.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T> fmt::Debug for Row<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("lanes")
    }
}

impl<T> PartialEq for Row<T> {
    fn eq(&self, _: &Self) -> bool {
        false
    }
}
