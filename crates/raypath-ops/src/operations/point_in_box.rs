//! A point against four boxes, for range search, point location, and the first node of rays in a hierarchy.
//!
//! A datapath with the operation for a ray and four boxes needs no additional units: both use 24 comparators in stage
//! 4.

use crate::{Aabb, Bit, Circuit, Flags, Num, Operation, Slab, Vec3, bundle};

/// Tests whether a point is in each of four boxes.
///
/// A point is in a box if min ≤ coordinate ≤ max along all axes; the faces belong to the box. A point is not in a box
/// if a coordinate or a bound is NaN, or if a min exceeds its max. -0 equals +0.
///
/// ```
/// use raypath_ops::operations::point_in_box::{PointInBox, PointInBoxInput};
/// use raypath_ops::{Aabb, Binary32, Operation};
///
/// let unit = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let job = PointInBoxInput { point: [1.0, 0.5, 0.0].into(), aabb: [0.0, 0.5, 1.0, 1.5].map(unit) };
/// let (answer, ()) = PointInBox.run(Binary32, job, ());
/// assert_eq!(answer.is_inside.to_array(), [true, true, true, false]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointInBox;

bundle! {
    /// A point and four boxes. The boxes have the ports of [`RayBoxInput`](crate::RayBoxInput).
    pub struct PointInBoxInput<C> {
        /// The point.
        pub point: Vec3<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 4],
    }

    /// The boxes that contain the point.
    pub struct PointInBoxOutput<C> {
        /// Whether the point is in each box.
        pub is_inside: Flags<C, 4>,
    }
}

impl Operation for PointInBox {
    const NAME: &'static str = "point_in_box";
    type Input<C: Circuit> = PointInBoxInput<C>;
    type Output<C: Circuit> = PointInBoxOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: PointInBoxInput<C>, _state: ()) -> (PointInBoxOutput<C>, ()) {
        let PointInBoxInput { point, aabb } = input;

        c.stage(4, "every coordinate against both bounds");
        let inside: [Bit<C>; 4] = array_of!(i => {
            let Aabb { x, y, z } = aabb[i];
            within(point.x, x) & within(point.y, y) & within(point.z, z)
        });
        c.label(format_args!("inside"), &inside);

        (PointInBoxOutput { is_inside: Flags(inside) }, ())
    }
}

#[inline(always)]
fn within<C: Circuit>(coordinate: Num<C>, slab: Slab<C>) -> Bit<C> {
    coordinate.compare(slab.min).greater_or_equal() & coordinate.compare(slab.max).less_or_equal()
}
