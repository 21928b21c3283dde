//! Ruling 1: the sign of the direction is the sign bit of inv.

use crate::semantics::answers::{Box32, INF, Ray32, at, entry, ray};
use raypath::ops::{Aabb, Rules};

/// A ray along z that does not move along `axis`: its direction there is `dir`, its inverse `inv`.
fn still(axis: usize, dir: f32, inv: f32) -> Ray32 {
    let [mut dirs, mut invs] = [[0.0, 0.0, 0.0], [INF, INF, INF]];
    let forward = if axis == 2 { 0 } else { 2 };
    (dirs[forward], invs[forward]) = (1.0, 1.0);
    (dirs[axis], invs[axis]) = (dir, inv);
    Ray32 { dir: dirs.into(), inv: invs.into(), ..ray([0.0; 3], [0.0, 0.0, 1.0], INF) }
}

fn around_origin() -> Box32 {
    Aabb::new([-1.0; 3], [1.0; 3])
}

#[test]
fn minus_zero_swaps_so_that_a_box_around_the_origin_is_hit() {
    for axis in 0..3 {
        let backwards = still(axis, -0.0, -INF);
        assert_eq!(entry(Rules::Paper, backwards, around_origin()), at(0.0), "axis {axis}");
        // The original compares with zero and does not exchange: near = +∞, far = −∞.
        assert_eq!(entry(Rules::Chisel, backwards, around_origin()), None, "axis {axis}");
        // +0 does not exchange.
        for rules in [Rules::Paper, Rules::Chisel] {
            assert_eq!(entry(rules, still(axis, 0.0, INF), around_origin()), at(0.0), "axis {axis}, {rules}");
        }
    }
}

#[test]
fn all_directions_of_zeros_and_ones_hit_a_box_around_the_origin() {
    let values = [1.0, 0.0, -0.0, -1.0];
    for x in values {
        for y in values {
            for z in values {
                if [x, y, z] != [0.0; 3] {
                    let ray = ray([0.0; 3], [x, y, z], INF);
                    assert_eq!(entry(Rules::Paper, ray, around_origin()), at(0.0), "direction {:?}", [x, y, z]);
                }
            }
        }
    }
}

/// Slab distances on the axis are 2 and 3: in order only if the exchange follows the sign of inv.
#[test]
fn the_sign_of_inv_decides_where_dir_says_otherwise() {
    for axis in 0..3 {
        for (dir, inv, rules, expected) in [
            (-1.0, 1.0, Rules::Paper, at(2.0)),
            (-0.0, 1.0, Rules::Paper, at(2.0)),
            (f32::NAN, 1.0, Rules::Paper, at(2.0)),
            // The original exchanges for dir < 0 and for a NaN: near 3, far 2.
            (-1.0, 1.0, Rules::Chisel, None),
            (f32::NAN, 1.0, Rules::Chisel, None),
            (-0.0, 1.0, Rules::Chisel, at(2.0)),
            (1.0, -1.0, Rules::Paper, at(2.0)),
            (0.0, -1.0, Rules::Paper, at(2.0)),
            (1.0, -1.0, Rules::Chisel, None),
        ] {
            let (mut low, mut high) = ([-9.0; 3], [9.0; 3]);
            (low[axis], high[axis]) = if inv > 0.0 { (2.0, 3.0) } else { (-3.0, -2.0) };
            let found = entry(rules, still(axis, dir, inv), Aabb::new(low, high));
            assert_eq!(found, expected, "{axis} {dir} {inv} {rules}");
        }
    }
}

/// inv = −0 comes from an infinite direction; its sign bit exchanges too.
#[test]
fn the_smallest_magnitudes_have_signs() {
    for axis in 0..3 {
        for tiny in [0.0, f32::from_bits(1), f32::MIN_POSITIVE] {
            let huge_box = Aabb::new([-f32::MAX; 3], [f32::MAX; 3]);
            for inv in [tiny, -tiny] {
                assert_eq!(entry(Rules::Paper, still(axis, 1.0, inv), huge_box), at(0.0), "axis {axis}, inv {inv:e}");
            }
        }
    }
}
