//! Operations over SIMD lanes: one instruction computes the same number of several jobs.

use crate::binary32::Binary32;
use crate::circuit::{Circuit, Relation, Test};
use crate::handle::{Bit, Num, Word};
use crate::rules::{self, Place};
use fearless_simd::prelude::*;
use fearless_simd::{Select, Simd, f32x4, i32x4, mask32x4, u8x16, u32x4};
use std::fmt::{self, Arguments};
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
    type Nums: SimdFloat<S, Element = f32, Mask = Self::Bits, ByteVector = Self::Bytes>;
    /// A register of words.
    type Words: SimdInt<S, Element = u32, Mask = Self::Bits, ByteVector = Self::Bytes>;
    /// A register of truth values as words, zeros or ones.
    type Ints: SimdInt<S, Element = i32, Mask = Self::Bits, ByteVector = Self::Bytes>;
    /// A register of truth values.
    type Bits: SimdMask<S, Ints = Self::Ints> + Select<Self::Nums> + Select<Self::Words> + Select<Self::Ints>;
    /// A register as bytes.
    type Bytes: SimdBase<S, Element = u8, ByteVector = Self::Bytes>;
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
    type Ints = S::i32s;
    type Bits = S::mask32s;
    type Bytes = S::u8s;
}

impl<S: Simd> Width<S> for Four {
    type Nums = f32x4<S>;
    type Words = u32x4<S>;
    type Ints = i32x4<S>;
    type Bits = mask32x4<S>;
    type Bytes = u8x16<S>;
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

    /// `a` where it is greater, else `b`: `b` too where either is NaN, and where they are equal.
    #[inline(always)]
    fn greater(self, a: W::Nums, b: W::Nums) -> W::Nums {
        // That is what x86's MAXPS answers, and no other machine's maximum.
        if X86 { a.max(b) } else { a.simd_gt(b).select(a, b) }
    }

    /// `a` where it is less, else `b`: `b` too where either is NaN, and where they are equal.
    #[inline(always)]
    fn lesser(self, a: W::Nums, b: W::Nums) -> W::Nums {
        if X86 { a.min(b) } else { a.simd_lt(b).select(a, b) }
    }

    /// Distances and keys in two places, exchanged where the second comes before the first.
    #[inline(always)]
    fn compare_and_swap(&self, boxes: &mut [(W::Nums, W::Ints); 4], i: usize, j: usize) {
        let ((a, a_key), (b, b_key)) = (boxes[i], boxes[j]);
        let swap = b.simd_lt(a) | (b.simd_eq(a) & b_key.simd_lt(a_key));
        let ((a, b), (a_key, b_key)) = (self.exchange(swap, a, b), self.exchange(swap, a_key, b_key));
        (boxes[i], boxes[j]) = ((a, a_key), (b, b_key));
    }

    /// Two registers, exchanged where `condition` holds.
    #[inline(always)]
    fn exchange<T: Copy + Bytes<Bytes = W::Bytes>>(&self, condition: W::Bits, a: T, b: T) -> (T, T)
    where
        W::Bits: Select<T>,
    {
        // Before AVX-512, x86's choices take up to three instructions each; these are four for both.
        if X86 && self.simd.level().as_avx512().is_none() {
            let (a, b, ones) = (a.bitcast::<W::Ints>(), b.bitcast::<W::Ints>(), condition.to_vector());
            let change = (a ^ b) & ones;
            ((a ^ change).bitcast(), (b ^ change).bitcast())
        } else {
            (condition.select(b, a), condition.select(a, b))
        }
    }
}

/// Set in the key of a box that is missed, above its index.
const MISSES: i32 = 4;

const TWO_TO_23: f32 = 8_388_608.0;

const X86: bool = cfg!(any(target_arch = "x86", target_arch = "x86_64"));

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
    fn one_plus_ulps(self, ulps: u32) -> Self::Num {
        self.constant(Binary32.one_plus_ulps(ulps).0)
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
    fn number_of(self, _width: u32, word: Self::Word) -> Self::Num {
        // Among the numbers from 2^23 on, of which the last fraction bit is worth 1.
        let above = (word.0 | self.constant_word(32, TWO_TO_23.to_bits()).0).bitcast::<W::Nums>();
        Row(above - self.constant(TWO_TO_23).0)
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
            Test::AtMostZero => a.0.simd_le(zero),
            Test::BelowZero => a.0.simd_lt(zero),
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
        Row(if_false.0 ^ (condition.0 & (if_true.0 ^ if_false.0)))
    }
    #[inline(always)]
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word {
        Row(condition.0.select(if_true.0, if_false.0))
    }

    #[inline(always)]
    fn largest_or_zero(self, _name: Arguments<'_>, [x, y, z]: [Num<Self>; 3]) -> Num<Self> {
        // What is second is never NaN, and a zero's place is taken by no other.
        let z0 = self.greater(z.value.0, self.constant(0.0).0);
        Num::new(self, Row(self.greater(x.value.0, self.greater(y.value.0, z0))))
    }
    #[inline(always)]
    fn smallest_or_extent(self, name: Arguments<'_>, numbers: [Num<Self>; 3], extent: Num<Self>) -> Num<Self> {
        if extent.value.0.is_nan().any_true() {
            return rules::smallest_or_extent(self, name, numbers, extent);
        }
        let [x, y, z] = numbers;
        let z_extent = self.lesser(z.value.0, extent.value.0);
        Num::new(self, Row(self.lesser(x.value.0, self.lesser(y.value.0, z_extent))))
    }
    #[inline(always)]
    fn sort(self, boxes: [Place<Self, 2>; 4]) -> [Place<Self, 2>; 4] {
        // Misses and index make one word, which decides ties and moves as one.
        let mut sorted: [(W::Nums, W::Ints); 4] = array_of!(i => {
            let misses = !boxes[i].hit.value.0.to_vector() & MISSES;
            (boxes[i].tmin.value.0, misses | boxes[i].index.value.0.bitcast::<W::Ints>())
        });
        self.compare_and_swap(&mut sorted, 0, 2);
        self.compare_and_swap(&mut sorted, 1, 3);
        self.compare_and_swap(&mut sorted, 0, 1);
        self.compare_and_swap(&mut sorted, 2, 3);
        self.compare_and_swap(&mut sorted, 1, 2);
        array_of!(i => {
            let (tmin, key) = sorted[i];
            Place {
                hit: Bit::new(self, Row(key.simd_lt(MISSES))),
                tmin: Num::new(self, Row(tmin)),
                index: Word::new(self, Row((key & (MISSES - 1)).bitcast())),
            }
        })
    }
    #[inline(always)]
    fn exchange_num(self, condition: Self::Bit, a: Self::Num, b: Self::Num) -> (Self::Num, Self::Num) {
        let (a, b) = self.exchange(condition.0, a.0, b.0);
        (Row(a), Row(b))
    }
    #[inline(always)]
    fn exchange_bit(self, condition: Self::Bit, a: Self::Bit, b: Self::Bit) -> (Self::Bit, Self::Bit) {
        let change = (a.0 ^ b.0) & condition.0;
        (Row(a.0 ^ change), Row(b.0 ^ change))
    }
    #[inline(always)]
    fn exchange_word(self, condition: Self::Bit, a: Self::Word, b: Self::Word) -> (Self::Word, Self::Word) {
        let (a, b) = self.exchange(condition.0, a.0, b.0);
        (Row(a), Row(b))
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
