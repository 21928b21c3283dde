//! Stimulus and oracle of [`PointInBox`]: the oracle compares coordinates and bounds as ordered integers.

use crate::{AnyOperationSpec, OperationSpec, draw, exact};
use rand::{Rng, RngExt};
use raypath_ops::operations::point_in_box::{PointInBox, PointInBoxInput, PointInBoxOutput};
use raypath_ops::{Binary32, Vec3};

/// The specification of [`PointInBox`].
pub fn spec() -> AnyOperationSpec {
    OperationSpec::of(PointInBox)
        .purpose("a point against four boxes: range search, point location")
        .stimulus(stimulus)
        .oracle("ordered integers", check)
        .into()
}

/// Four boxes, and a point that is in one of them or next to it.
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

/// Compares a result with comparisons of ordered integers.
///
/// # Errors
/// The first wrong box.
pub fn check(job: &PointInBoxInput<Binary32>, answer: &PointInBoxOutput<Binary32>) -> Result<(), String> {
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
    use crate::test_support::{check_operation, jobs};
    use raypath_ops::{Aabb, Operation};

    check_operation!(PointInBox, PointInBoxInput, PointInBoxOutput);

    fn inside(point: [f32; 3], min: [f32; 3], max: [f32; 3]) -> bool {
        let job = PointInBoxInput { point: point.into(), aabb: [Aabb::new(min, max); 4] };
        let (answer, ()) = PointInBox.run(Binary32, job, ());
        check(&job, &answer).expect("a right answer");
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
                assert!(check(&job, &wrong).is_err());
            }
        }
        assert!(inside.iter().all(|&jobs| jobs > 200), "both answers are frequent: {inside:?}");
    }
}
