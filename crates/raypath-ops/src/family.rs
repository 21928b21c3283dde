//! One structure over many circuits, and the way from several of one circuit to one of another.

use crate::binary32::Binary32;
use crate::bundle::Bundle;
use crate::circuit::Circuit;
use crate::handle::{Bit, Flags, Num, Word};

/// A bundle whatever its circuit, named by the one over [`Binary32`]: of `Vec3<Binary32>`, `Of<C>` is `Vec3<C>`.
/// Implemented where [`Bundle`] is.
pub trait Family {
    /// The bundle over a circuit.
    type Of<C: Circuit>: Bundle<C>;

    /// One bundle from `N`, leaf by leaf.
    fn gather<A: Circuit, B: Circuit, const N: usize>(
        things: [&Self::Of<A>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Self::Of<B>;

    /// Writes a bundle into its part of another, leaf by leaf.
    fn put<A: Circuit, B: Circuit>(thing: &Self::Of<A>, place: &mut Self::Of<B>, lanes: &impl Put<A, B>);

    /// `N` bundles from one, leaf by leaf.
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        thing: Self::Of<A>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Self::Of<B>; N];
}

/// How `N` values of circuit `A` become one of circuit `B`.
pub trait Gather<A: Circuit, B: Circuit, const N: usize> {
    /// Numbers.
    fn num(&self, values: [&Num<A>; N]) -> Num<B>;
    /// Truth values.
    fn bit(&self, values: [&Bit<A>; N]) -> Bit<B>;
    /// Words.
    fn word<const W: u32>(&self, values: [&Word<A, W>; N]) -> Word<B, W>;
}

/// How a value of circuit `A` is written into its part of one of circuit `B`.
pub trait Put<A: Circuit, B: Circuit> {
    /// A number.
    fn num(&self, value: &Num<A>, place: &mut Num<B>);
    /// A truth value.
    fn bit(&self, value: &Bit<A>, place: &mut Bit<B>);
    /// A word.
    fn word<const W: u32>(&self, value: &Word<A, W>, place: &mut Word<B, W>);
}

/// How one value of circuit `A` becomes `N` of circuit `B`.
pub trait Scatter<A: Circuit, B: Circuit, const N: usize> {
    /// Numbers.
    fn num(&self, value: Num<A>) -> [Num<B>; N];
    /// Truth values.
    fn bit(&self, value: Bit<A>) -> [Bit<B>; N];
    /// Words.
    fn word<const W: u32>(&self, value: Word<A, W>) -> [Word<B, W>; N];
}

macro_rules! leaf {
    ($(const $w:ident: $kind:ty,)? $leaf:ty, $of:ty, $method:ident) => {
        impl$(<const $w: $kind>)? Family for $leaf {
            type Of<C: Circuit> = $of;

            #[inline(always)]
            fn gather<A: Circuit, B: Circuit, const N: usize>(
                things: [&Self::Of<A>; N],
                lanes: &impl Gather<A, B, N>,
            ) -> Self::Of<B> {
                lanes.$method(things)
            }

            #[inline(always)]
            fn put<A: Circuit, B: Circuit>(thing: &Self::Of<A>, place: &mut Self::Of<B>, lanes: &impl Put<A, B>) {
                lanes.$method(thing, place);
            }

            #[inline(always)]
            fn scatter<A: Circuit, B: Circuit, const N: usize>(
                thing: Self::Of<A>,
                lanes: &impl Scatter<A, B, N>,
            ) -> [Self::Of<B>; N] {
                lanes.$method(thing)
            }
        }
    };
}

leaf!(Num<Binary32>, Num<C>, num);
leaf!(Bit<Binary32>, Bit<C>, bit);
leaf!(const W: u32, Word<Binary32, W>, Word<C, W>, word);

impl<const K: usize> Family for Flags<Binary32, K> {
    type Of<C: Circuit> = Flags<C, K>;

    #[inline(always)]
    fn gather<A: Circuit, B: Circuit, const N: usize>(
        things: [&Flags<A, K>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Flags<B, K> {
        Flags(array_of!(k => lanes.bit(array_of!(n => &things[n].0[k]))))
    }

    #[inline(always)]
    fn put<A: Circuit, B: Circuit>(thing: &Flags<A, K>, place: &mut Flags<B, K>, lanes: &impl Put<A, B>) {
        for (thing, place) in thing.0.iter().zip(&mut place.0) {
            lanes.bit(thing, place);
        }
    }

    #[inline(always)]
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        thing: Flags<A, K>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Flags<B, K>; N] {
        let bits: [[Bit<B>; N]; K] = array_of!(k => lanes.bit(thing.0[k]));
        array_of!(n => Flags(array_of!(k => bits[k][n])))
    }
}

impl<F: Family, const K: usize> Family for [F; K] {
    type Of<C: Circuit> = [F::Of<C>; K];

    #[inline(always)]
    fn gather<A: Circuit, B: Circuit, const N: usize>(
        things: [&Self::Of<A>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Self::Of<B> {
        // Not `array_of!`: compilers keep the array that it makes of so much in memory.
        std::array::from_fn(
            #[inline(always)]
            |k| F::gather(array_of!(n => &things[n][k]), lanes),
        )
    }

    #[inline(always)]
    fn put<A: Circuit, B: Circuit>(thing: &Self::Of<A>, place: &mut Self::Of<B>, lanes: &impl Put<A, B>) {
        for (thing, place) in thing.iter().zip(place) {
            F::put(thing, place, lanes);
        }
    }

    #[inline(always)]
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        thing: Self::Of<A>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Self::Of<B>; N] {
        let elements: [[F::Of<B>; N]; K] = array_of!(k => F::scatter(thing[k], lanes));
        array_of!(n => array_of!(k => elements[k][n]))
    }
}

impl Family for () {
    type Of<C: Circuit> = ();

    #[inline(always)]
    fn gather<A: Circuit, B: Circuit, const N: usize>(_: [&(); N], _: &impl Gather<A, B, N>) {}

    #[inline(always)]
    fn put<A: Circuit, B: Circuit>(_: &(), _: &mut (), _: &impl Put<A, B>) {}

    #[inline(always)]
    fn scatter<A: Circuit, B: Circuit, const N: usize>(_: (), _: &impl Scatter<A, B, N>) -> [(); N] {
        [(); N]
    }
}
