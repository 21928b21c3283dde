//! Distances of integers: every sum is a binary32 number, so the outcome must be exact.

use crate::semantics::answers::{answers_under, numbers};
use crate::semantics::random::rng;
use rand::RngExt;
use raypath::ops::{Job, JobKind, Rules};
use raypath::sim::traffic::Traffic;

/// The largest integer up to which binary32 represents every integer.
const LARGEST: i128 = 1 << 24;

#[test]
fn sums_of_integers_are_exact() {
    let mut rng = rng(4);
    let (mut sum, mut dot, mut norm) = (0_i128, 0_i128, 0_i128);
    let mut jobs = Vec::new();
    let mut expected: Vec<Vec<i128>> = Vec::new();
    for _ in 0..8000 {
        let kind = if rng.random() { JobKind::Euclidean } else { JobKind::Angular };
        let lanes = if kind == JobKind::Euclidean { 16 } else { 8 };
        let a: [i128; 16] = std::array::from_fn(|_| rng.random_range(-99..=99));
        let b: [i128; 16] = std::array::from_fn(|_| rng.random_range(-99..=99));
        let mask: u64 = rng.random();
        let reset = rng.random_bool(0.1);
        let on = || (0..lanes).filter(|i| mask >> i & 1 == 1);
        if kind == JobKind::Euclidean {
            sum += on().map(|i| (a[i] - b[i]).pow(2)).sum::<i128>();
            expected.push(vec![sum]);
        } else {
            dot += on().map(|i| a[i] * b[i]).sum::<i128>();
            norm += on().map(|i| b[i].pow(2)).sum::<i128>();
            expected.push(vec![dot, norm]);
        }
        // A reset comes before a beat that could exceed the limit: a full beat adds at most 16·198².
        let far = sum.max(dot.abs()).max(norm) > LARGEST - 16 * 198 * 198;
        jobs.push(Job::from_ports(kind, |name| match name {
            "euclidean_mask" => mask,
            "euclidean_reset_accum" => (reset || far).into(),
            _ => {
                let (vector, lane) = name.trim_start_matches("euclidean_").split_once('_').unwrap();
                let lane: usize = lane.parse().unwrap();
                (if vector == "a" { a[lane] } else { b[lane] } as f32).to_bits().into()
            }
        }));
        match kind {
            JobKind::Euclidean if reset || far => sum = 0,
            JobKind::Angular if reset || far => (dot, norm) = (0, 0),
            _ => {}
        }
    }
    for traffic in [Traffic::always(), Traffic::random(5)] {
        for (i, outcome) in answers_under(Rules::Paper, &jobs, &traffic).iter().enumerate() {
            let sums: Vec<i128> = numbers(outcome).into_iter().map(|x| f32::from(x) as i128).collect();
            assert!(expected[i].iter().all(|x| x.abs() <= LARGEST));
            assert_eq!(sums, expected[i], "job {i}");
        }
    }
}
