//! The oracle of [`QuantisedBox`](raypath_ops::operations::quantised_box::QuantisedBox), in exact rationals.

use super::{OffsetBox, QuantisedBoxInput};
use crate::exact;
use crate::slabs::{self, Passage, Plane, SortedBox};
use num_rational::BigRational;
use raypath_ops::{Binary32, RayBoxOutput};

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
    use super::super::{OffsetSlab, QuantisedBox, QuantisedNode, stimulus};
    use super::*;
    use crate::test_support::jobs;
    use raypath_ops::{Flags, Operation, Ray, Word};

    /// If the product of scale and inverse overflows, an offset of 0 gives a NaN, which is ignored. No error bound
    /// holds.
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
