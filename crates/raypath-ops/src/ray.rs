//! Rays with the derived values that the hardware expects (`docs/reference/semantics.md`; the paper's ray format).

use crate::{Binary32, Circuit, Num, Vec3, Word, bundle};
use thiserror::Error;

bundle! {
    /// A ray as the datapath expects it. [`Ray::new`] derives the other fields from origin, direction and extent.
    pub struct Ray<C> {
        /// The point at which the ray begins.
        pub origin: Vec3<C>,
        /// The direction, of any length except 0.
        pub dir: Vec3<C>,
        /// 1 / direction, element by element; ±∞ for ±0.
        pub inv: Vec3<C>,
        /// The length of the ray, in units of the direction's length. Boxes beyond it are missed.
        pub extent: Num<C>,
        /// `Sx = dir[kx] / dir[kz]`, `Sy = dir[ky] / dir[kz]`, `Sz = 1 / dir[kz]`.
        pub shear: Vec3<C>,
        /// The axis that becomes x when the axes are permuted so that the ray runs along z: 0, 1 or 2.
        pub kx: Word<C, 2>,
        /// The axis that becomes y: 0, 1 or 2.
        pub ky: Word<C, 2>,
        /// The axis that becomes z: the first of those on which the direction's component has the greatest magnitude.
        pub kz: Word<C, 2>,
    }
}

/// The reason why [`Ray::new`] rejects its arguments.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RayError {
    /// The direction is the zero vector.
    #[error("direction ({}, {}, {}) is zero, expected a direction of any other length", .0[0], .0[1], .0[2])]
    ZeroDirection([f32; 3]),
    /// The direction has an infinite or NaN component.
    #[error("direction ({}, {}, {}) is not finite, expected three finite numbers", .0[0], .0[1], .0[2])]
    DirectionNotFinite([f32; 3]),
    /// The inverse of the direction's greatest component overflows, so that the shear is not finite.
    #[error("direction ({:e}, {:e}, {:e}) is too short to invert, expected a component of at least 2^-128", .0[0], .0[1], .0[2])]
    DirectionTooShort([f32; 3]),
    /// The origin has an infinite or NaN component.
    #[error("origin ({}, {}, {}) is not finite, expected three finite numbers", .0[0], .0[1], .0[2])]
    OriginNotFinite([f32; 3]),
    /// The extent is negative or NaN.
    #[error("extent {0} is not a valid distance, expected a number of at least 0 (infinity reaches everything)")]
    Extent(f32),
}

impl<C: Circuit> Ray<C> {
    /// A vector with its axes permuted so that the ray runs along z.
    #[inline(always)]
    pub(crate) fn turned(&self, v: Vec3<C>) -> Vec3<C> {
        Vec3 { x: v.along(self.kx), y: v.along(self.ky), z: v.along(self.kz) }
    }
}

impl Ray<Binary32> {
    /// The ray from `origin` along `direction` with the length `extent` times that of `direction`.
    ///
    /// # Errors
    /// A direction that is zero, not finite, or so short that its inverse overflows; an origin that is not finite; an
    /// extent that is negative or NaN.
    pub fn new(origin: [f32; 3], direction: [f32; 3], extent: f32) -> Result<Self, RayError> {
        if !direction.iter().all(|d| d.is_finite()) {
            return Err(RayError::DirectionNotFinite(direction));
        }
        if direction == [0.0; 3] {
            return Err(RayError::ZeroDirection(direction));
        }
        if !origin.iter().all(|o| o.is_finite()) {
            return Err(RayError::OriginNotFinite(origin));
        }
        if extent.is_nan() || extent < 0.0 {
            return Err(RayError::Extent(extent));
        }
        let [kx, ky, kz] = axes(direction);
        let sz = 1.0 / direction[kz];
        if !sz.is_finite() {
            return Err(RayError::DirectionTooShort(direction));
        }
        Ok(Self {
            origin: origin.into(),
            dir: direction.into(),
            inv: direction.map(|d| 1.0 / d).into(),
            extent: extent.into(),
            shear: [direction[kx] / direction[kz], direction[ky] / direction[kz], sz].into(),
            kx: Word::truncate(kx as u32),
            ky: Word::truncate(ky as u32),
            kz: Word::truncate(kz as u32),
        })
    }
}

/// kx, ky, kz. kz is the axis of the greatest absolute component; kx and ky are swapped if that component is negative,
/// so that the winding order of triangles is preserved.
fn axes(direction: [f32; 3]) -> [usize; 3] {
    let mut kz = 0;
    for axis in 1..3 {
        if direction[axis].abs() > direction[kz].abs() {
            kz = axis;
        }
    }
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    if direction[kz] < 0.0 { [ky, kx, kz] } else { [kx, ky, kz] }
}
