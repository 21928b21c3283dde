//! Rounding: each operation in the order of Table VII, and none fused (see `oracle`).

use crate::semantics::answers::answers;
use crate::semantics::oracle::{Oracle, TriangleSteps};
use crate::semantics::random::{mixed_jobs, rng};
use rand::RngExt;
use raypath::ops::Rules;

#[test]
fn every_job_rounds_step_by_step() {
    let jobs = mixed_jobs(30_000, 9);
    let mut oracle = Oracle::default();
    for (i, (job, outcome)) in jobs.iter().zip(answers(Rules::Paper, &jobs)).enumerate() {
        assert_eq!(outcome, oracle.run(job), "job {i}: {job:?}");
    }
}

/// Negative control: the test above detects another order of additions and a fused product.
#[test]
fn another_order_of_operations_rounds_otherwise() {
    let mut rng = rng(10);
    let (mut reordered, mut fused) = (0, 0);
    for _ in 0..1000 {
        let [a, b, c]: [f32; 3] = std::array::from_fn(|_| rng.random_range(-1.0..=1.0_f64) as f32);
        reordered += usize::from((a + b) + c != a + (b + c));
        fused += usize::from(a.mul_add(b, -c) != a * b - c);
    }
    assert!(reordered > 200 && fused > 200, "{reordered} {fused}");
}

/// The oracle for a known outcome: the triangle with corners at depth 2 of which 1/3 is on each side.
#[test]
fn the_oracle_is_right_where_the_answer_is_known() {
    let ray = crate::semantics::answers::ray([0.0; 3], [0.0, 0.0, 1.0], f32::INFINITY);
    let triangle = raypath::ops::Triangle::new([-1.0, -1.0, 2.0], [0.0, 1.0, 2.0], [1.0, -1.0, 2.0]);
    let steps = TriangleSteps::of(&raypath::ops::RayTriangleInput { ray, triangle });
    assert_eq!([steps.u, steps.v, steps.w, steps.t_denom, steps.t_num], [1.0, 2.0, 1.0, 4.0, 8.0]);
}
