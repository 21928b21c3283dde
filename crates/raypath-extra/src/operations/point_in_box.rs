//! A point against four boxes: range search, point location, and where rays begin in a hierarchy.
//!
//! Adds nothing: its 24 comparators in stage 4 are those that the slab method has for four boxes.

use crate::{draw, exact};
use rand::{Rng, RngExt};
use raypath_lab::{Registered, Study, inventory};
use raypath_ops::{Aabb, Binary32, Bit, Circuit, Flags, Num, Operation, Slab, Vec3, array_of, bundle};

/// Which of four boxes a point is in.
///
/// A box has its faces: a point is inside where min ≤ coordinate ≤ max along all axes. With a NaN, in the point or a
/// bound, it is not; nor in a box whose min exceeds its max. -0 equals +0, infinities are numbers like others.
///
/// ```
/// use raypath_extra::point_in_box::{PointInBox, PointInBoxInput};
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
    /// A point and four boxes, on the same ports as a ray's boxes.
    pub struct PointInBoxInput<C> {
        /// The point.
        pub point: Vec3<C>,
        /// The boxes.
        pub aabb: [Aabb<C>; 4],
    }
}

bundle! {
    /// The boxes that have it.
    pub struct PointInBoxOutput<C> {
        /// Whether the point is in box i.
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

inventory::submit!(Registered(|| Study::of(PointInBox)
    .purpose("a point against four boxes: range search, point location")
    .stimulus(stimulus)
    .oracle("ordered integers", judge)
    .into()));

/// Four boxes, and a point of one of them or beside it by one place.
pub fn stimulus(rng: &mut impl Rng) -> PointInBoxInput<Binary32> {
    let mut aabb = [(); 4].map(|()| draw::aabb(rng));
    let mut point = draw::point_of(rng, aabb[0]);
    for coordinate in &mut point {
        *coordinate = match rng.random_range(0..16) {
            0 => coordinate.next_up(),
            1 => coordinate.next_down(),
            2 => -*coordinate,
            3 if rng.random_bool(0.3) => draw::edge(rng),
            _ => *coordinate,
        };
    }
    for slab in aabb.iter_mut().flat_map(|aabb| [&mut aabb.x, &mut aabb.y, &mut aabb.z]) {
        match rng.random_range(0..64) {
            0 => slab.min = draw::edge(rng).into(),
            1 => slab.max = draw::edge(rng).into(),
            2 => (slab.min, slab.max) = (f32::NEG_INFINITY.into(), f32::INFINITY.into()),
            _ => {}
        }
    }
    PointInBoxInput { point: point.into(), aabb }
}

/// Looks for each coordinate's place among all numbers, which must be between those of the bounds.
///
/// # Errors
/// A box about which the answer is wrong.
pub fn judge(job: &PointInBoxInput<Binary32>, answer: &PointInBoxOutput<Binary32>) -> Result<(), String> {
    let Vec3 { x, y, z } = job.point;
    for (i, (aabb, found)) in job.aabb.iter().zip(answer.is_inside.to_array()).enumerate() {
        let expected = [(x, aabb.x), (y, aabb.y), (z, aabb.z)].into_iter().all(|(coordinate, slab)| {
            match [slab.min, coordinate, slab.max].map(exact::order) {
                [Some(min), Some(at), Some(max)] => (min..=max).contains(&at),
                _ => false,
            }
        });
        if found != expected {
            return Err(format!("is_inside[{i}] is {found}, but the point is {}", if expected { "in" } else { "out" }));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{check, jobs};

    check!(PointInBox, PointInBoxInput, PointInBoxOutput);

    fn inside(point: [f32; 3], min: [f32; 3], max: [f32; 3]) -> bool {
        let job = PointInBoxInput { point: point.into(), aabb: [Aabb::new(min, max); 4] };
        let (answer, ()) = PointInBox.run(Binary32, job, ());
        judge(&job, &answer).expect("a right answer");
        answer.is_inside.to_array()[0]
    }

    #[test]
    fn points_at_the_edges() {
        let (inf, nan, least) = (f32::INFINITY, f32::NAN, f32::from_bits(1));
        assert!(inside([0.0, 1.0, -0.0], [0.0; 3], [1.0; 3]), "faces belong to the box");
        assert!(inside([0.0; 3], [-0.0; 3], [-0.0; 3]), "a flat box has its points");
        assert!(!inside([0.5, 0.5, -least], [0.0; 3], [1.0; 3]), "just beside");
        assert!(inside([inf, 0.0, -inf], [-inf; 3], [inf; 3]), "all of space");
        assert!(!inside([nan, 0.0, 0.0], [-inf; 3], [inf; 3]), "no place");
        assert!(!inside([0.5; 3], [0.0, nan, 0.0], [1.0; 3]) && !inside([0.5; 3], [0.0; 3], [1.0, 1.0, nan]));
        assert!(!inside([0.5; 3], [1.0; 3], [0.0; 3]), "inside out");
    }

    #[test]
    fn wrong_answers_are_refused() {
        let mut inside = [0; 2];
        for job in jobs(stimulus, 1000) {
            let (right, ()) = PointInBox.run(Binary32, job, ());
            inside[usize::from(right.is_inside.to_array()[0])] += 1;
            for i in 0..4 {
                let mut wrong = right;
                wrong.is_inside.0[i] = !wrong.is_inside.0[i];
                assert!(judge(&job, &wrong).is_err());
            }
        }
        assert!(inside.iter().all(|&jobs| jobs > 200), "both answers are frequent: {inside:?}");
    }
}
