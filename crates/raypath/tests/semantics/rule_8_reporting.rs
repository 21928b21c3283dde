//! Ruling 8: t_num and t_denom are reported for hits and misses; an axis index of 3 reads z.

use crate::semantics::answers::{INF, answer, answers, ray};
use crate::semantics::random::jobs;
use raypath::ops::{Job, JobKind, Outcome, RayTriangleInput, Rules, Triangle, Word};

/// From 0 along z at depth `z`: twice the area is 4, so t_denom = ±4 and t_num = ±4 z, by the plane's equation.
#[test]
fn a_miss_reports_its_distance() {
    for rules in [Rules::Paper, Rules::Chisel] {
        for z in [1.0, 2.5, -3.0] {
            for beside in [0.0, 5.0] {
                let (a, b, c) = ([-1.0 + beside, -1.0, z], [beside, 1.0, z], [1.0 + beside, -1.0, z]);
                for (triangle, area) in [(Triangle::new(a, b, c), 4.0), (Triangle::new(a, c, b), -4.0)] {
                    let ray = ray([0.0; 3], [0.0, 0.0, 1.0], INF);
                    let job = Job::Triangle(RayTriangleInput { ray, triangle });
                    let Outcome::Triangle(outcome) = answer(rules, job) else { unreachable!() };
                    assert_eq!(f32::from(outcome.t_denom), area);
                    assert_eq!(f32::from(outcome.t_num), area * z);
                    assert_eq!(bool::from(outcome.triangle_hit), area > 0.0 && z > 0.0 && beside == 0.0);
                }
            }
        }
    }
}

/// Any job has the same outcome with 3 in place of 2, for each of kx, ky and kz.
#[test]
fn axis_3_reads_z() {
    let mut differ_from_x = 0;
    for set in 0..8_u32 {
        let with = |value: u32, job: &Job| {
            let Job::Triangle(mut input) = *job else { unreachable!() };
            let ray = &mut input.ray;
            for (i, k) in [&mut ray.kx, &mut ray.ky, &mut ray.kz].into_iter().enumerate() {
                *k = Word::truncate(if set >> i & 1 == 1 { value } else { u32::from(*k).min(2) });
            }
            Job::Triangle(input)
        };
        let jobs: Vec<Job> = jobs(&[JobKind::Triangle], set.into()).take(200).collect();
        let [with_0, expected, with_3] = [0, 2, 3].map(|value| {
            let changed: Vec<Job> = jobs.iter().map(|job| with(value, job)).collect();
            answers(Rules::Paper, &changed)
        });
        assert_eq!(with_3, expected, "set {set:03b}");
        differ_from_x += with_0.iter().zip(&expected).filter(|(x, z)| x != z).count();
    }
    assert!(differ_from_x > 500, "x would have been told from z: {differ_from_x}");
}

/// The extent limits boxes, not triangles, because the division is outside the datapath.
#[test]
fn extent_is_not_tested_by_triangle_jobs() {
    let triangle = Triangle::new([-1.0, -1.0, 9.0], [0.0, 1.0, 9.0], [1.0, -1.0, 9.0]);
    for extent in [INF, 1.0, 0.0] {
        let ray = ray([0.0; 3], [0.0, 0.0, 1.0], extent);
        let job = Job::Triangle(RayTriangleInput { ray, triangle });
        let Outcome::Triangle(outcome) = answer(Rules::Paper, job) else { unreachable!() };
        assert!(bool::from(outcome.triangle_hit), "extent {extent}");
    }
}
