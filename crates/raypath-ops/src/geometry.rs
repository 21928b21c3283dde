//! Vectors, boxes and triangles.

use crate::{Binary32, Circuit, Num, Word, bundle};
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

/// Implements operators that apply to each field.
macro_rules! fieldwise {
    ($($(#[$doc:meta])* $of:ident: $operator:ident::$method:ident($other:ident: $type:ty) {
        $($field:ident: $operand:expr),*
    })*) => {$(
        impl<C: Circuit> $operator<$type> for $of<C> {
            type Output = Self;
            $(#[$doc])*
            #[inline(always)]
            fn $method(self, $other: $type) -> Self {
                Self { $($field: self.$field.$method($operand)),* }
            }
        }
    )*};
}

fieldwise! {
    Vec3: Mul::mul(by: Num<C>) { x: by, y: by, z: by }
    Vec3: Sub::sub(other: Self) { x: other.x, y: other.y, z: other.z }
    /// Both bounds relative to a coordinate.
    Slab: Sub::sub(from: Num<C>) { min: from, max: from }
    /// Both bounds multiplied by a number.
    Slab: Mul::mul(by: Num<C>) { min: by, max: by }
    /// The box relative to a point.
    Aabb: Sub::sub(from: Vec3<C>) { x: from.x, y: from.y, z: from.z }
    /// Each slab multiplied by the coordinate along its axis.
    Aabb: Mul::mul(by: Vec3<C>) { x: by.x, y: by.y, z: by.z }
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
