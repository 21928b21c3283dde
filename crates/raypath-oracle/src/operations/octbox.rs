//! Stimulus and oracle of [`Octbox`]: slab distances in exact rationals, and two jobs of four boxes.

use crate::slabs::{self, Passage, Plane, SortedBox};
use crate::{AnyOperationSpec, OperationSpec, draw, exact};
use rand::{Rng, RngExt};
use raypath_ops::operations::octbox::{Octbox, OctboxInput, OctboxOutput};
use raypath_ops::{Aabb, Binary32, Operation, Ray, RayBox, RayBoxInput, Rules, Slab};

/// The specification of [`Octbox`].
pub fn spec() -> AnyOperationSpec {
    OperationSpec::of(Octbox)
        .purpose("a ray against eight boxes a job")
        .stimulus(stimulus)
        .oracle("exact rationals, two quadboxes", check)
        .into()
}

/// Eight boxes and a ray towards one of them. Some boxes are equal, inverted, or have bounds at the limits of binary32.
pub fn stimulus(rng: &mut impl Rng) -> OctboxInput<Binary32> {
    let mut aabb = [(); 8].map(|()| draw::aabb(rng));
    let aimed_at = aabb[rng.random_range(0..8)];
    let target = draw::point_of(rng, aimed_at);
    let mut ray = draw::ray_at(rng, target);
    if rng.random_bool(0.3) {
        for _ in 0..4 {
            aabb[rng.random_range(0..8)] = aabb[rng.random_range(0..8)];
        }
    }
    if rng.random_bool(0.1) {
        let slab = &mut aabb[rng.random_range(0..8)].y;
        (slab.min, slab.max) = (draw::edge(rng).into(), draw::edge(rng).into());
    }
    if rng.random_bool(0.03) {
        let field = [&mut ray.origin.x, &mut ray.inv.y, &mut ray.inv.z, &mut ray.extent];
        *field[rng.random_range(0..4)] = draw::edge(rng).into();
    }
    OctboxInput { ray, aabb }
}

/// Compares a result with two oracles: with slab distances in exact rationals; and bit by bit with the boxes in two
/// jobs of [`RayBox`], which is verified by golden vectors, sorted by the standard library.
///
/// # Errors
/// The first wrong box, or the order of the boxes.
pub fn check(job: &OctboxInput<Binary32>, answer: &OctboxOutput<Binary32>) -> Result<(), String> {
    let boxes = std::array::from_fn::<_, 8, _>(|i| SortedBox {
        hit: answer.octbox_is_intersect.to_array()[i],
        tmin: answer.octbox_tmin[i],
        index: answer.octbox_box_index[i].into(),
    });
    slabs::check(boxes, |index| passage(&job.ray, &job.aabb[index]))?;
    check_bits(job, answer)
}

/// The passage of a ray through a box. A distance has three roundings: of the difference, of `inv`, and of the product.
fn passage(ray: &Ray<Binary32>, aabb: &Aabb<Binary32>) -> Option<Passage> {
    let origin = exact::values(ray.origin)?;
    let plane = |bound, k: usize| {
        let at = exact::value(bound)? - &origin[k];
        Some(Plane { bound: exact::absolute(&at) * exact::power(-22), at })
    };
    let planes = |slab: Slab<Binary32>, k| Some([plane(slab.min, k)?, plane(slab.max, k)?]);
    Passage::new(ray, [planes(aabb.x, 0)?, planes(aabb.y, 1)?, planes(aabb.z, 2)?])
}

fn check_bits(job: &OctboxInput<Binary32>, answer: &OctboxOutput<Binary32>) -> Result<(), String> {
    let mut expected = Vec::new();
    for (first, half) in [(0, [0, 1, 2, 3]), (4, [4, 5, 6, 7])] {
        let four = RayBoxInput { ray: job.ray, aabb: half.map(|i| job.aabb[i]) };
        let (four, ()) = RayBox { rules: Rules::Paper }.run(Binary32, four, ());
        for (i, hit) in four.is_intersect.to_array().into_iter().enumerate() {
            expected.push((hit, four.tmin[i].to_bits(), first + u32::from(four.box_index[i])));
        }
    }
    // Numbers that are not negative have the order of their bits.
    expected.sort_by_key(|&(hit, tmin, index)| (tmin, !hit, index));
    for (i, expected) in expected.into_iter().enumerate() {
        let hit = answer.octbox_is_intersect.to_array()[i];
        let found = (hit, answer.octbox_tmin[i].to_bits(), u32::from(answer.octbox_box_index[i]));
        if found != expected {
            return Err(format!("position {i} has (hit, tmin, index) {found:x?}, expected {expected:x?}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{check_operation, jobs};
    use raypath_ops::{Num, Word};

    check_operation!(Octbox, OctboxInput, OctboxOutput);

    #[test]
    fn boxes_in_a_row() {
        let unit = |z: f32| Aabb::new([-1.0, -1.0, z], [1.0, 1.0, z + 1.0]);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 2.0], f32::INFINITY).expect("a ray");
        let job = OctboxInput { ray, aabb: [9.0, 5.0, -5.0, 5.0, -0.5, 1.0, -9.0, 3.0].map(unit) };
        let (answer, ()) = Octbox.run(Binary32, job, ());
        check(&job, &answer).expect("a right answer");
        assert_eq!(answer.octbox_box_index.map(u32::from), [4, 5, 7, 1, 3, 0, 2, 6]);
        let inf = f32::INFINITY;
        assert_eq!(answer.octbox_tmin.map(f32::from), [0.0, 0.5, 1.5, 2.5, 2.5, 4.5, inf, inf]);
        assert_eq!(answer.octbox_is_intersect.to_array(), [true, true, true, true, true, true, false, false]);
    }

    #[test]
    fn wrong_answers_are_refused() {
        let (mut hits, mut certain) = ([0; 9], 0);
        for job in jobs(stimulus, 1000) {
            let (right, ()) = Octbox.run(Binary32, job, ());
            hits[right.octbox_is_intersect.to_array().into_iter().filter(|&hit| hit).count()] += 1;
            for i in 0..8 {
                certain += usize::from(passage(&job.ray, &job.aabb[i]).is_some_and(|passage| passage.hit().is_some()));
                let (mut hit, mut tmin, mut index) = (right, right, right);
                hit.octbox_is_intersect.0[i] = !hit.octbox_is_intersect.0[i];
                tmin.octbox_tmin[i] = Num::from_bits(right.octbox_tmin[i].to_bits() ^ 1);
                index.octbox_box_index[i] = Word::truncate(u32::from(right.octbox_box_index[i]) ^ 4);
                assert!([hit, tmin, index].iter().all(|wrong| check(&job, wrong).is_err()));
            }
        }
        assert!(hits[..5].iter().all(|&jobs| jobs > 50), "jobs by how many boxes are hit: {hits:?}");
        assert!(certain > 7000, "{certain} of 8000 boxes are hit or missed by more than the bound");
    }
}
