//! A beat adds to its own accumulator exactly once, and nothing else changes the accumulator.

use crate::answers::{answers, answers_under, numbers};
use crate::random::{Numbers, any_job, rng, scene_job};
use rand::RngExt;
use rand::seq::SliceRandom;
use raypath::ops::{Beat, BeatInput, Binary32, Flags, Job, Num, Outcome, Rules};
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

fn resets(outcomes: &[Outcome]) -> Vec<bool> {
    let flag = |outcome: &Outcome| match outcome {
        Outcome::Euclidean(o) => o.euclidean_reset_accum.into(),
        Outcome::Angular(o) => o.angular_reset_accum.into(),
        _ => panic!("no distance: {outcome:?}"),
    };
    outcomes.iter().map(flag).collect()
}

#[test]
fn the_reset_beat_is_included_and_the_next_begins_at_zero() {
    let beats = [(1.0, false), (2.0, true), (4.0, false), (8.0, false), (16.0, true), (32.0, true), (64.0, false)];
    let flags: Vec<bool> = beats.iter().map(|beat| beat.1).collect();

    let outcomes = answers(Rules::Paper, &beats.map(|(x, reset)| euclidean(x, reset)));
    assert_eq!(sums(&outcomes).concat(), [1.0, 5.0, 16.0, 80.0, 336.0, 1024.0, 4096.0]);
    assert_eq!(resets(&outcomes), flags, "reset is passed along");

    let outcomes = answers(Rules::Paper, &beats.map(|(x, reset)| angular(-3.0, x, reset)));
    let dots = [-3.0, -9.0, -12.0, -36.0, -84.0, -96.0, -192.0];
    let norms = [1.0, 5.0, 16.0, 80.0, 336.0, 1024.0, 4096.0];
    assert_eq!(sums(&outcomes), dots.into_iter().zip(norms).map(|(dot, norm)| vec![dot, norm]).collect::<Vec<_>>());
    assert_eq!(resets(&outcomes), flags);
}

#[test]
fn euclidean_and_angular_sums_are_separate() {
    let jobs = [
        euclidean(1.0, false),
        angular(2.0, 1.0, false),
        euclidean(2.0, true),     // clears the Euclidean sum
        angular(3.0, 1.0, false), // keeps its sum
        euclidean(4.0, false),
        angular(4.0, 1.0, true), // clears both angular sums
        euclidean(8.0, false),   // keeps its sum
        angular(5.0, 2.0, false),
    ];
    let expected: [&[f32]; 8] = [&[1.0], &[2.0, 1.0], &[5.0], &[5.0, 2.0], &[16.0], &[9.0, 3.0], &[80.0], &[10.0, 4.0]];
    assert_eq!(sums(&answers(Rules::Paper, &jobs)), expected);
}

/// A NaN or an infinity stays in the sum until the reset.
#[test]
fn reset_clears_nan_and_infinity() {
    for poison in [f32::NAN, f32::INFINITY] {
        let jobs = [euclidean(poison, false), euclidean(1.0, true), euclidean(1.0, false)];
        let found = sums(&answers(Rules::Paper, &jobs)).concat();
        assert!(!found[0].is_finite() && !found[1].is_finite(), "{found:?}");
        assert_eq!(found[2], 1.0);
        let jobs = [angular(1.0, poison, false), angular(1.0, 1.0, true), angular(1.0, 1.0, false)];
        assert_eq!(sums(&answers(Rules::Paper, &jobs))[2], [1.0, 1.0]);
    }
}

/// Two long distances, beat after beat, with any number of other jobs with random ports in between. Every sum is an
/// integer that binary32 represents.
fn interleaved(seed: u64) -> (Vec<Job>, Vec<Vec<f32>>) {
    let mut rng = rng(seed);
    let (mut sum, mut dot, mut norm) = (0.0, 0.0, 0.0);
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
        for _ in 0..rng.random_range(0..4) {
            let kind = [raypath::ops::JobKind::Triangle, raypath::ops::JobKind::Quadbox][rng.random_range(0..2)];
            jobs.push(if rng.random() { any_job(kind, Numbers::RawBits, &mut rng) } else { scene_job(&mut rng) });
        }
    }
    (jobs, expected)
}

#[test]
fn other_jobs_bubbles_and_stalls_never_touch_a_sum() {
    for seed in 0..12 {
        let (jobs, expected) = interleaved(seed);
        let traffic = if seed == 0 { Traffic::always() } else { Traffic::random(seed) };
        let outcomes = answers_under(Rules::Paper, &jobs, &traffic);
        let distances: Vec<Outcome> =
            outcomes.into_iter().filter(|o| matches!(o, Outcome::Euclidean(_) | Outcome::Angular(_))).collect();
        assert_eq!(sums(&distances), expected, "seed {seed}");
    }
}

/// If all sums are exact, the order of beats within a distance does not matter, but each beat counts once.
#[test]
fn each_of_many_beats_counts_exactly_once() {
    let mut powers: Vec<i32> = (0..12).collect();
    for seed in 0..20 {
        powers.shuffle(&mut rng(seed));
        let jobs: Vec<Job> = powers.iter().map(|&p| euclidean(2f32.powi(p), false)).collect();
        let outcomes = answers_under(Rules::Paper, &jobs, &Traffic::random(seed));
        let mut sum = 0;
        for (&power, outcome) in powers.iter().zip(&outcomes) {
            sum += 1 << (2 * power); // each square has its own bit, so a missed or repeated beat changes the sum
            assert_eq!(numbers(outcome)[0], Num::from(sum as f32));
        }
    }
}
