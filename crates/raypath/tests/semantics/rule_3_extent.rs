//! Ruling 3: tmax is limited by the ray's extent.

use crate::semantics::answers::{INF, Ray32, at, entry, ray, slabs};
use raypath::ops::{Aabb, Rules};

#[test]
fn a_box_is_hit_if_it_is_entered_within_the_extent() {
    for distance in [0.5_f32, 1.0, 3.0, 1e-40, 1e30] {
        for axis in 0..3 {
            let mut near = [-1.0; 3];
            near[axis] = distance;
            for (extent, expected) in [
                (distance.next_down(), None),
                (distance, at(distance)),
                (distance.next_up(), at(distance)),
                (INF, at(distance)),
                (0.0, None),
            ] {
                let (ray, aabb) = slabs(near, [2e30; 3], extent);
                assert_eq!(entry(Rules::Paper, ray, aabb), expected, "distance {distance:e}, extent {extent:e}");
            }
            // The original is strict: a ray whose extent just reaches the box misses it.
            let (ray, aabb) = slabs(near, [2e30; 3], distance);
            assert_eq!(entry(Rules::Chisel, ray, aabb), None);
        }
    }
}

#[test]
fn extent_counts_in_lengths_of_the_direction() {
    let ahead = Aabb::new([-1.0, -1.0, 8.0], [1.0, 1.0, 9.0]);
    assert_eq!(entry(Rules::Paper, ray([0.0; 3], [0.0, 0.0, 4.0], 2.0), ahead), at(2.0));
    assert_eq!(entry(Rules::Paper, ray([0.0; 3], [0.0, 0.0, 4.0], 2.0_f32.next_down()), ahead), None);
}

#[test]
fn extent_zero_hits_what_the_origin_is_in() {
    for extent in [0.0, -0.0] {
        let with = |aabb| entry(Rules::Paper, ray([0.0; 3], [1.0, 1.0, 1.0], extent), aabb);
        assert_eq!(with(Aabb::new([-1.0; 3], [1.0; 3])), at(0.0), "inside");
        assert_eq!(with(Aabb::new([0.0; 3], [1.0; 3])), at(0.0), "on a corner");
        assert_eq!(with(Aabb::new([f32::from_bits(1), -1.0, -1.0], [1.0; 3])), None, "ahead");
        let original = entry(Rules::Chisel, ray([0.0; 3], [1.0; 3], extent), Aabb::new([-1.0; 3], [1.0; 3]));
        assert_eq!(original, None, "the original misses for extents up to 0");
    }
}

#[test]
fn a_negative_extent_misses() {
    for extent in [-f32::from_bits(1), -1.0, -INF] {
        let (ray, aabb) = slabs([-2.0; 3], [2.0; 3], 0.0);
        assert_eq!(entry(Rules::Paper, Ray32 { extent: extent.into(), ..ray }, aabb), None, "extent {extent:e}");
    }
}

/// By ruling 2: min returns the number.
#[test]
fn a_nan_extent_is_ignored() {
    for bits in [0x7fc0_0000, 0xffc0_0000, 0x7f80_0001] {
        let extent = f32::from_bits(bits);
        let (ray, aabb) = slabs([3.0; 3], [4.0; 3], INF);
        assert_eq!(entry(Rules::Paper, Ray32 { extent: extent.into(), ..ray }, aabb), at(3.0));
        let (ray, aabb) = slabs([5.0; 3], [4.0; 3], INF);
        assert_eq!(
            entry(Rules::Paper, Ray32 { extent: extent.into(), ..ray }, aabb),
            None,
            "the far distances still bind"
        );
    }
}
