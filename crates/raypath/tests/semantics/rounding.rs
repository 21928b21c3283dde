//! Rounding: each operation in the order of Table VII, and none fused (see `oracle`).

use crate::answers::{answers, numbers};
use crate::oracle::{Oracle, TriangleSteps, add, mul, sub};
use crate::random::{Numbers, any_job, mixed_jobs, rng, scene_job};
use raypath::ops::{Job, JobKind, Outcome, Rules};

fn check(jobs: &[Job]) -> Vec<Outcome> {
    let outcomes = answers(Rules::Paper, jobs);
    let mut oracle = Oracle::default();
    for (i, (job, outcome)) in jobs.iter().zip(&outcomes).enumerate() {
        assert_eq!(*outcome, oracle.run(job), "job {i}: {job:?}");
    }
    outcomes
}

/// Each operation with each distribution of numbers.
#[test]
fn every_job_rounds_step_by_step() {
    for (seed, numbers_from) in Numbers::ALL.into_iter().enumerate() {
        for kind in JobKind::ALL {
            let mut rng = rng(seed as u64);
            let jobs: Vec<Job> = (0..2000).map(|_| any_job(kind, numbers_from, &mut rng)).collect();
            let outcomes = check(&jobs);
            let finite = outcomes.iter().filter(|o| numbers(o).iter().any(|&x| f32::from(x).is_finite())).count();
            // Sums of random bits soon become infinite or NaN until the next reset.
            assert!(finite > 20, "{kind} from {numbers_from:?}: {finite} answers are finite");
        }
    }
}

#[test]
fn rays_in_a_scene_round_step_by_step() {
    let mut rng = rng(7);
    let outcomes = check(&(0..10_000).map(|_| scene_job(&mut rng)).collect::<Vec<_>>());
    let (mut boxes, mut triangles) = (0, 0);
    for outcome in outcomes {
        match outcome {
            Outcome::Quadbox(o) => boxes += o.is_intersect.to_array().into_iter().filter(|&hit| hit).count(),
            Outcome::Triangle(o) => triangles += usize::from(bool::from(o.triangle_hit)),
            _ => {}
        }
    }
    assert!(boxes > 3000 && triangles > 300, "{boxes} boxes and {triangles} triangles are hit");
}

#[test]
fn all_modes_mixed_round_step_by_step() {
    check(&mixed_jobs(15_000, 9));
}

/// Negative control: the tests above detect another order of additions and a fused product.
#[test]
fn another_order_of_operations_rounds_otherwise() {
    let mut rng = rng(10);
    let (mut reordered, mut fused) = (0, 0);
    for _ in 0..1000 {
        let [a, b, c]: [f32; 3] = std::array::from_fn(|_| Numbers::Unit.draw(&mut rng));
        reordered += usize::from(add(add(a, b), c) != add(a, add(b, c)));
        fused += usize::from(a.mul_add(b, -c) != sub(mul(a, b), c));
    }
    assert!(reordered > 200 && fused > 200, "{reordered} {fused}");
}

/// The oracle for a known outcome: the triangle with corners at depth 2 of which 1/3 is on each side.
#[test]
fn the_oracle_is_right_where_the_answer_is_known() {
    assert_eq!(add(16_777_216.0, 1.0), 16_777_216.0, "a tie goes to even");
    assert_eq!(add(16_777_218.0, 1.0), 16_777_220.0);
    assert_eq!(mul(f32::from_bits(1), 0.5).to_bits(), 0, "a subnormal tie goes to even");
    assert_eq!(mul(f32::from_bits(3), 0.5).to_bits(), 2);
    assert_eq!(sub(1.0, 1.0).to_bits(), 0);
    assert_eq!(sub(f32::MAX, -f32::MAX), f32::INFINITY);
    let ray = crate::answers::ray([0.0; 3], [0.0, 0.0, 1.0], f32::INFINITY);
    let triangle = raypath::ops::Triangle::new([-1.0, -1.0, 2.0], [0.0, 1.0, 2.0], [1.0, -1.0, 2.0]);
    let steps = TriangleSteps::of(&raypath::ops::RayTriangleInput { ray, triangle });
    assert_eq!([steps.u, steps.v, steps.w, steps.t_denom, steps.t_num], [1.0, 2.0, 1.0, 4.0, 8.0]);
}
