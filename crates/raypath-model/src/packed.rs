//! Blocks of sixteen jobs, field by field: the memory layout of batches.

use crate::lanes::{Lanes, Native, Register, Width};
use crate::rounding::{Exact, LaneRounding};
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use raypath_ops::{
    Binary32, Bit, Circuit, Gather, Layout, Narrowing, Num, Put, Relation, Scatter, Single, Test, Word, array_of,
};

/// A circuit whose values belong to sixteen jobs, each value in one cache line: a `RayBoxInput<Packed>` is sixteen jobs
/// as a structure of arrays. It is a storage format for [`Lanes`]; computing over it directly is correct but slow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Packed;

/// The number of jobs in a block.
pub const BLOCK: usize = 16;

/// One value of each of sixteen jobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(align(64))]
pub struct BlockValue<T>(pub [T; BLOCK]);

/// Loads and stores the jobs of a block that fill one register of [`Lanes`].
#[derive(Clone, Copy)]
pub struct BlockSlice<S, R = Exact> {
    /// The circuit that computes.
    pub lanes: Lanes<S, Native, R>,
    /// The first job: a multiple of the number of lanes.
    pub first: usize,
}

impl<T: Copy> BlockValue<T> {
    fn map<U: Copy>(self, f: impl Fn(T) -> U) -> BlockValue<U> {
        BlockValue(self.0.map(f))
    }

    fn zip<O: Copy, U: Copy>(self, other: BlockValue<O>, f: impl Fn(T, O) -> U) -> BlockValue<U> {
        BlockValue(array_of!(i => f(self.0[i], other.0[i])))
    }
}

impl Circuit for Packed {
    type Num = BlockValue<f32>;
    /// All ones for true, zero for false.
    type Bit = BlockValue<i32>;
    type Word = BlockValue<u32>;
    type Order = (BlockValue<f32>, BlockValue<f32>);

    fn constant(self, value: f32) -> Self::Num {
        BlockValue([value; BLOCK])
    }
    fn ulps(self, ulps: u32) -> Self::Num {
        BlockValue([Binary32.ulps(ulps).0; BLOCK])
    }
    fn add(self, a: Self::Num, b: Self::Num) -> Self::Num {
        a.zip(b, |a, b| a + b)
    }
    fn sum(self, terms: &[Self::Num]) -> Self::Num {
        BlockValue(array_of!(i => sum_of(terms.iter().map(|term| term.0[i]))))
    }
    fn residue(self, _product: Self::Num, a: Self::Num, b: Self::Num) -> Self::Word {
        a.zip(b, |a, b| Binary32.residue(Single(0.0), Single(a), Single(b)))
    }
    fn subtract(self, a: Self::Num, b: Self::Num) -> Self::Num {
        a.zip(b, |a, b| a - b)
    }
    fn multiply(self, a: Self::Num, b: Self::Num) -> Self::Num {
        a.zip(b, |a, b| a * b)
    }
    fn negate(self, a: Self::Num) -> Self::Num {
        a.map(|a| -a)
    }
    fn narrow(self, a: Self::Num, to: Narrowing) -> Self::Num {
        a.map(|a| Binary32.narrow(Single(a), to).0)
    }
    fn compare(self, a: Self::Num, b: Self::Num) -> Self::Order {
        (a, b)
    }
    fn relation(self, (a, b): Self::Order, relation: Relation) -> Self::Bit {
        a.zip(b, |a, b| mask(Binary32.relation((a, b), relation)))
    }
    fn number_of(self, _width: u32, word: Self::Word) -> Self::Num {
        word.map(|word| word as f32)
    }
    fn test(self, test: Test, a: Self::Num) -> Self::Bit {
        a.map(|a| mask(Binary32.test(test, Single(a))))
    }
    fn constant_bit(self, value: bool) -> Self::Bit {
        BlockValue([mask(value); BLOCK])
    }
    fn and(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        a.zip(b, |a, b| a & b)
    }
    fn or(self, a: Self::Bit, b: Self::Bit) -> Self::Bit {
        a.zip(b, |a, b| a | b)
    }
    fn not(self, a: Self::Bit) -> Self::Bit {
        a.map(|a| !a)
    }
    fn constant_word(self, _width: u32, value: u32) -> Self::Word {
        BlockValue([value; BLOCK])
    }
    fn word_equal(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        a.zip(b, |a, b| mask(a == b))
    }
    fn word_less(self, a: Self::Word, b: Self::Word) -> Self::Bit {
        a.zip(b, |a, b| mask(a < b))
    }
    fn select_num(self, condition: Self::Bit, if_true: Self::Num, if_false: Self::Num) -> Self::Num {
        choose(condition, if_true, if_false)
    }
    fn select_bit(self, condition: Self::Bit, if_true: Self::Bit, if_false: Self::Bit) -> Self::Bit {
        choose(condition, if_true, if_false)
    }
    fn select_word(self, condition: Self::Bit, if_true: Self::Word, if_false: Self::Word) -> Self::Word {
        choose(condition, if_true, if_false)
    }
}

/// The sum of binary32 numbers, rounded once.
pub(crate) fn sum_of(terms: impl ExactSizeIterator<Item = f32> + Clone) -> f32 {
    f32::from_bits(Layout::BINARY32.sum(terms.map(|term| term.to_bits().into())) as u32)
}

fn mask(bit: bool) -> i32 {
    -i32::from(bit)
}

fn choose<T: Copy>(condition: BlockValue<i32>, if_true: BlockValue<T>, if_false: BlockValue<T>) -> BlockValue<T> {
    BlockValue(array_of!(i => if condition.0[i] == 0 { if_false.0[i] } else { if_true.0[i] }))
}

/// Packs sixteen jobs into a block.
impl Gather<Binary32, Packed, BLOCK> for Packed {
    #[inline]
    fn num(&self, values: [&Num<Binary32>; BLOCK]) -> Num<Packed> {
        Num::new(Packed, BlockValue(values.map(|num| num.value.0)))
    }
    #[inline]
    fn bit(&self, values: [&Bit<Binary32>; BLOCK]) -> Bit<Packed> {
        Bit::new(Packed, BlockValue(values.map(|bit| mask(bit.value))))
    }
    #[inline]
    fn word<const W: u32>(&self, values: [&Word<Binary32, W>; BLOCK]) -> Word<Packed, W> {
        Word::new(Packed, BlockValue(values.map(|word| word.value)))
    }
}

/// Unpacks a block into sixteen jobs.
impl Scatter<Packed, Binary32, BLOCK> for Packed {
    #[inline]
    fn num(&self, value: Num<Packed>) -> [Num<Binary32>; BLOCK] {
        value.value.0.map(|num| Num::new(Binary32, Single(num)))
    }
    #[inline]
    fn bit(&self, value: Bit<Packed>) -> [Bit<Binary32>; BLOCK] {
        value.value.0.map(|ones| Bit::new(Binary32, ones != 0))
    }
    #[inline]
    fn word<const W: u32>(&self, value: Word<Packed, W>) -> [Word<Binary32, W>; BLOCK] {
        value.value.0.map(|word| Word::new(Binary32, word))
    }
}

type Nums<S> = <Native as Width<S>>::Nums;
type Words<S> = <Native as Width<S>>::Words;
type Bits<S> = <Native as Width<S>>::Bits;
type Ints<S> = <Bits<S> as SimdMask<S>>::Ints;

/// Loads jobs of a block into registers.
impl<S: Simd, R: LaneRounding<S, Native>> Gather<Packed, Lanes<S, Native, R>, 1> for BlockSlice<S, R> {
    #[inline(always)]
    fn num(&self, [value]: [&Num<Packed>; 1]) -> Num<Lanes<S, Native, R>> {
        let (first, count) = (self.first, Lanes::<S>::COUNT);
        let numbers = Nums::<S>::from_slice(self.lanes.simd(), &value.value.0[first..first + count]);
        Num::new(self.lanes, self.lanes.round(numbers))
    }
    #[inline(always)]
    fn bit(&self, [value]: [&Bit<Packed>; 1]) -> Bit<Lanes<S, Native, R>> {
        let (first, count) = (self.first, Lanes::<S>::COUNT);
        let ones = Ints::<S>::from_slice(self.lanes.simd(), &value.value.0[first..first + count]);
        Bit::new(self.lanes, Register(Bits::<S>::from_vector(ones)))
    }
    #[inline(always)]
    fn word<const W: u32>(&self, [value]: [&Word<Packed, W>; 1]) -> Word<Lanes<S, Native, R>, W> {
        let (first, count) = (self.first, Lanes::<S>::COUNT);
        let words = Words::<S>::from_slice(self.lanes.simd(), &value.value.0[first..first + count]);
        Word::new(self.lanes, Register(words))
    }
}

/// Stores registers into jobs of a block.
impl<S: Simd, R: LaneRounding<S, Native>> Put<Lanes<S, Native, R>, Packed> for BlockSlice<S, R> {
    #[inline(always)]
    fn num(&self, value: &Num<Lanes<S, Native, R>>, target: &mut Num<Packed>) {
        value.value.0.store_slice(&mut target.value.0[self.first..self.first + Lanes::<S>::COUNT]);
    }
    #[inline(always)]
    fn bit(&self, value: &Bit<Lanes<S, Native, R>>, target: &mut Bit<Packed>) {
        value.value.0.to_vector().store_slice(&mut target.value.0[self.first..self.first + Lanes::<S>::COUNT]);
    }
    #[inline(always)]
    fn word<const W: u32>(&self, value: &Word<Lanes<S, Native, R>, W>, target: &mut Word<Packed, W>) {
        value.value.0.store_slice(&mut target.value.0[self.first..self.first + Lanes::<S>::COUNT]);
    }
}
