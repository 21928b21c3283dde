//! Vectors, boxes and triangles.

use crate::binary32::Binary32;
use crate::bundle_macro::bundle;
use crate::circuit::Circuit;
use crate::handle::{Num, Word};
use std::ops::{Mul, Sub};

bundle! {
    /// A vector or point with three coordinates.
    pub struct Vec3<C> {
        /// The x coordinate.
        pub x: Num<C>,
        /// The y coordinate.
        pub y: Num<C>,
        /// The z coordinate.
        pub z: Num<C>,
    }

    /// The space between two parallel planes: the extent of a box along one axis.
    pub struct Slab<C> {
        /// The lesser bound.
        pub min: Num<C>,
        /// The greater bound.
        pub max: Num<C>,
    }

    /// An axis-aligned bounding box: three slabs. Bounds with `min` greater than `max` are not reordered.
    pub struct Aabb<C> {
        /// The bounds along x.
        pub x: Slab<C>,
        /// The bounds along y.
        pub y: Slab<C>,
        /// The bounds along z.
        pub z: Slab<C>,
    }

    /// A triangle. Its vertices are counter-clockwise as seen from its front.
    pub struct Triangle<C> {
        /// The first vertex.
        pub a: Vec3<C>,
        /// The second vertex.
        pub b: Vec3<C>,
        /// The third vertex.
        pub c: Vec3<C>,
    }
}

impl<C: Circuit> Vec3<C> {
    /// The coordinate along axis `k`: 0 is x, 1 is y, 2 and 3 are z.
    #[inline(always)]
    pub fn along(self, k: Word<C, 2>) -> Num<C> {
        k.is(0).select(self.x, k.is(1).select(self.y, self.z))
    }
}

impl<C: Circuit> Mul<Num<C>> for Vec3<C> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: Num<C>) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<C: Circuit> Sub for Vec3<C> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<C: Circuit> Sub<Num<C>> for Slab<C> {
    type Output = Self;
    /// Both bounds relative to a coordinate.
    #[inline(always)]
    fn sub(self, from: Num<C>) -> Self {
        Self { min: self.min - from, max: self.max - from }
    }
}

impl<C: Circuit> Mul<Num<C>> for Slab<C> {
    type Output = Self;
    /// Both bounds multiplied by a number.
    #[inline(always)]
    fn mul(self, by: Num<C>) -> Self {
        Self { min: self.min * by, max: self.max * by }
    }
}

impl<C: Circuit> Sub<Vec3<C>> for Aabb<C> {
    type Output = Self;
    /// The box relative to a point.
    #[inline(always)]
    fn sub(self, from: Vec3<C>) -> Self {
        Self { x: self.x - from.x, y: self.y - from.y, z: self.z - from.z }
    }
}

impl<C: Circuit> Mul<Vec3<C>> for Aabb<C> {
    type Output = Self;
    /// Each slab multiplied by the coordinate along its axis.
    #[inline(always)]
    fn mul(self, by: Vec3<C>) -> Self {
        Self { x: self.x * by.x, y: self.y * by.y, z: self.z * by.z }
    }
}

impl From<[f32; 3]> for Vec3<Binary32> {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x: x.into(), y: y.into(), z: z.into() }
    }
}

impl From<Vec3<Binary32>> for [f32; 3] {
    fn from(v: Vec3<Binary32>) -> [f32; 3] {
        [v.x.into(), v.y.into(), v.z.into()]
    }
}

impl Aabb<Binary32> {
    /// The box between two corners.
    pub fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        let slab = |axis: usize| Slab { min: min[axis].into(), max: max[axis].into() };
        Self { x: slab(0), y: slab(1), z: slab(2) }
    }
}

impl Triangle<Binary32> {
    /// The triangle with these vertices.
    pub fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        Self { a: a.into(), b: b.into(), c: c.into() }
    }
}
