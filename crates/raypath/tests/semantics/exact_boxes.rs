//! Boxes in exact arithmetic: if no operation rounds, the outcome is that of geometry. A box is hit if a point of the
//! ray, within its extent, is in all three closed slabs.

use crate::semantics::answers::{Hits, INF, answers, hits, quadbox, ray};
use crate::semantics::exact::{Rational, rational, to_f32};
use crate::semantics::random::rng;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath::ops::{Aabb, Rules};

#[derive(Debug, Clone, Copy)]
struct Case {
    origin: [f32; 3],
    direction: [f32; 3],
    extent: f32,
    boxes: [([f32; 3], [f32; 3]); 4],
}

/// The first t in [0, extent] at which the point is in the box.
fn first_point_inside(case: &Case, (low, high): ([f32; 3], [f32; 3])) -> Option<Rational> {
    let (mut from, mut to) = (rational(0.0), (case.extent != INF).then(|| rational(case.extent)));
    for axis in 0..3 {
        let [low, high, origin, d] = [low[axis], high[axis], case.origin[axis], case.direction[axis]].map(rational);
        if d == rational(0.0) {
            if origin < low || high < origin {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - origin) / d, (high - origin) / d);
        from = from.max(a.min(b));
        to = Some(to.map_or(a.max(b), |to| to.min(a.max(b))));
    }
    to.is_none_or(|to| from <= to).then_some(from)
}

fn by_geometry(case: &Case) -> Hits {
    let distances = case.boxes.map(|b| first_point_inside(case, b));
    let mut places = [0, 1, 2, 3];
    places.sort_by_key(|&i| (distances[i].is_none(), distances[i]));
    Hits {
        hit: places.map(|i| distances[i].is_some()),
        tmin: places.map(|i| distances[i].map_or(INF, |t| to_f32(t).expect("exact by choice of numbers")).to_bits()),
        index: places.map(|i| i as u32),
    }
}

/// Powers of two as directions, halves as coordinates: differences have at most 5 bits, and 1/d and its products are
/// exact. Only 1/0 and 0·(1/0) are not binary32 numbers; the rulings decide these cases.
fn random_case(rng: &mut ChaCha8Rng) -> Case {
    let direction = loop {
        let direction = [(); 3].map(|()| {
            let length = [0.0, 0.25, 0.5, 1.0, 1.0, 2.0, 4.0][rng.random_range(0..7)];
            if rng.random() { -length } else { length }
        });
        if direction != [0.0; 3] {
            break direction;
        }
    };
    let halves = |rng: &mut ChaCha8Rng| rng.random_range(-4..=4) as f32 / 2.0;
    let boxes = [(); 4].map(|()| {
        let corners: [(f32, f32); 3] = std::array::from_fn(|_| {
            let a = halves(rng);
            // A third of all slabs are flat.
            (a, if rng.random_bool(0.3) { a } else { halves(rng) })
        });
        (corners.map(|(a, b)| a.min(b)), corners.map(|(a, b)| a.max(b)))
    });
    // Half of all rays aim at a corner of a box; the others start at a random point.
    let corner: [f32; 3] = std::array::from_fn(|axis| {
        let (low, high) = boxes[0];
        if rng.random() { low[axis] } else { high[axis] }
    });
    let before = rng.random_range(-2..=4) as f32 / 2.0;
    let aims = rng.random::<bool>();
    let origin = std::array::from_fn(|axis| if aims { corner[axis] - before * direction[axis] } else { halves(rng) });
    let extent = [INF, INF, INF, 0.0, 0.25, 0.5, 1.0, 2.0, 3.0][rng.random_range(0..9)];
    Case { origin, direction, extent, boxes }
}

#[test]
fn boxes_are_hit_where_geometry_says_so() {
    let mut rng = rng(2);
    let cases: Vec<Case> = (0..12_000).map(|_| random_case(&mut rng)).collect();
    let jobs: Vec<_> = cases
        .iter()
        .map(|case| {
            let aabb = case.boxes.map(|(low, high)| Aabb::new(low, high));
            quadbox(ray(case.origin, case.direction, case.extent), aabb)
        })
        .collect();
    let (mut hit, mut touched, mut flat, mut still) = (0, 0, 0, 0);
    let mut strict = 0;
    let originals = answers(Rules::Chisel, &jobs);
    for ((case, outcome), original) in cases.iter().zip(answers(Rules::Paper, &jobs)).zip(originals) {
        let expected = by_geometry(case);
        assert_eq!(hits(&outcome), expected, "{case:?}");
        strict += usize::from(hits(&original) != expected);
        for aabb in case.boxes {
            let Some(t) = first_point_inside(case, aabb) else { continue };
            hit += 1;
            touched += usize::from(is_touched(case, aabb, t));
            flat += usize::from((0..3).any(|axis| aabb.0[axis] == aabb.1[axis]));
            still += usize::from((0..3).any(|axis| {
                let on_a_face = case.origin[axis] == aabb.0[axis] || case.origin[axis] == aabb.1[axis];
                case.direction[axis] == 0.0 && on_a_face
            }));
        }
    }
    assert!(hit > 5000 && touched > 500 && flat > 1000 && still > 500, "{hit} {touched} {flat} {still}");
    assert!(strict > 1000, "the original differs in {strict}");
}

/// The ray touches the box in one point: no point of the ray after t is in the box.
fn is_touched(case: &Case, (low, high): ([f32; 3], [f32; 3]), t: Rational) -> bool {
    (0..3).any(|axis| {
        let d = case.direction[axis];
        let p = rational(case.origin[axis]) + t * rational(d);
        d > 0.0 && p == rational(high[axis]) || d < 0.0 && p == rational(low[axis])
    })
}
