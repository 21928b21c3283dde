//! Bundles as type families: one structure over many circuits, and conversions between circuits.

use crate::{Binary32, Bit, Bundle, Circuit, Flags, Num, Word};

/// A bundle type without its circuit. The member over [`Binary32`] represents the family: for `Vec3<Binary32>`, the
/// type `Of<C>` is `Vec3<C>`. Implemented for every type that implements [`Bundle`].
///
/// The methods convert bundles between circuits whose values hold different numbers of jobs, such as scalars, SIMD
/// registers and blocks of jobs in memory.
pub trait Family {
    /// The bundle over circuit `C`.
    type Of<C: Circuit>: Bundle<C>;

    /// Combines `N` bundles over `A` into one over `B`, leaf by leaf.
    fn gather<A: Circuit, B: Circuit, const N: usize>(
        items: [&Self::Of<A>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Self::Of<B>;

    /// Writes a bundle over `A` into part of a bundle over `B`, leaf by leaf.
    fn put<A: Circuit, B: Circuit>(value: &Self::Of<A>, target: &mut Self::Of<B>, lanes: &impl Put<A, B>);

    /// Divides a bundle over `A` into `N` bundles over `B`, leaf by leaf.
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        value: Self::Of<A>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Self::Of<B>; N];
}

/// The bundle of family `F` over circuit `C`.
pub type Of<F, C> = <F as Family>::Of<C>;

/// Combines `N` values of circuit `A` into one of circuit `B`.
pub trait Gather<A: Circuit, B: Circuit, const N: usize> {
    /// Combines numbers.
    fn num(&self, values: [&Num<A>; N]) -> Num<B>;
    /// Combines truth values.
    fn bit(&self, values: [&Bit<A>; N]) -> Bit<B>;
    /// Combines words.
    fn word<const W: u32>(&self, values: [&Word<A, W>; N]) -> Word<B, W>;
}

/// Writes a value of circuit `A` into part of a value of circuit `B`.
pub trait Put<A: Circuit, B: Circuit> {
    /// Writes a number.
    fn num(&self, value: &Num<A>, target: &mut Num<B>);
    /// Writes a truth value.
    fn bit(&self, value: &Bit<A>, target: &mut Bit<B>);
    /// Writes a word.
    fn word<const W: u32>(&self, value: &Word<A, W>, target: &mut Word<B, W>);
}

/// Divides one value of circuit `A` into `N` values of circuit `B`.
pub trait Scatter<A: Circuit, B: Circuit, const N: usize> {
    /// Divides numbers.
    fn num(&self, value: Num<A>) -> [Num<B>; N];
    /// Divides truth values.
    fn bit(&self, value: Bit<A>) -> [Bit<B>; N];
    /// Divides words.
    fn word<const W: u32>(&self, value: Word<A, W>) -> [Word<B, W>; N];
}

macro_rules! leaf {
    ($(const $w:ident: $kind:ty,)? $leaf:ty, $of:ty, $method:ident) => {
        impl$(<const $w: $kind>)? Family for $leaf {
            type Of<C: Circuit> = $of;

            #[inline(always)]
            fn gather<A: Circuit, B: Circuit, const N: usize>(
                items: [&Self::Of<A>; N],
                lanes: &impl Gather<A, B, N>,
            ) -> Self::Of<B> {
                lanes.$method(items)
            }

            #[inline(always)]
            fn put<A: Circuit, B: Circuit>(value: &Self::Of<A>, target: &mut Self::Of<B>, lanes: &impl Put<A, B>) {
                lanes.$method(value, target);
            }

            #[inline(always)]
            fn scatter<A: Circuit, B: Circuit, const N: usize>(
                value: Self::Of<A>,
                lanes: &impl Scatter<A, B, N>,
            ) -> [Self::Of<B>; N] {
                lanes.$method(value)
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
        items: [&Flags<A, K>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Flags<B, K> {
        Flags(array_of!(k => lanes.bit(array_of!(n => &items[n].0[k]))))
    }

    #[inline(always)]
    fn put<A: Circuit, B: Circuit>(value: &Flags<A, K>, target: &mut Flags<B, K>, lanes: &impl Put<A, B>) {
        for (value, target) in value.0.iter().zip(&mut target.0) {
            lanes.bit(value, target);
        }
    }

    #[inline(always)]
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        value: Flags<A, K>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Flags<B, K>; N] {
        let bits: [[Bit<B>; N]; K] = array_of!(k => lanes.bit(value.0[k]));
        array_of!(n => Flags(array_of!(k => bits[k][n])))
    }
}

impl<F: Family, const K: usize> Family for [F; K] {
    type Of<C: Circuit> = [F::Of<C>; K];

    #[inline(always)]
    fn gather<A: Circuit, B: Circuit, const N: usize>(
        items: [&Self::Of<A>; N],
        lanes: &impl Gather<A, B, N>,
    ) -> Self::Of<B> {
        // Not `array_of!`: the compiler would keep the array of references in memory.
        std::array::from_fn(
            #[inline(always)]
            |k| F::gather(array_of!(n => &items[n][k]), lanes),
        )
    }

    #[inline(always)]
    fn put<A: Circuit, B: Circuit>(value: &Self::Of<A>, target: &mut Self::Of<B>, lanes: &impl Put<A, B>) {
        for (value, target) in value.iter().zip(target) {
            F::put(value, target, lanes);
        }
    }

    #[inline(always)]
    fn scatter<A: Circuit, B: Circuit, const N: usize>(
        value: Self::Of<A>,
        lanes: &impl Scatter<A, B, N>,
    ) -> [Self::Of<B>; N] {
        let elements: [[F::Of<B>; N]; K] = array_of!(k => F::scatter(value[k], lanes));
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
