//! Arithmetic in SIMD lanes: one instruction computes the same value of several jobs.

use crate::packed::sum_of;
use crate::rounding::{Exact, LaneRounding};
use fearless_simd::prelude::*;
use fearless_simd::{Select, Simd, f32x4, i32x4, mask32x4, u8x16, u32x4};
use raypath_ops::{Binary32, Circuit, Direction, Narrowing, Relation, Single, Test};
use std::fmt;
use std::marker::PhantomData;

/// Binary32 arithmetic in SIMD registers. Each lane computes what [`Binary32`](raypath_ops::Binary32) computes, bit for
/// bit except for the signs and payloads of NaNs.
///
/// `S` is the instruction set, and a value of it proves that the machine has it. `W` is the number of lanes in a
/// register, `R` the format to which results are rounded. Code over this circuit must be inlined into a function that
/// is compiled for the instruction set: call it inside [`Simd::vectorize`] or [`dispatch`](crate::dispatch).
#[derive(Clone, Copy)]
pub struct Lanes<S, W = Native, R = Exact> {
    simd: S,
    width: PhantomData<W>,
    rounding: R,
}

/// The register types for a number of lanes.
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

/// As many lanes as the registers of the instruction set have.
#[derive(Debug, Clone, Copy)]
pub struct Native;

/// Four lanes.
#[derive(Debug, Clone, Copy)]
pub struct Four;

/// A register of a lane circuit. No two are equal: [`Circuit`] requires an equality that lanes do not need.
#[derive(Clone, Copy)]
pub struct Register<T>(pub T);

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
    /// The circuit over the instruction set `simd`.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        Self::rounded(simd, Exact)
    }
}

impl<S: Simd, W: Width<S>, R: LaneRounding<S, W>> Lanes<S, W, R> {
    /// The number of lanes.
    pub const COUNT: usize = W::Nums::LEN;

    /// The circuit over the instruction set `simd` that rounds results.
    #[inline(always)]
    pub fn rounded(simd: S, rounding: R) -> Self {
        Self { simd, width: PhantomData, rounding }
    }

    /// Numbers of binary32, rounded.
    #[inline(always)]
    pub(crate) fn round(self, x: W::Nums) -> Register<W::Nums> {
        Register(self.rounding.round(self.simd, x))
    }

    /// The instruction set.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// `a` if it is greater, else `b`; so `b` if either is NaN or they are equal.
    #[inline(always)]
    pub(crate) fn greater(self, a: W::Nums, b: W::Nums) -> W::Nums {
        // This is the result of x86's MAXPS, but not of other machines' maximum.
        if X86 { a.max(b) } else { a.simd_gt(b).select(a, b) }
    }

    /// `a` if it is less, else `b`; so `b` if either is NaN or they are equal.
    #[inline(always)]
    pub(crate) fn lesser(self, a: W::Nums, b: W::Nums) -> W::Nums {
        if X86 { a.min(b) } else { a.simd_lt(b).select(a, b) }
    }

    /// The registers `(a, b)`, exchanged in the lanes in which `condition` holds.
    #[inline(always)]
    pub(crate) fn exchange<T: Copy + Bytes<Bytes = W::Bytes>>(&self, condition: W::Bits, a: T, b: T) -> (T, T)
    where
        W::Bits: Select<T>,
    {
        // Without AVX-512 each selection takes up to three x86 instructions; these are four for both.
        if X86 && self.simd.level().as_avx512().is_none() {
            let (a, b, ones) = (a.bitcast::<W::Ints>(), b.bitcast::<W::Ints>(), condition.to_vector());
            let change = (a ^ b) & ones;
            ((a ^ change).bitcast(), (b ^ change).bitcast())
        } else {
            (condition.select(b, a), condition.select(a, b))
        }
    }
}

const SIGN: u32 = 1 << 31;

const TWO_TO_23: f32 = 8_388_608.0;

const X86: bool = cfg!(any(target_arch = "x86", target_arch = "x86_64"));

impl<S: Simd, W: Width<S>, R: LaneRounding<S, W>> Circuit for Lanes<S, W, R>
where
    Self: Copy,
{
    type Num = Register<W::Nums>;
    type Bit = Register<W::Bits>;
    type Word = Register<W::Words>;
    type Order = (Register<W::Nums>, Register<W::Nums>);

    #[inline(always)]
    fn constant(self, value: f32) -> Self::Num {
        self.round(W::Nums::simd_from(self.simd, value))
    }
    #[inline(always)]
    fn ulps(self, ulps: u32) -> Self::Num {
        self.constant(ulps as f32 * self.rounding.ulp_of_one())
    }
    #[inline(always)]
    fn add(self, a: Self::Num, b: Self::Num) -> Self::Num {
        self.round(a.0 + b.0)
    }
    /// Lane by lane, in integers. Right in binary32 alone, as [`narrow`](Circuit::narrow) and `number_of` are.
    #[inline(always)]
    fn sum(self, terms: &[Self::Num]) -> Self::Num {
        let mut sum = self.constant(0.0).0;
        for (lane, sum) in sum.as_mut_slice().iter_mut().enumerate() {
            *sum = sum_of(terms.iter().map(|term| term.0.as_slice()[lane]));
        }
        Register(sum)
    }
    #[inline(always)]
    fn subtract(self, a: Self::Num, b: Self::Num) -> Self::Num {
        self.round(a.0 - b.0)
    }
    #[inline(always)]
    fn multiply(self, a: Self::Num, b: Self::Num) -> Self::Num {
        Register(self.rounding.multiply(self.simd, a.0, b.0))
    }
    /// Lane by lane. Right in binary32 alone.
    #[inline(always)]
    fn residue(self, product: Self::Num, a: Self::Num, b: Self::Num) -> Self::Word {
        let mut words = self.constant_word(32, 0).0;
        for (lane, word) in words.as_mut_slice().iter_mut().enumerate() {
            let [product, a, b] = [product, a, b].map(|register| Single(register.0.as_slice()[lane]));
            *word = Binary32.residue(product, a, b);
        }
        Register(words)
    }
    #[inline(always)]
    fn negate(self, a: Self::Num) -> Self::Num {
        Register(-a.0)
    }
    #[inline(always)]
    fn narrow(self, a: Self::Num, to: Narrowing) -> Self::Num {
        // As in `native_numbers`: codes of magnitudes are in the order of the magnitudes.
        let word = |code: u32| W::Words::simd_from(self.simd, code);
        let (code, sign) = (a.0.bitcast::<W::Words>() & word(!SIGN), a.0.bitcast::<W::Words>() & word(SIGN));
        let low = (1 << (f32::MANTISSA_DIGITS - to.bits)) - 1;
        let infinity = word(f32::INFINITY.to_bits());
        let least_kept = 2 * f32::MIN_POSITIVE.to_bits();
        let (moved, small) = match to.direction {
            Direction::TowardZero => (code - word(to.margin), code.simd_lt(word(least_kept + to.margin))),
            Direction::AwayFromZero => {
                let moved = code + word(to.margin + low);
                (moved, moved.simd_lt(word(least_kept)))
            }
        };
        let rounded = moved & word(!low);
        let finite = rounded.simd_lt(infinity).select(rounded, infinity);
        let kept = small.select(word(0), finite);
        Register((code.simd_lt(infinity).select(kept, code) | sign).bitcast::<W::Nums>())
    }
    #[inline(always)]
    fn compare(self, a: Self::Num, b: Self::Num) -> Self::Order {
        (a, b)
    }
    #[inline(always)]
    fn relation(self, (a, b): Self::Order, relation: Relation) -> Self::Bit {
        Register(match relation {
            Relation::Less => a.0.simd_lt(b.0),
            Relation::LessOrEqual => a.0.simd_le(b.0),
            Relation::Equal => a.0.simd_eq(b.0),
            Relation::GreaterOrEqual => a.0.simd_ge(b.0),
            Relation::Greater => a.0.simd_gt(b.0),
        })
    }
    #[inline(always)]
    fn number_of(self, _width: u32, word: Self::Word) -> Self::Num {
        // The word becomes the fraction of a number from 2^23 on, whose unit in the last place is 1.
        let above = (word.0 | self.constant_word(32, TWO_TO_23.to_bits()).0).bitcast::<W::Nums>();
        Register(above - self.constant(TWO_TO_23).0)
    }
    #[inline(always)]
    fn test(self, test: Test, a: Self::Num) -> Self::Bit {
        let zero = self.constant(0.0).0;
        Register(match test {
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
        Register(W::Bits::splat(self.simd, value))
    }
    #[inline(always)]
    fn and(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        Register(a.0 & b.0)
    }
    #[inline(always)]
    fn or(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        Register(a.0 | b.0)
    }
    #[inline(always)]
    fn not(self, a: Self::Bit) -> Self::Bit {
        Register(!a.0)
    }

    #[inline(always)]
    fn constant_word(self, _width: u32, value: u32) -> Self::Word {
        Register(W::Words::simd_from(self.simd, value))
    }
    #[inline(always)]
    fn word_equal(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        Register(a.0.simd_eq(b.0))
    }
    #[inline(always)]
    fn word_less(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        Register(a.0.simd_lt(b.0))
    }

    #[inline(always)]
    fn select_num(self, condition: Self::Bit, if_true: Self::Num, if_false: Self::Num) -> Self::Num {
        Register(condition.0.select(if_true.0, if_false.0))
    }
    #[inline(always)]
    fn select_bit(self, condition: Self::Bit, if_true: Self::Bit, if_false: Self::Bit) -> Self::Bit {
        Register(if_false.0 ^ (condition.0 & (if_true.0 ^ if_false.0)))
    }
    #[inline(always)]
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word {
        Register(condition.0.select(if_true.0, if_false.0))
    }
}

impl<S: Simd, W: Width<S>, R: LaneRounding<S, W>> fmt::Debug for Lanes<S, W, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} lanes of {:?}", Self::COUNT, self.simd.level())
    }
}

impl<S, W, R> PartialEq for Lanes<S, W, R> {
    /// All values of one type are equal.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T> fmt::Debug for Register<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("register")
    }
}

impl<T> PartialEq for Register<T> {
    fn eq(&self, _: &Self) -> bool {
        false
    }
}
