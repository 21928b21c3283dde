//! Ruling 6: U ≥ 0, V ≥ 0, W ≥ 0, t_denom ≠ 0 and t_num > 0; any NaN is a miss.
//!
//! The ray starts at 0 and points along z without shear, so a vertex's x and y enter U, V, W unchanged and its z is its
//! depth.

use crate::semantics::answers::{INF, answer, answers, ray};
use crate::semantics::oracle::TriangleSteps;
use crate::semantics::random::rng;
use rand::RngExt;
use raypath::ops::{Job, Outcome, RayTriangleInput, Rules, Triangle};

type Vertices = [[f32; 3]; 3];
const NAN: f32 = f32::NAN;

/// Around the ray, facing it, at depth 1: U = 1, V = 2, W = 1.
const FRONT: Vertices = [[-1.0, -1.0, 1.0], [0.0, 1.0, 1.0], [1.0, -1.0, 1.0]];

fn job([a, b, c]: Vertices) -> RayTriangleInput<raypath::ops::Binary32> {
    let mut ray = ray([0.0; 3], [0.0, 0.0, 1.0], INF);
    // With zero shear, −0 − 0·z can be −0 and 0·∞ is NaN: infinite depths have their own test.
    ray.shear = [0.0, 0.0, 1.0].into();
    RayTriangleInput { ray, triangle: Triangle::new(a, b, c) }
}

fn is_hit(rules: Rules, vertices: Vertices) -> bool {
    let Outcome::Triangle(outcome) = answer(rules, Job::Triangle(job(vertices))) else { unreachable!() };
    outcome.triangle_hit.into()
}

fn steps(vertices: Vertices) -> TriangleSteps {
    TriangleSteps::of(&job(vertices))
}

/// The same triangle starting at each vertex, so that a case for U is also a case for V and for W.
fn rotations(vertices: Vertices) -> [Vertices; 3] {
    let [a, b, c] = vertices;
    [[a, b, c], [c, a, b], [b, c, a]]
}

fn at_depth(depth: f32, vertices: Vertices) -> Vertices {
    vertices.map(|[x, y, _]| [x, y, depth])
}

/// The ray passes through edge BC: U is a zero of either sign, and both are hits.
#[test]
fn an_edge_is_hit_whichever_zero_it_gives() {
    let plus = [[-1.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, -1.0, 1.0]];
    let minus = [[1.0, 0.0, 1.0], [0.0, -2.0, 1.0], [0.0, 1.0, 1.0]];
    for (vertices, bits) in [(plus, 0), (minus, 0x8000_0000)] {
        assert_eq!(steps(vertices).u.to_bits(), bits);
        for (i, vertices) in rotations(vertices).into_iter().enumerate() {
            let TriangleSteps { u, v, w, .. } = steps(vertices);
            assert_eq!([u, v, w][i].to_bits(), bits, "rotation {i} moves the zero from U to V to W");
            assert!([u, v, w].iter().all(|&x| x >= 0.0));
            assert!(is_hit(Rules::Paper, vertices), "{u:e} {v:e} {w:e}");
        }
    }
}

/// The ray passes through vertex A: V and W are zeros. All four pairs of signs.
#[test]
fn a_vertex_is_hit_whichever_zeros_it_gives() {
    let mut seen = std::collections::HashSet::new();
    for signs in 0..4_u32 {
        let zero = |bit: u32| if signs >> bit & 1 == 1 { -0.0 } else { 0.0 };
        for (b, c) in [
            ([-1.0, 1.0], [1.0, 1.0]),
            ([1.0, 1.0], [1.0, -1.0]),
            ([1.0, -1.0], [-1.0, -1.0]),
            ([-1.0, -1.0], [-1.0, 1.0]),
        ] {
            let vertices = [[zero(0), zero(1), 1.0], [b[0], b[1], 1.0], [c[0], c[1], 1.0]];
            for vertices in rotations(vertices) {
                let TriangleSteps { u, v, w, .. } = steps(vertices);
                let zeros: Vec<u32> = [u, v, w].into_iter().filter(|x| *x == 0.0).map(f32::to_bits).collect();
                assert_eq!(zeros.len(), 2, "{u:e} {v:e} {w:e}");
                assert!(is_hit(Rules::Paper, vertices), "{u:e} {v:e} {w:e}");
                seen.insert(zeros);
            }
        }
    }
    assert!(seen.len() >= 3, "zeros of both signs came up: {seen:?}");
}

/// The smallest negative number: U = −2^-149.
#[test]
fn any_negative_edge_misses() {
    let tiny = f32::from_bits(1);
    let grazing = [[-1.0, 0.0, 1.0], [-tiny, 1.0, 1.0], [0.0, -1.0, 1.0]];
    for (i, vertices) in rotations(grazing).into_iter().enumerate() {
        let TriangleSteps { u, v, w, t_num, t_denom } = steps(vertices);
        assert_eq!([u, v, w][i], -tiny);
        assert!(t_denom > 0.0 && t_num > 0.0);
        assert!(!is_hit(Rules::Paper, vertices));
    }
}

#[test]
fn a_nan_among_the_edges_misses_but_hits_in_the_original() {
    for place in 0..3 {
        for axis in 0..2 {
            let mut vertices = FRONT;
            vertices[place][axis] = NAN;
            let TriangleSteps { u, v, w, .. } = steps(vertices);
            let nans = [u, v, w].map(f32::is_nan);
            assert_eq!(nans, [0, 1, 2].map(|edge| edge != place), "U, V, W not of the vertex's own edge");
            assert!(!is_hit(Rules::Paper, vertices));
            assert!(is_hit(Rules::Chisel, vertices), "the original: NaN hits");
        }
    }
    // U alone: C at infinity along x while B has y = 0, so that Cx·By = ∞·0.
    let alone = [[-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [INF, -1.0, 1.0]];
    for (i, vertices) in rotations(alone).into_iter().enumerate() {
        let TriangleSteps { u, v, w, .. } = steps(vertices);
        assert!([u, v, w][i].is_nan());
        assert!(!is_hit(Rules::Paper, vertices));
    }
}

#[test]
fn a_zero_t_num_misses_but_hits_in_the_original() {
    for (depth, bits) in [(0.0, 0), (-0.0, 0x8000_0000)] {
        for vertices in rotations(at_depth(depth, FRONT)) {
            assert_eq!(steps(vertices).t_num.to_bits(), bits, "the origin is in the triangle");
            assert!(!is_hit(Rules::Paper, vertices));
            assert!(is_hit(Rules::Chisel, vertices), "the original: ±0 hits");
        }
    }
}

#[test]
fn only_a_positive_t_num_hits() {
    let least = f32::from_bits(1);
    for (depth, paper) in [(1.0, true), (least, true), (f32::MAX, true), (-least, false), (-1.0, false)] {
        let vertices = at_depth(depth, FRONT);
        assert_eq!(steps(vertices).t_num > 0.0, paper);
        assert_eq!(is_hit(Rules::Paper, vertices), paper, "depth {depth:e}");
        assert_eq!(is_hit(Rules::Chisel, vertices), paper, "depth {depth:e}");
    }
}

/// U, V, W are positive numbers; only the depths make t_num a NaN, by +∞ and −∞.
#[test]
fn a_nan_t_num_misses_but_hits_in_the_original() {
    let mut input = job(FRONT);
    for place in 0..3 {
        // x and y are no NaN, because their shear of 0 times z stays 0. The depth overflows in Sz·z.
        input.ray.shear = [0.0, 0.0, f32::MAX].into();
        let mut vertices = at_depth(2.0, FRONT);
        vertices[place][2] = -2.0;
        let [a, b, c] = vertices;
        input.triangle = Triangle::new(a, b, c);
        let TriangleSteps { u, v, w, t_num, t_denom } = TriangleSteps::of(&input);
        assert!(u > 0.0 && v > 0.0 && w > 0.0 && t_denom > 0.0 && t_num.is_nan());
        for (rules, hit) in [(Rules::Paper, false), (Rules::Chisel, true)] {
            let Outcome::Triangle(outcome) = answer(rules, Job::Triangle(input)) else { unreachable!() };
            assert_eq!(bool::from(outcome.triangle_hit), hit, "{rules}");
            assert_eq!(outcome.t_num.to_bits(), 0x7fc0_0000);
        }
    }
}

#[test]
fn infinite_edges_and_depths_are_no_nan_and_can_hit() {
    let wide = FRONT.map(|[x, y, z]| [x * 1e30, y * 1e30, z]);
    let TriangleSteps { u, t_denom, t_num, .. } = steps(wide);
    assert_eq!([u, t_denom, t_num], [INF; 3]);
    assert!(is_hit(Rules::Paper, wide));
    assert!(!is_hit(Rules::Paper, at_depth(-1.0, wide)), "t_num is −∞");
}

/// The rule for all classes of U, V, W, t_num and t_denom, with each condition as the only one that fails.
#[test]
fn the_rule_over_zeros_nans_and_infinities() {
    let mut rng = rng(6);
    let values = [0.0, -0.0, 1.0, -1.0, 2.0, -2.0, f32::MAX, NAN, INF, -INF];
    let mut draw = || {
        let choices = if rng.random_bool(0.2) { values.len() } else { 6 };
        values[rng.random_range(0..choices)]
    };
    let inputs: Vec<_> = (0..20_000).map(|_| job(std::array::from_fn(|_| [draw(), draw(), draw()]))).collect();
    let jobs: Vec<Job> = inputs.iter().map(|&input| Job::Triangle(input)).collect();
    let mut decided_by = [0; 7];
    for (rules, by_text) in
        [(Rules::Paper, TriangleSteps::hit_by_paper as fn(_) -> _), (Rules::Chisel, TriangleSteps::hit_by_chisel)]
    {
        for (input, outcome) in inputs.iter().zip(answers(rules, &jobs)) {
            let Outcome::Triangle(outcome) = outcome else { unreachable!() };
            let steps = TriangleSteps::of(input);
            assert_eq!(bool::from(outcome.triangle_hit), by_text(steps), "{rules}: {steps:?}");
            let TriangleSteps { u, v, w, t_num, t_denom } = steps;
            let failing =
                [u >= 0.0, v >= 0.0, w >= 0.0, t_denom != 0.0, t_num > 0.0, !t_num.is_nan()].map(|holds| !holds);
            match failing.iter().filter(|&&fails| fails).count() {
                0 => decided_by[6] += 1,
                // A NaN t_num fails two conditions.
                1 | 2 => (0..6).filter(|&i| failing[i]).for_each(|i| decided_by[i] += 1),
                _ => {}
            }
        }
    }
    assert!(decided_by.iter().all(|&count| count > 20), "{decided_by:?}");
}
