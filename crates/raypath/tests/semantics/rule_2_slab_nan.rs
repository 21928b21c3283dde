//! Ruling 2: max and min ignore a slab distance that is NaN; a zero tmin is +0.0.

use crate::semantics::answers::{INF, Ray32, at, entry, ray, slabs};
use raypath::ops::{Aabb, Rules};

/// A ray along z from z = −2, at (x, y), with zeros of these signs as its other two directions.
fn along_z(x: f32, y: f32, zeros: [f32; 2]) -> Ray32 {
    ray([x, y, -2.0], [zeros[0], zeros[1], 1.0], INF)
}

const SIGNS: [[f32; 2]; 4] = [[0.0, 0.0], [0.0, -0.0], [-0.0, 0.0], [-0.0, -0.0]];

/// The unit cube [0, 1]³ is closed: its faces and edges are inside, for either zero of the direction. Along every axis,
/// so that 0·∞ occurs in near and far distances of x, y and z.
#[test]
fn a_ray_in_a_face_or_an_edge_is_inside() {
    let cube = Aabb::new([0.0; 3], [1.0; 3]);
    let coordinates = [-0.25, 0.0, 0.5, 1.0, 1.25];
    for (forward, sign) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        for (x, y) in coordinates.into_iter().flat_map(|x| coordinates.map(|y| (x, y))) {
            for [zero, other] in SIGNS {
                let (mut origin, mut direction) = ([0.5 - 2.5 * sign, x, y], [sign, zero, other]);
                origin.rotate_right(forward);
                direction.rotate_right(forward);
                let is_inside = [x, y].iter().all(|coordinate| (0.0..=1.0).contains(coordinate));
                let found = entry(Rules::Paper, ray(origin, direction, INF), cube);
                assert_eq!(found, is_inside.then_some(2f32.to_bits()), "{origin:?} {direction:?}");
            }
        }
    }
}

#[test]
fn a_ray_through_a_corner_in_a_face_plane_hits_it() {
    // In the plane z = 0, across the edge x = y = 0 and so through the corner (0, 0, 0).
    let cube = Aabb::new([0.0; 3], [1.0; 3]);
    for zero in [0.0, -0.0] {
        assert_eq!(entry(Rules::Paper, ray([-1.0, 1.0, 0.0], [1.0, -1.0, zero], INF), cube), at(1.0));
        assert_eq!(entry(Rules::Paper, ray([-1.0, 1.0, -0.5], [1.0, -1.0, zero], INF), cube), None);
    }
    // Along the diagonal from one corner to the other: no NaN, but all bounds are met at once.
    assert_eq!(entry(Rules::Paper, ray([-1.0; 3], [1.0; 3], INF), cube), at(1.0));
}

#[test]
fn a_flat_box_is_hit_by_a_ray_in_its_plane() {
    for zeros in SIGNS {
        let sheet = Aabb::new([0.0, -1.0, 0.0], [0.0, 1.0, 1.0]);
        assert_eq!(entry(Rules::Paper, along_z(0.0, 0.0, zeros), sheet), at(2.0), "both distances along x are NaN");
        assert_eq!(entry(Rules::Paper, along_z(0.25, 0.0, zeros), sheet), None);
        let needle = Aabb::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(entry(Rules::Paper, along_z(0.0, 0.0, zeros), needle), at(2.0), "both along x and along y");
    }
}

/// Every set of NaNs among the six distances. The others are 1, 2, 3 and 7, 6, 5, so that each set has its own outcome.
#[test]
fn each_nan_is_ignored_alone_and_with_others() {
    for set in 0..64_u32 {
        let nan_or = |i: u32, value: f32| if set >> i & 1 == 1 { f32::NAN } else { value };
        let near = [nan_or(0, 1.0), nan_or(1, 2.0), nan_or(2, 3.0)];
        let far = [nan_or(3, 7.0), nan_or(4, 6.0), nan_or(5, 5.0)];
        let expected = match set & 7 {
            0..4 => 3.0,
            4 | 5 => 2.0,
            6 => 1.0,
            _ => 0.0,
        };
        let (ray, aabb) = slabs(near, far, 8.0);
        assert_eq!(entry(Rules::Paper, ray, aabb), at(expected), "NaN in {set:06b}");
    }
}

/// tmax is not an output: a box entered exactly at tmax is hit, one entered just after it is not.
#[test]
fn each_nan_is_ignored_in_tmax() {
    for set in 0..16_u32 {
        let nan_or = |i: u32, value: f32| if set >> i & 1 == 1 { f32::NAN } else { value };
        let far = [nan_or(0, 7.0), nan_or(1, 6.0), nan_or(2, 5.0)];
        let extent = nan_or(3, 8.0);
        let left: Vec<f32> = [far[0], far[1], far[2], extent].into_iter().filter(|x| !x.is_nan()).collect();
        for axis in 0..3 {
            let enter = |distance: f32| {
                let mut near = [f32::NAN; 3];
                near[axis] = distance;
                let (ray, aabb) = slabs(near, far, 0.0);
                entry(Rules::Paper, Ray32 { extent: extent.into(), ..ray }, aabb)
            };
            match left.iter().copied().reduce(f32::min) {
                Some(tmax) => {
                    assert_eq!(enter(tmax), at(tmax), "NaN in {set:04b}");
                    assert_eq!(enter(tmax.next_up()), None, "NaN in {set:04b}");
                }
                // Ruling 4: a comparison with NaN is false.
                None => assert_eq!(enter(0.0), None, "nothing is left of tmax"),
            }
        }
    }
}

#[test]
fn all_six_distances_nan_by_zero_times_infinity() {
    // A ray without a direction (software rejects it) on a box that is a point.
    for inf in [INF, -INF] {
        let still = Ray32 { inv: [inf; 3].into(), ..ray([1.0; 3], [1.0; 3], 4.0) };
        assert_eq!(entry(Rules::Paper, still, Aabb::new([1.0; 3], [1.0; 3])), at(0.0));
    }
}

/// NaN also comes from ∞ − ∞ and from a NaN input; payload and sign do not matter.
#[test]
fn any_nan_drops_out() {
    for bits in [0x7fc0_0000, 0xffc0_0000, 0x7f80_0001, 0xffff_ffff] {
        let nan = f32::from_bits(bits);
        let (ray_, aabb) = slabs([nan, 2.0, nan], [nan, 6.0, nan], INF);
        assert_eq!(entry(Rules::Paper, ray_, aabb), at(2.0));
        let nan_inv = Ray32 { inv: [nan, 1.0, 1.0].into(), ..ray_ };
        assert_eq!(
            entry(Rules::Paper, nan_inv, Aabb::new([5.0, 2.0, 1.0], [-5.0, 6.0, 6.0])),
            at(2.0),
            "inv x is a NaN"
        );
    }
    let at_infinity = Ray32 { origin: [INF, 0.0, 0.0].into(), ..ray([0.0; 3], [1.0; 3], INF) };
    assert_eq!(entry(Rules::Paper, at_infinity, Aabb::new([INF, 2.0, 1.0], [INF, 6.0, 6.0])), at(2.0), "∞ − ∞");
}

/// Near distances among −0, +0, less than zero and NaN: tmin is a zero, and it is +0.
#[test]
fn a_zero_tmin_is_plus_zero() {
    let values = [-0.0, 0.0, -1.0, f32::NAN];
    for x in values {
        for y in values {
            for z in values {
                let (ray, aabb) = slabs([x, y, z], [1.0; 3], INF);
                assert_eq!(entry(Rules::Paper, ray, aabb), Some(0), "near {:?}", [x, y, z]);
                // tmax = −0 is not less than tmin = +0.
                let (ray, aabb) = slabs([x, y, z], [-0.0; 3], -0.0);
                assert_eq!(entry(Rules::Paper, ray, aabb), Some(0), "near {:?}, far −0", [x, y, z]);
            }
        }
    }
}

/// The near distance is −0 by arithmetic, 0·(−1), if the ray starts on the face that it leaves.
#[test]
fn a_ray_that_starts_on_a_face_and_looks_back_enters_at_plus_zero() {
    let cube = Aabb::new([0.0; 3], [1.0; 3]);
    for direction in [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]] {
        let origin = direction.map(|d| if d < 0.0 { 1.0 } else { 0.0 });
        assert_eq!(entry(Rules::Paper, ray(origin, direction, INF), cube), Some(0), "{direction:?}");
    }
}
