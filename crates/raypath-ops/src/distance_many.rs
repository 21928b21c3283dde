//! Distances of several vectors whose beats are interleaved: each vector has its own accumulator.

use crate::distance::{ACCUMULATED, products_of, squares_of};
use crate::{
    Angular, AngularOutput, Beat, Circuit, Euclidean, EuclideanOutput, Num, Operation, Portable, Rounding, Word, bundle,
};

/// [`Euclidean`] with `M` accumulators, selected by a word of `W` bits. `M` is 2 to the power of `W`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EuclideanMany<const N: usize, const M: usize, const W: u32> {
    /// How the sum of a beat is rounded.
    pub rounding: Rounding,
}

/// [`Angular`] with `M` pairs of accumulators, selected by a word of `W` bits. `M` is 2 to the power of `W`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AngularMany<const N: usize, const M: usize, const W: u32> {
    /// How the sums of a beat are rounded.
    pub rounding: Rounding,
}

bundle! {
    /// The input of [`EuclideanMany`] and [`AngularMany`], which share their ports.
    pub struct BeatManyInput<C, const N: usize, const W: u32> {
        /// The beat.
        pub euclidean: Beat<C, N>,
        /// The index of the accumulator, or pair of them, to which the beat is added, and which its reset clears.
        pub accumulator: Word<C, W>,
    }

    /// The accumulators of Euclidean beats.
    pub struct EuclideanManyState<C, const M: usize> {
        /// Sums of squared differences, each since the last reset of its accumulator.
        pub accumulator: [Num<C>; M],
    }

    /// The accumulators of angular beats.
    pub struct AngularManyState<C, const M: usize> {
        /// Sums of a·b, each since the last reset of its accumulator.
        pub dot_product: [Num<C>; M],
        /// Sums of b·b over the same beats.
        pub norm: [Num<C>; M],
    }
}

impl<const N: usize, const M: usize, const W: u32> Operation for EuclideanMany<N, M, W> {
    const NAME: &'static str = Euclidean::<N>::NAME;
    type Input<C: Circuit> = BeatManyInput<C, N, W>;
    type Output<C: Circuit> = EuclideanOutput<C>;
    type State<C: Circuit> = EuclideanManyState<C, M>;

    #[inline(always)]
    fn run<C: Circuit>(
        &self,
        c: C,
        input: BeatManyInput<C, N, W>,
        state: EuclideanManyState<C, M>,
    ) -> (EuclideanOutput<C>, EuclideanManyState<C, M>) {
        let reset_accum = input.euclidean.reset_accum;
        let sum = squares_of(c, Portable, self.rounding, &input.euclidean);

        c.stage_or(10, ACCUMULATED, "accumulated");
        let accumulator = chosen(c, input.accumulator, &state.accumulator) + sum;
        c.label(format_args!("accumulator"), &accumulator);
        let next = reset_accum.select(c.zero(), accumulator);
        let next = EuclideanManyState { accumulator: replaced(input.accumulator, &state.accumulator, next) };
        c.label(format_args!("next"), &next);
        (EuclideanOutput { euclidean_accumulator: accumulator, euclidean_reset_accum: reset_accum }, next)
    }
}

impl<const N: usize, const M: usize, const W: u32> Operation for AngularMany<N, M, W> {
    const NAME: &'static str = Angular::<N>::NAME;
    type Input<C: Circuit> = BeatManyInput<C, N, W>;
    type Output<C: Circuit> = AngularOutput<C>;
    type State<C: Circuit> = AngularManyState<C, M>;

    #[inline(always)]
    fn run<C: Circuit>(
        &self,
        c: C,
        input: BeatManyInput<C, N, W>,
        state: AngularManyState<C, M>,
    ) -> (AngularOutput<C>, AngularManyState<C, M>) {
        let (reset_accum, which) = (input.euclidean.reset_accum, input.accumulator);
        let [dot_sum, norm_sum] = products_of(c, Portable, self.rounding, &input.euclidean);

        c.stage_or(9, ACCUMULATED, "both accumulated");
        let dot_product = chosen(c, which, &state.dot_product) + dot_sum;
        let norm = chosen(c, which, &state.norm) + norm_sum;
        c.label(format_args!("dot_product"), &dot_product);
        c.label(format_args!("norm"), &norm);
        let next = AngularManyState {
            dot_product: replaced(which, &state.dot_product, reset_accum.select(c.zero(), dot_product)),
            norm: replaced(which, &state.norm, reset_accum.select(c.zero(), norm)),
        };
        c.label(format_args!("next"), &next);
        let output =
            AngularOutput { angular_dot_product: dot_product, angular_norm: norm, angular_reset_accum: reset_accum };
        (output, next)
    }
}

/// The number at index `which`, by a tree of multiplexers.
#[inline(always)]
fn chosen<C: Circuit, const M: usize, const W: u32>(c: C, which: Word<C, W>, numbers: &[Num<C>; M]) -> Num<C> {
    const { assert!(M == 1 << W, "as many accumulators as the word has values") };
    let mut chosen = *numbers;
    for level in 0..W {
        for first in (0..M).step_by(2 << level) {
            let second = first + (1 << level);
            chosen[first] = which.less(c.word(second as u32)).select(chosen[first], chosen[second]);
        }
    }
    chosen[0]
}

/// The numbers, with the one at index `which` replaced by `by`.
#[inline(always)]
fn replaced<C: Circuit, const M: usize, const W: u32>(
    which: Word<C, W>,
    numbers: &[Num<C>; M],
    by: Num<C>,
) -> [Num<C>; M] {
    array_of!(i => which.is(i as u32).select(by, numbers[i]))
}
