//! The constants of a ray that its jobs need, from origin, direction and range: what [`Ray::new`] derives, bit for bit.
//!
//! The quotients are computed between the two functions here, so that hardware can share one divider among them.

use crate::words::{WordCircuit, WordMethods, label};
use raypath_ops::{Bit, Circuit, Num, Ray, Vec3, Word, bundle};

bundle! {
    /// A ray as it enters the unit.
    pub struct Entry<C> {
        /// The point at which the ray begins.
        pub origin: Vec3<C>,
        /// The direction.
        pub dir: Vec3<C>,
        /// The least distance of a hit.
        pub t_min: Num<C>,
        /// The greatest distance of a hit.
        pub t_max: Num<C>,
    }

    /// The axes, permuted so that a ray runs along z.
    pub struct Axes<C> {
        /// The axis that becomes x.
        pub kx: Word<C, 2>,
        /// The axis that becomes y.
        pub ky: Word<C, 2>,
        /// The axis that becomes z: the first of those on which the direction's component has the greatest magnitude.
        pub kz: Word<C, 2>,
    }

    /// A dividend and a divisor.
    pub struct Division<C> {
        /// The dividend.
        pub dividend: Num<C>,
        /// The divisor.
        pub divisor: Num<C>,
    }

    /// What the quotients give.
    pub struct Derived<C> {
        /// 1 / direction, element by element.
        pub inv: Vec3<C>,
        /// `dir[kx] / dir[kz]`, `dir[ky] / dir[kz]`, `1 / dir[kz]`.
        pub shear: Vec3<C>,
        /// The direction is too short to invert.
        pub is_too_short: Bit<C>,
    }
}

/// The number of quotients of a ray.
pub const QUOTIENTS: usize = 5;

/// Whether the ray is refused before its quotients are known: a direction or an origin that is not finite, a range that
/// is negative or NaN. A direction of zeros is not among them: [`Derived::is_too_short`] refuses it.
#[inline]
pub fn is_refused<C: WordCircuit>(c: C, entry: &Entry<C>) -> Bit<C> {
    let Entry { origin, dir, t_min, t_max } = entry;
    let (origin, dir) = (components(*origin), components(*dir));
    let all = |of: [Num<C>; 3], test: &dyn Fn(Num<C>) -> Bit<C>| test(of[0]) & test(of[1]) & test(of[2]);
    let finite = all(origin, &|x| is_finite(c, x)) & all(dir, &|x| is_finite(c, x));
    let has_range = t_min.is_at_least_zero() & t_max.is_at_least_zero();
    label!(c: finite, has_range);
    !(finite & has_range)
}

/// The axes of a direction.
#[inline]
pub fn axes<C: WordCircuit>(c: C, dir: Vec3<C>) -> Axes<C> {
    let [x, y, z] = components(dir).map(|component| magnitude(component));
    let y_is_greater = y.compare(x).greater();
    let greater = y_is_greater.select(y, x);
    let z_is_greater = z.compare(greater).greater();
    let kz: Word<C, 2> = z_is_greater.select(c.word(2), y_is_greater.select(c.word(1), c.word(0)));
    label!(c: y_is_greater, greater, z_is_greater, kz);
    let after = |k: Word<C, 2>| k.is(2).select(c.word(0), k.plus_constant(1));
    let first = after(kz);
    let (second, along_z) = (after(first), dir.along(kz));
    let is_reversed = along_z.is_below_zero();
    label!(c: first, second, along_z, is_reversed);
    let (kx, ky) = is_reversed.exchange(first, second);
    Axes { kx, ky, kz }
}

/// The quotients that a ray needs.
#[inline]
pub fn divisions<C: WordCircuit>(c: C, dir: Vec3<C>, axes: Axes<C>) -> [Division<C>; QUOTIENTS] {
    let one = Num::new(c, c.constant(1.0));
    let Vec3 { x, y, z } = dir;
    let along_z = dir.along(axes.kz);
    label!(c: along_z);
    let of = |dividend, divisor| Division { dividend, divisor };
    [of(one, x), of(one, y), of(one, z), of(dir.along(axes.kx), along_z), of(dir.along(axes.ky), along_z)]
}

/// The constants of a ray from its quotients, in the order of [`divisions`].
#[inline]
pub fn derived<C: WordCircuit>(c: C, axes: Axes<C>, [x, y, z, shear_x, shear_y]: [Num<C>; QUOTIENTS]) -> Derived<C> {
    let inv = Vec3 { x, y, z };
    let shear_z = inv.along(axes.kz);
    label!(c: shear_z);
    Derived { inv, shear: Vec3 { x: shear_x, y: shear_y, z: shear_z }, is_too_short: !is_finite(c, shear_z) }
}

/// The ray of a job.
#[inline]
pub fn ray<C: Circuit>(origin: Vec3<C>, dir: Vec3<C>, derived: Derived<C>, axes: Axes<C>, extent: Num<C>) -> Ray<C> {
    let Derived { inv, shear, .. } = derived;
    let Axes { kx, ky, kz } = axes;
    Ray { origin, dir, inv, extent, shear, kx, ky, kz }
}

#[inline(always)]
fn components<C: Circuit>(Vec3 { x, y, z }: Vec3<C>) -> [Num<C>; 3] {
    [x, y, z]
}

#[inline(always)]
fn is_finite<C: WordCircuit>(c: C, x: Num<C>) -> Bit<C> {
    Bit::new(c, c.is_finite(x.value))
}

#[inline(always)]
fn magnitude<C: WordCircuit>(x: Num<C>) -> Num<C> {
    let (c, magnitude) = (x.circuit, x.sign_bit().select(-x, x));
    label!(c: magnitude);
    magnitude
}
