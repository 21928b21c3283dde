//! Stimulus and oracle of [`QuantisedBox`]: slab distances in exact rationals.

use crate::slabs::{self, Passage, Plane, SortedBox};
use crate::{AnyOperationSpec, OperationSpec, draw, exact};
use num_rational::BigRational;
use rand::{Rng, RngExt};
use raypath_ops::operations::quantised_box::{OffsetBox, OffsetSlab, QuantisedBox, QuantisedBoxInput, QuantisedNode};
use raypath_ops::{Binary32, Flags, RayBoxOutput, Word};

/// The specification of [`QuantisedBox`].
pub fn spec() -> AnyOperationSpec {
    OperationSpec::of(QuantisedBox)
        .purpose("a ray against four boxes of 8 bits a bound: compressed wide nodes")
        .stimulus(stimulus)
        .oracle("exact rationals", check)
        .into()
}

/// A node of one to four boxes and a ray towards one of them, or a node with random fields. Some jobs have a number at
/// the limits of binary32.
pub fn stimulus(rng: &mut impl Rng) -> QuantisedBoxInput<Binary32> {
    let boxes = [(); 4].map(|()| draw::aabb(rng));
    let count = rng.random_range(1..=4);
    let aimed_at = boxes[rng.random_range(0..count)];
    let target = draw::point_of(rng, aimed_at);
    let mut ray = draw::ray_at(rng, target);
    let any = QuantisedNode {
        origin: draw::three(|| draw::whole(rng)).into(),
        scale: draw::three(|| 2.0_f32.powi(rng.random_range(-9..-4))).into(),
        child: [(); 4].map(|()| {
            let [x, y, z] = draw::three(|| OffsetSlab {
                min: Word::truncate(rng.random_range(0..256)),
                max: Word::truncate(rng.random_range(0..256)),
            });
            OffsetBox { x, y, z }
        }),
        used: Flags::from_mask(rng.random_range(0..16)),
    };
    let node = if rng.random_bool(0.2) { Err(()) } else { QuantisedNode::encode(&boxes[..count]).map_err(|_| ()) };
    let mut node = node.unwrap_or(any);
    if rng.random_bool(0.05) {
        let field = [&mut node.origin.x, &mut node.scale.y, &mut ray.origin.z, &mut ray.inv.x, &mut ray.extent];
        *field[rng.random_range(0..5)] = draw::edge(rng).into();
    }
    QuantisedBoxInput { ray, node }
}

/// Compares a result with slab distances in exact rationals, and checks the order of the boxes.
///
/// # Errors
/// The first wrong box, or the order of the boxes.
pub fn check(job: &QuantisedBoxInput<Binary32>, answer: &RayBoxOutput<Binary32>) -> Result<(), String> {
    let used = job.node.used.to_array();
    let boxes = [0, 1, 2, 3].map(|i| SortedBox {
        hit: answer.is_intersect.to_array()[i],
        tmin: answer.tmin[i],
        index: answer.box_index[i].into(),
    });
    if let Some(SortedBox { index, .. }) = boxes.iter().find(|found| found.hit && !used[found.index as usize]) {
        return Err(format!("box {index} is hit, but is not used"));
    }
    slabs::check(boxes, |index| if used[index] { passage(job, index) } else { None })
}

/// The passage of a ray through the box of a child, from the encoded offsets and scale. `None` if no error bound is
/// known, because a coordinate or a scale is too large, even if the differences are small.
fn passage(job: &QuantisedBoxInput<Binary32>, index: usize) -> Option<Passage> {
    let QuantisedBoxInput { ray, node } = job;
    let (from, to) = (exact::values(ray.origin)?, exact::values(node.origin)?);
    let scale = exact::values(node.scale)?;
    let OffsetBox { x, y, z } = node.child[index];
    let is_large = |number: &BigRational| exact::absolute(number) > exact::power(50);
    if scale.iter().chain(&from).chain(&to).any(is_large) {
        return None;
    }
    let five_ulps = exact::power(-24) * BigRational::from_integer(5.into());
    let planes = std::array::from_fn(|k| {
        let (slab, relative) = ([x, y, z][k], &to[k] - &from[k]);
        [slab.min, slab.max].map(|offset| {
            let steps = BigRational::from_integer(u32::from(offset).into()) * &scale[k];
            let bound = &five_ulps * (exact::absolute(&relative) + exact::absolute(&steps));
            Plane { at: &relative + steps, bound }
        })
    });
    Passage::new(ray, planes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{check_operation, jobs};
    use raypath_ops::{Aabb, Operation, Ray};

    check_operation!(QuantisedBox, QuantisedBoxInput, RayBoxOutput);

    fn run(ray: Ray<Binary32>, boxes: &[Aabb<Binary32>]) -> RayBoxOutput<Binary32> {
        let job = QuantisedBoxInput { ray, node: QuantisedNode::encode(boxes).expect("a node") };
        let (answer, ()) = QuantisedBox.run(Binary32, job, ());
        check(&job, &answer).expect("a right answer");
        answer
    }

    #[test]
    fn by_hand() {
        let unit = |z: f32| Aabb::new([-1.0, -1.0, z], [1.0, 1.0, z + 1.0]);
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 2.0], f32::INFINITY).expect("a ray");
        let answer = run(ray, &[unit(9.0), unit(1.0), unit(-5.0)]);
        assert_eq!(answer.is_intersect.to_array(), [true, true, false, false], "the fourth box is not used");
        assert_eq!(answer.box_index.map(u32::from), [1, 0, 2, 3]);
        assert_eq!(answer.tmin.map(f32::from), [0.5, 4.5, f32::INFINITY, f32::INFINITY]);
    }

    /// The ray starts so far away that all planes of the node are at the same distance.
    #[test]
    fn unused_children_are_missed() {
        let ray = Ray::new([0.5, 0.5, -1e12], [0.0, 0.0, 1.0], f32::INFINITY).expect("a ray");
        let answer = run(ray, &[Aabb::new([0.0; 3], [1.0; 3])]);
        assert_eq!(answer.is_intersect.to_array(), [true, false, false, false]);
        assert_eq!(answer.box_index.map(u32::from), [0, 1, 2, 3]);
    }

    /// Rays parallel to two axes: outside a box, in a face, inside.
    #[test]
    fn parallel_rays() {
        let cube = Aabb::new([1.0; 3], [2.0; 3]);
        for (x, hits) in [(0.875, false), (1.0, true), (1.5, true), (2.0, true), (2.125, false)] {
            for zero in [0.0, -0.0] {
                for (y, towards) in [(0.0, 1.0), (3.0, -1.0)] {
                    let ray = Ray::new([x, y, 1.5], [zero, towards, zero], 10.0).expect("a ray");
                    let answer = run(ray, &[cube, Aabb::new([8.0; 3], [9.0; 3])]);
                    assert_eq!(answer.is_intersect.to_array(), [hits, false, false, false], "{x} {zero} {towards}");
                    assert_eq!(f32::from(answer.tmin[0]), if hits { 1.0 } else { f32::INFINITY });
                }
            }
        }
    }
    /// If the product of scale and inverse overflows, an offset of 0 gives a NaN, which is ignored, and no bound holds.
    #[test]
    fn an_overflowing_product_has_no_bound() {
        let ray = Ray::new([0.5, 5.0, -5.0], [0.0, 0.5, 1.0], f32::INFINITY).expect("a ray");
        let slab = |max: u32| OffsetSlab { min: Word::truncate(0), max: Word::truncate(max) };
        let child = [OffsetBox { x: slab(1), y: slab(0), z: slab(1) }; 4];
        let node = QuantisedNode {
            origin: [0.0; 3].into(),
            scale: [1.0, f32::MAX, 1.0].into(),
            child,
            used: Flags::from_mask(1),
        };
        let job = QuantisedBoxInput { ray, node };
        let (answer, ()) = QuantisedBox.run(Binary32, job, ());
        assert!(answer.is_intersect.to_array()[0]);
        assert_eq!(check(&job, &answer), Ok(()));
    }

    #[test]
    fn wrong_answers_are_refused() {
        let (mut certain, mut hits) = (0, 0);
        for job in jobs(stimulus, 1000) {
            let (right, ()) = QuantisedBox.run(Binary32, job, ());
            for place in 0..4 {
                let hit = right.is_intersect.to_array()[place];
                let index = u32::from(right.box_index[place]) as usize;
                let mut wrong = right;
                wrong.box_index[place] = right.box_index[(place + 1) % 4];
                assert!(check(&job, &wrong).is_err(), "a box occurs twice");
                let used = job.node.used.to_array()[index];
                if !used || passage(&job, index).is_some_and(|passage| passage.hit().is_some()) {
                    certain += 1;
                    hits += i32::from(hit);
                    let mut wrong = right;
                    wrong.is_intersect.0[place] = (!hit).into();
                    assert!(check(&job, &wrong).is_err(), "{job:?} {wrong:?}");
                    let mut wrong = right;
                    wrong.tmin[place] = (f32::from(right.tmin[place]) * 1.01 + 0.1).into();
                    assert!(!hit || check(&job, &wrong).is_err(), "{job:?} {wrong:?}");
                }
            }
        }
        assert!(certain > 3500 && (500..2500).contains(&hits), "{certain} of 4000 certain, {hits} hits");
    }
}
