//! Parts of operations that are the same for each of several things: boxes, lanes.

use crate::binary32::{Binary32, Single};
use crate::circuit::Circuit;
use crate::family::{Family, Gather, Scatter};
use crate::handle::{Bit, Num, Word};
use crate::lanes::{Four, Lanes, Row, Width};
use fearless_simd::Level;
use fearless_simd::prelude::*;

/// Such a part. Whether a circuit computes the things one after another or side by side makes no difference to what
/// they answer.
pub trait Alike {
    /// What all of them take.
    type Shared: Family;
    /// What each of them takes.
    type Each: Family;
    /// What each of them answers.
    type Answer: Family;

    /// Computes `N` of them, stage by stage.
    fn run<C: Circuit, const N: usize>(
        &self,
        c: C,
        shared: &Of<Self::Shared, C>,
        each: &[Of<Self::Each, C>; N],
    ) -> [Of<Self::Answer, C>; N];
}

/// A bundle of a family over a circuit.
pub type Of<F, C> = <F as Family>::Of<C>;

/// Computes `N` things over binary32, four in a register where their number allows it.
#[inline(always)]
pub(crate) fn side_by_side<A: Alike, const N: usize>(
    part: &A,
    shared: &Of<A::Shared, Binary32>,
    each: &[Of<A::Each, Binary32>; N],
) -> [Of<A::Answer, Binary32>; N] {
    let simd = match baseline() {
        Some(simd) if N > 1 => simd,
        _ => return part.run(Binary32, shared, each),
    };
    let lanes = Abreast(Lanes::new(simd));
    let shared = A::Shared::gather([shared; 4], &lanes);
    let answered: [Of<A::Answer, Binary32>; 4] = four(part, &lanes, &shared, each, 0);
    let mut answers = [answered[0]; N];
    answers[1..N.min(4)].copy_from_slice(&answered[1..N.min(4)]);
    for chunk in 1..N.div_ceil(4) {
        let first = 4 * chunk;
        let count = (N - first).min(4);
        answers[first..first + count].copy_from_slice(&four(part, &lanes, &shared, each, first)[..count]);
    }
    answers
}

/// Four things, from the one with this number on; where there are fewer, the last again.
#[inline(always)]
fn four<A: Alike, const N: usize>(
    part: &A,
    lanes: &Abreast,
    shared: &Of<A::Shared, FourLanes>,
    each: &[Of<A::Each, Binary32>; N],
    first: usize,
) -> [Of<A::Answer, Binary32>; 4] {
    let each = A::Each::gather(array_of!(i => &each[(first + i).min(N - 1)]), lanes);
    let [answer] = part.run(lanes.0, shared, &[each]);
    A::Answer::scatter(answer, lanes)
}

type FourLanes = Lanes<Baseline, Four>;
type Nums = <Four as Width<Baseline>>::Nums;
type Bits = <Four as Width<Baseline>>::Bits;
type Ints = <Bits as SimdMask<Baseline>>::Ints;
type Words = <Four as Width<Baseline>>::Words;

/// Four values of binary32, and four lanes.
struct Abreast(FourLanes);

impl Gather<Binary32, FourLanes, 4> for Abreast {
    #[inline(always)]
    fn num(&self, values: [&Num<Binary32>; 4]) -> Num<FourLanes> {
        Num::new(self.0, Row(Nums::simd_from(self.0.simd(), array_of!(i => values[i].value.0))))
    }
    #[inline(always)]
    fn bit(&self, values: [&Bit<Binary32>; 4]) -> Bit<FourLanes> {
        let ones: [i32; 4] = array_of!(i => -i32::from(values[i].value));
        Bit::new(self.0, Row(Bits::from_vector(Ints::simd_from(self.0.simd(), ones))))
    }
    #[inline(always)]
    fn word<const W: u32>(&self, values: [&Word<Binary32, W>; 4]) -> Word<FourLanes, W> {
        Word::new(self.0, Row(Words::simd_from(self.0.simd(), array_of!(i => values[i].value))))
    }
}

impl Scatter<FourLanes, Binary32, 4> for Abreast {
    #[inline(always)]
    fn num(&self, value: Num<FourLanes>) -> [Num<Binary32>; 4] {
        let values = value.value.0.to_array();
        array_of!(i => Num::new(Binary32, Single(values[i])))
    }
    #[inline(always)]
    fn bit(&self, value: Bit<FourLanes>) -> [Bit<Binary32>; 4] {
        let ones: [i32; 4] = value.value.0.to_vector().to_array();
        array_of!(i => Bit::new(Binary32, ones[i] != 0))
    }
    #[inline(always)]
    fn word<const W: u32>(&self, value: Word<FourLanes, W>) -> [Word<Binary32, W>; 4] {
        let values = value.value.0.to_array();
        array_of!(i => Word::new(Binary32, values[i]))
    }
}

/// The instructions that every machine of this architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = fearless_simd::Sse2;
#[cfg(target_arch = "aarch64")]
type Baseline = fearless_simd::Neon;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
type Baseline = fearless_simd::Fallback;

#[inline(always)]
fn baseline() -> Option<Baseline> {
    let level = Level::baseline();
    #[cfg(target_arch = "x86_64")]
    let simd = level.as_sse2();
    #[cfg(target_arch = "aarch64")]
    let simd = level.as_neon();
    // Where lanes are computed one by one there is nothing to gain.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let simd = {
        let _ = level;
        None
    };
    simd
}
