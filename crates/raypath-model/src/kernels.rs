//! Kernels of the paper's operations in SIMD instructions.

use crate::lanes::{Four, Lanes, Register, Width};
use crate::rounding::LaneRounding;
use fearless_simd::Level;
use fearless_simd::prelude::*;
use raypath_ops::{
    Binary32, Bit, Circuit, Concrete, Family, Gather, Kernels, LaneMap, Num, Of, Portable, Scatter, Single, SortEntry,
    Tie, Vec3, Word, array_of,
};
use std::fmt::Arguments;

/// A circuit with the kernels that are fastest over it.
pub trait ModelCircuit: Concrete {
    /// The type of the kernels.
    type Kernels: Kernels<Self>;
    /// The kernels.
    const KERNELS: Self::Kernels;
}

/// The kernels over [`Binary32`] and [`Lanes`]. Over [`Binary32`] they compute four items of a [`LaneMap`] at a time,
/// in the SIMD instructions that every machine of the architecture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SimdKernels;

impl ModelCircuit for Binary32 {
    type Kernels = SimdKernels;
    const KERNELS: SimdKernels = SimdKernels;
}

impl Kernels<Binary32> for SimdKernels {
    #[inline(always)]
    fn tie(
        self,
        c: Binary32,
        ends: (Vec3<Binary32>, Vec3<Binary32>),
        products: (Num<Binary32>, Num<Binary32>),
        difference: Num<Binary32>,
    ) -> Tie<Binary32> {
        if difference.value.0 != 0.0 {
            return Tie { front: c.bit(false), back: c.bit(false) };
        }
        Portable.tie(c, ends, products, difference)
    }

    #[inline(always)]
    fn sort(self, c: Binary32, entries: [SortEntry<Binary32, 2>; 4]) -> [SortEntry<Binary32, 2>; 4] {
        // Numbers that are not negative have the order of their bits, so one integer holds the whole sort key.
        let key = |entry: SortEntry<Binary32, 2>| {
            let [tmin, hit, index] = [entry.tmin.value.0.to_bits(), entry.hit.value.into(), entry.index.value];
            u64::from(tmin) << 3 | u64::from(!hit & 1) << 2 | u64::from(index)
        };
        // Not `map`, which the compiler does not inline here.
        let mut keys: [u64; 4] = array_of!(i => key(entries[i]));
        sort_keys(&mut keys);
        array_of!(i => SortEntry {
            hit: Bit::new(c, keys[i] & 4 == 0),
            tmin: Num::new(c, Single(f32::from_bits((keys[i] >> 3) as u32))),
            index: Word::new(c, (keys[i] & 3) as u32),
        })
    }

    #[inline(always)]
    fn map<M: LaneMap, const N: usize>(
        self,
        c: Binary32,
        map: &M,
        shared: &Of<M::Shared, Binary32>,
        items: &[Of<M::Item, Binary32>; N],
    ) -> [Of<M::Output, Binary32>; N] {
        if N == 1 || !HAS_SIMD {
            return map.run(c, self, shared, items);
        }
        let lanes = FourItems(Lanes::new(baseline()));
        let shared = M::Shared::gather([shared; 4], &lanes);
        let first: [Of<M::Output, Binary32>; 4] = four(map, &lanes, &shared, items, 0);
        let mut outputs = [first[0]; N];
        outputs[1..N.min(4)].copy_from_slice(&first[1..N.min(4)]);
        for chunk in 1..N.div_ceil(4) {
            let first = 4 * chunk;
            let count = (N - first).min(4);
            outputs[first..first + count].copy_from_slice(&four(map, &lanes, &shared, items, first)[..count]);
        }
        outputs
    }
}

/// Sorts four keys, the least first.
#[inline(always)]
pub(crate) fn sort_keys(keys: &mut [u64; 4]) {
    for (i, j) in [(0, 2), (1, 3), (0, 1), (2, 3), (1, 2)] {
        (keys[i], keys[j]) = (keys[i].min(keys[j]), keys[i].max(keys[j]));
    }
}

/// Computes four items beginning with number `first`. If there are fewer, the last is repeated.
#[inline(always)]
fn four<M: LaneMap, const N: usize>(
    map: &M,
    lanes: &FourItems,
    shared: &Of<M::Shared, FourLanes>,
    items: &[Of<M::Item, Binary32>; N],
    first: usize,
) -> [Of<M::Output, Binary32>; 4] {
    let items = M::Item::gather(array_of!(i => &items[(first + i).min(N - 1)]), lanes);
    let [output] = map.run(lanes.0, SimdKernels, shared, &[items]);
    M::Output::scatter(output, lanes)
}

pub(crate) type FourLanes = Lanes<Baseline, Four>;
type Nums = <Four as Width<Baseline>>::Nums;
type Bits = <Four as Width<Baseline>>::Bits;
type Ints = <Bits as SimdMask<Baseline>>::Ints;
type Words = <Four as Width<Baseline>>::Words;

/// Converts between four values of binary32 and a register of four lanes.
struct FourItems(FourLanes);

impl Gather<Binary32, FourLanes, 4> for FourItems {
    #[inline(always)]
    fn num(&self, values: [&Num<Binary32>; 4]) -> Num<FourLanes> {
        Num::new(self.0, Register(Nums::simd_from(self.0.simd(), array_of!(i => values[i].value.0))))
    }
    #[inline(always)]
    fn bit(&self, values: [&Bit<Binary32>; 4]) -> Bit<FourLanes> {
        let ones: [i32; 4] = array_of!(i => -i32::from(values[i].value));
        Bit::new(self.0, Register(Bits::from_vector(Ints::simd_from(self.0.simd(), ones))))
    }
    #[inline(always)]
    fn word<const W: u32>(&self, values: [&Word<Binary32, W>; 4]) -> Word<FourLanes, W> {
        Word::new(self.0, Register(Words::simd_from(self.0.simd(), array_of!(i => values[i].value))))
    }
}

impl Scatter<FourLanes, Binary32, 4> for FourItems {
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

/// The SIMD instructions that every machine of the architecture has.
#[cfg(target_arch = "x86_64")]
pub type Baseline = fearless_simd::Sse2;
#[cfg(target_arch = "aarch64")]
pub type Baseline = fearless_simd::Neon;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub type Baseline = fearless_simd::Fallback;

/// A value of [`Baseline`].
#[inline(always)]
pub fn baseline() -> Baseline {
    #[cfg(target_arch = "x86_64")]
    let simd = Level::baseline().as_sse2();
    #[cfg(target_arch = "aarch64")]
    let simd = Level::baseline().as_neon();
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let simd = Some(fearless_simd::Fallback::new());
    let Some(simd) = simd else { unreachable!("every machine of the architecture has these instructions") };
    simd
}

/// Evaluates an expression over the widest registers of the level: AVX-512, AVX2, or those that every machine has. As
/// `fearless_simd::dispatch!`, whose copy for SSE4.2 takes as long to compile as the others, for machines of before 2013.
#[cfg(target_arch = "x86_64")]
#[macro_export]
macro_rules! dispatch {
    (@with $token:expr, $simd:pat => $op:expr) => {{
        let token = $token;
        $crate::Simd::vectorize(
            token,
            #[inline(always)]
            || {
                let $simd = token;
                $op
            },
        )
    }};
    ($level:expr, $simd:pat => $op:expr) => {{
        let level: $crate::Level = $level;
        if let Some(token) = level.as_avx512() {
            $crate::dispatch!(@with token, $simd => $op)
        } else if let Some(token) = level.as_avx2() {
            $crate::dispatch!(@with token, $simd => $op)
        } else {
            $crate::dispatch!(@with $crate::baseline(), $simd => $op)
        }
    }};
}

/// Whether lanes are faster than one number after another.
pub(crate) const HAS_SIMD: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));

/// Set in the sort key of a missed box, above its index.
const MISSES: i32 = 4;

impl<S: Simd, W: Width<S>, R: LaneRounding<S, W>> Kernels<Lanes<S, W, R>> for SimdKernels
where
    Lanes<S, W, R>: Copy,
{
    #[inline(always)]
    fn exchange(
        self,
        condition: Bit<Lanes<S, W, R>>,
        a: Num<Lanes<S, W, R>>,
        b: Num<Lanes<S, W, R>>,
    ) -> (Num<Lanes<S, W, R>>, Num<Lanes<S, W, R>>) {
        let lanes = condition.circuit;
        let (a, b) = lanes.exchange(condition.value.0, a.value.0, b.value.0);
        (Num::new(lanes, Register(a)), Num::new(lanes, Register(b)))
    }
    #[inline(always)]
    fn tie(
        self,
        lanes: Lanes<S, W, R>,
        ends: (Vec3<Lanes<S, W, R>>, Vec3<Lanes<S, W, R>>),
        products: (Num<Lanes<S, W, R>>, Num<Lanes<S, W, R>>),
        difference: Num<Lanes<S, W, R>>,
    ) -> Tie<Lanes<S, W, R>> {
        if !difference.value.0.simd_eq(lanes.constant(0.0).0).any_true() {
            return Tie { front: lanes.bit(false), back: lanes.bit(false) };
        }
        Portable.tie(lanes, ends, products, difference)
    }
    #[inline(always)]
    fn largest_or_zero(
        self,
        lanes: Lanes<S, W, R>,
        _name: Arguments<'_>,
        [x, y, z]: [Num<Lanes<S, W, R>>; 3],
    ) -> Num<Lanes<S, W, R>> {
        // The second operand is never NaN, and a zero result is the constant.
        let z0 = lanes.greater(z.value.0, lanes.constant(0.0).0);
        Num::new(lanes, Register(lanes.greater(x.value.0, lanes.greater(y.value.0, z0))))
    }
    #[inline(always)]
    fn smallest_or_extent(
        self,
        lanes: Lanes<S, W, R>,
        name: Arguments<'_>,
        numbers: [Num<Lanes<S, W, R>>; 3],
        extent: Num<Lanes<S, W, R>>,
    ) -> Num<Lanes<S, W, R>> {
        if extent.value.0.is_nan().any_true() {
            return Portable.smallest_or_extent(lanes, name, numbers, extent);
        }
        let [x, y, z] = numbers;
        let z_extent = lanes.lesser(z.value.0, extent.value.0);
        Num::new(lanes, Register(lanes.lesser(x.value.0, lanes.lesser(y.value.0, z_extent))))
    }
    #[inline(always)]
    fn sort(
        self,
        lanes: Lanes<S, W, R>,
        entries: [SortEntry<Lanes<S, W, R>, 2>; 4],
    ) -> [SortEntry<Lanes<S, W, R>, 2>; 4] {
        // The miss bit and the index form one integer, which decides ties and moves as one.
        let mut sorted: [(W::Nums, W::Ints); 4] = array_of!(i => {
            let misses = !entries[i].hit.value.0.to_vector() & MISSES;
            (entries[i].tmin.value.0, misses | entries[i].index.value.0.bitcast::<W::Ints>())
        });
        compare_and_swap(lanes, &mut sorted, 0, 2);
        compare_and_swap(lanes, &mut sorted, 1, 3);
        compare_and_swap(lanes, &mut sorted, 0, 1);
        compare_and_swap(lanes, &mut sorted, 2, 3);
        compare_and_swap(lanes, &mut sorted, 1, 2);
        array_of!(i => {
            let (tmin, key) = sorted[i];
            SortEntry {
                hit: Bit::new(lanes, Register(key.simd_lt(MISSES))),
                tmin: Num::new(lanes, Register(tmin)),
                index: Word::new(lanes, Register((key & (MISSES - 1)).bitcast())),
            }
        })
    }
}

/// Exchanges the distances and keys `i` and `j` where the second comes before the first.
#[inline(always)]
fn compare_and_swap<S: Simd, W: Width<S>, R: LaneRounding<S, W>>(
    lanes: Lanes<S, W, R>,
    boxes: &mut [(W::Nums, W::Ints); 4],
    i: usize,
    j: usize,
) {
    let ((a, a_key), (b, b_key)) = (boxes[i], boxes[j]);
    let swap = b.simd_lt(a) | (b.simd_eq(a) & b_key.simd_lt(a_key));
    let ((a, b), (a_key, b_key)) = (lanes.exchange(swap, a, b), lanes.exchange(swap, a_key, b_key));
    (boxes[i], boxes[j]) = ((a, a_key), (b, b_key));
}
