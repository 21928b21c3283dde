//! Ruling 4: tmin ≤ tmax is a hit, so flat boxes and touched corners are hit; a comparison with NaN is false.

use crate::semantics::answers::{INF, Ray32, at, entry, ray, slabs};
use raypath::ops::{Aabb, Rules};

#[test]
fn flat_boxes_are_hit() {
    for axis in 0..3 {
        let (mut low, mut high) = ([-1.0; 3], [1.0; 3]);
        (low[axis], high[axis]) = (0.0, 0.0);
        let mut origin = [0.0; 3];
        origin[axis] = -2.0;
        let mut direction = [0.0; 3];
        direction[axis] = 1.0;
        let ray = ray(origin, direction, INF);
        assert_eq!(entry(Rules::Paper, ray, Aabb::new(low, high)), at(2.0), "sheet across axis {axis}");
        assert_eq!(entry(Rules::Paper, ray, Aabb::new([0.0; 3], [0.0; 3])), at(2.0), "a point");
        assert_eq!(entry(Rules::Chisel, ray, Aabb::new(low, high)), None, "the original is strict");
    }
}

/// Rays along the diagonals that touch the cube [0, 1]³ in one corner, or pass it at the smallest distance.
#[test]
fn a_touched_edge_or_corner_is_hit() {
    let cube = Aabb::new([0.0; 3], [1.0; 3]);
    // Across the edge x = y = 0: x grows while y falls.
    let touching = |x: f32, z: f32| ray([x, 1.0, z], [1.0, -1.0, 0.5], INF);
    assert_eq!(entry(Rules::Paper, touching(-1.0, -0.25), cube), at(1.0), "an edge");
    assert_eq!(entry(Rules::Paper, touching(-1.0, -0.5), cube), at(1.0), "the corner (0, 0, 0)");
    assert_eq!(entry(Rules::Paper, touching(-1.0, 0.5), cube), at(1.0), "the corner (0, 0, 1)");
    assert_eq!(entry(Rules::Paper, touching((-1.0_f32).next_down(), -0.25), cube), None, "just past the edge");
    assert_eq!(entry(Rules::Paper, touching(-1.0, (-0.5_f32).next_down()), cube), None, "just past the corner");
    assert_eq!(entry(Rules::Chisel, touching(-1.0, -0.25), cube), None, "the original is strict");
}

#[test]
fn tmin_equal_to_tmax_in_every_pair_of_axes() {
    for entered in 0..3 {
        for left in 0..3 {
            for distance in [f32::from_bits(1), 1.0, f32::MAX] {
                let (mut near, mut far) = ([-1.0; 3], [INF; 3]);
                (near[entered], far[left]) = (distance, distance);
                let (ray, aabb) = slabs(near, far, INF);
                assert_eq!(entry(Rules::Paper, ray, aabb), at(distance), "{entered} {left} {distance:e}");
                far[left] = distance.next_down();
                let (ray, aabb) = slabs(near, far, INF);
                assert_eq!(entry(Rules::Paper, ray, aabb), None, "{entered} {left} {distance:e}");
            }
        }
    }
}

/// tmax is a NaN only if all its operands are. (tmin is never a NaN, because zero is one of its operands.)
#[test]
fn a_comparison_with_nan_is_false() {
    let (ray, aabb) = slabs([-1.0; 3], [f32::NAN; 3], 1.0);
    assert_eq!(entry(Rules::Paper, ray, aabb), at(0.0));
    assert_eq!(entry(Rules::Paper, Ray32 { extent: f32::NAN.into(), ..ray }, aabb), None);
}

/// A case in which the rules differ from geometry: beside the box, along an axis with direction 0, both distances are
/// +∞; if all other operands of tmax are +∞ too, ∞ ≤ ∞ is a hit. With a finite bound or extent it is a miss.
#[test]
fn infinity_is_not_greater_than_infinity() {
    let beside = |z: f32| Aabb::new([1.0, -1.0, -1.0], [2.0, 1.0, z]);
    let slow = |extent| ray([0.0; 3], [0.0, 0.0, 2f32.powi(-126)], extent);
    assert_eq!(entry(Rules::Paper, slow(INF), beside(4096.0)), at(INF), "the far distance along z overflows");
    assert_eq!(entry(Rules::Paper, slow(INF), beside(3.0)), None);
    assert_eq!(entry(Rules::Paper, slow(f32::MAX), beside(4096.0)), None);
    assert_eq!(entry(Rules::Chisel, slow(INF), beside(4096.0)), None, "the original is strict");
}
