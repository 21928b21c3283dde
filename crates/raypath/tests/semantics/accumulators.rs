//! A beat adds to its own accumulator exactly once, and nothing else changes the accumulator.

use crate::semantics::answers::{answers_under, numbers};
use crate::semantics::random::{self, rng};
use rand::RngExt;
use raypath::ops::{Beat, BeatInput, Binary32, Flags, Job, JobKind, Outcome, Rules};
use raypath::sim::traffic::Traffic;

fn beat<const N: usize>(a: f32, b: f32, reset: bool) -> Beat<Binary32, N> {
    let mut beat =
        Beat { a: [0.0.into(); N], b: [0.0.into(); N], mask: Flags::from_mask(u64::MAX), reset_accum: reset.into() };
    (beat.a[0], beat.b[0]) = (a.into(), b.into());
    beat
}

/// Adds `a²`.
fn euclidean(a: f32, reset: bool) -> Job {
    Job::Euclidean(BeatInput { euclidean: beat(a, 0.0, reset) })
}

/// Adds a·b and b².
fn angular(a: f32, b: f32, reset: bool) -> Job {
    Job::Angular(BeatInput { euclidean: beat(a, b, reset) })
}

fn sums(outcomes: &[Outcome]) -> Vec<Vec<f32>> {
    outcomes.iter().map(|outcome| numbers(outcome).into_iter().map(f32::from).collect()).collect()
}

/// Whether the outcome is that of a beat which resets its sum; `None` for other jobs.
fn reset(outcome: &Outcome) -> Option<bool> {
    match outcome {
        Outcome::Euclidean(o) => Some(o.euclidean_reset_accum.into()),
        Outcome::Angular(o) => Some(o.angular_reset_accum.into()),
        _ => None,
    }
}

/// Two long distances, beat after beat, with any number of other jobs with random ports in between. Every sum is an
/// integer that binary32 represents.
fn interleaved(seed: u64) -> (Vec<Job>, Vec<Vec<f32>>) {
    let mut rng = rng(seed);
    let (mut sum, mut dot, mut norm) = (0.0, 0.0, 0.0);
    let mut others = random::jobs(&[JobKind::Triangle, JobKind::Quadbox], seed);
    let mut jobs = Vec::new();
    let mut expected = Vec::new();
    for beat in 1..=400 {
        let (x, y) = (rng.random_range(-20..=20) as f32, rng.random_range(-20..=20) as f32);
        let reset = beat % 40 == 0;
        if rng.random() {
            sum += x * x;
            jobs.push(euclidean(x, reset));
            expected.push(vec![sum]);
            sum = if reset { 0.0 } else { sum };
        } else {
            (dot, norm) = (dot + x * y, norm + y * y);
            jobs.push(angular(x, y, reset));
            expected.push(vec![dot, norm]);
            (dot, norm) = if reset { (0.0, 0.0) } else { (dot, norm) };
        }
        jobs.extend(others.by_ref().take(rng.random_range(0..4)));
    }
    (jobs, expected)
}

#[test]
fn other_jobs_bubbles_and_stalls_never_touch_a_sum() {
    for seed in 0..12 {
        let (jobs, expected) = interleaved(seed);
        let traffic = if seed == 0 { Traffic::always() } else { Traffic::random(seed) };
        let outcomes = answers_under(Rules::Paper, &jobs, &traffic);
        let distances: Vec<Outcome> = outcomes.into_iter().filter(|outcome| reset(outcome).is_some()).collect();
        assert_eq!(sums(&distances), expected, "seed {seed}");
        let resets = distances.iter().enumerate().filter(|(_, outcome)| reset(outcome) == Some(true));
        assert!(resets.map(|(beat, _)| beat + 1).eq((40..=400).step_by(40)), "reset is passed along");
    }
}
