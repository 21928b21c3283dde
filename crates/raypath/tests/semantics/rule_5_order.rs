//! Ruling 5: hits before misses, nearer before farther, equal distances by box index; a miss reports +∞.

use crate::semantics::answers::{Box32, Hits, INF, Ray32, answers, hits, quadbox, ray};
use raypath::ops::{Aabb, Rules};

/// A ray along z whose distances are the bounds times 2^126: those of 2^10 and more overflow to +∞.
fn short_ray() -> Ray32 {
    ray([0.0; 3], [0.0, 0.0, 2f32.powi(-126)], INF)
}

/// A box that the ray enters at this distance; +∞ stands for a hit whose distance overflows binary32.
fn box_at(distance: f32) -> Box32 {
    let z = if distance == INF { 1024.0 } else { distance * 2f32.powi(-126) };
    Aabb::new([-1.0, -1.0, z], [1.0, 1.0, 4096.0])
}

/// A box that is missed: beside the ray at the distance `depth`, or behind its origin.
fn missed_at(depth: Option<f32>) -> Box32 {
    match depth {
        Some(depth) => Aabb::new([2.0, 2.0, depth * 2f32.powi(-126)], [3.0, 3.0, 4.0 * 2f32.powi(-126)]),
        None => Aabb::new([-1.0, -1.0, -2.0], [1.0, 1.0, -1.0]),
    }
}

/// The order of the rule: a stable sort of the boxes in the order of their indices.
fn expected(distances: [Option<f32>; 4]) -> Hits {
    let mut places = [0, 1, 2, 3];
    places.sort_by(|&a, &b| match (distances[a], distances[b]) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        (a, b) => b.is_some().cmp(&a.is_some()),
    });
    Hits {
        hit: places.map(|i| distances[i].is_some()),
        tmin: places.map(|i| distances[i].unwrap_or(INF).to_bits()),
        index: places.map(|i| i as u32),
    }
}

/// All 7⁴ quadruples: all 24 orders of distinct distances, all patterns of ties, and misses among all of them.
#[test]
fn every_order_of_distances_ties_and_misses() {
    const CHOICES: [Option<f32>; 7] = [Some(0.0), Some(1.0), Some(2.0), Some(3.0), Some(INF), None, None];
    let mut jobs = Vec::new();
    let mut wanted = Vec::new();
    for pattern in 0..7_usize.pow(4) {
        let chosen = [0, 1, 2, 3].map(|i| pattern / 7_usize.pow(i) % 7);
        let aabb = chosen.map(|choice| match (choice, CHOICES[choice]) {
            (_, Some(distance)) => box_at(distance),
            // A miss that would be the nearest by its entry distance, and one behind.
            (5, None) => missed_at(Some(0.5)),
            (_, None) => missed_at(None),
        });
        jobs.push(quadbox(short_ray(), aabb));
        wanted.push(expected(chosen.map(|choice| CHOICES[choice])));
    }
    for (i, outcome) in answers(Rules::Paper, &jobs).iter().enumerate() {
        assert_eq!(hits(outcome), wanted[i], "job {i}");
    }
}

#[test]
fn the_original_reverses_four_equal_distances() {
    let job = quadbox(short_ray(), [box_at(2.0); 4]);
    assert_eq!(hits(&answers(Rules::Chisel, &[job])[0]).index, [3, 2, 1, 0], "the original's network");
}

/// −0 and +0 are equal distances (and both are reported as +0, by ruling 2).
#[test]
fn zeros_of_both_signs_tie() {
    let plane = |x: f32| Aabb::new([x; 3], [1.0; 3]);
    let aabb = [plane(0.0), plane(-0.0), plane(-1.0), plane(0.0)];
    let found = hits(&answers(Rules::Paper, &[quadbox(ray([0.0; 3], [1.0; 3], INF), aabb)])[0]);
    assert_eq!(found, Hits { hit: [true; 4], tmin: [0; 4], index: [0, 1, 2, 3] });
}
