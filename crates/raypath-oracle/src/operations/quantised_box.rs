//! Stimulus and oracle of [`QuantisedBox`]: slab distances in exact rationals.

mod check;

pub use check::check;

use crate::{AnyOperationSpec, OperationSpec, draw};
use rand::{Rng, RngExt};
use raypath_ops::operations::quantised_box::{OffsetBox, OffsetSlab, QuantisedBox, QuantisedBoxInput, QuantisedNode};
use raypath_ops::{Binary32, Flags, Word};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::check_operation;
    use raypath_ops::{Aabb, Operation, Ray, RayBoxOutput};

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
}
