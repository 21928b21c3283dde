//! The functional and the cycle-exact model: exact sums for any number of lanes, and resets.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{CycleModel, Functional, LATENCY, Shape};
use raypath_ops::{Job, JobKind, Outcome, Rules};

/// A beat of small integers, with its exact sums: Σ(a−b)² for Euclidean, Σab and Σb² for angular jobs.
fn beat<const E: usize, const A: usize>(kind: JobKind, reset: bool, rng: &mut ChaCha8Rng) -> (Job<E, A>, Vec<i64>) {
    let (a, b): (Vec<i64>, Vec<i64>) = (0..E).map(|_| (rng.random_range(-9..=9), rng.random_range(-9..=9))).unzip();
    let mask: u64 = rng.random();
    let lanes = if kind == JobKind::Euclidean { E } else { A };
    let on: Vec<usize> = (0..lanes).filter(|i| mask >> i & 1 == 1).collect();
    let sums = match kind {
        JobKind::Euclidean => vec![on.iter().map(|&i| (a[i] - b[i]).pow(2)).sum()],
        _ => vec![on.iter().map(|&i| a[i] * b[i]).sum(), on.iter().map(|&i| b[i].pow(2)).sum()],
    };
    let job = Job::from_ports(kind, |name| match name.rsplit_once('_') {
        Some(("euclidean", "mask")) => mask,
        Some(("euclidean_a", lane)) => (a[lane.parse::<usize>().unwrap()] as f32).to_bits().into(),
        Some(("euclidean_b", lane)) => (b[lane.parse::<usize>().unwrap()] as f32).to_bits().into(),
        _ => reset.into(),
    });
    (job, sums)
}

fn sums(outcome: &Outcome) -> Vec<i64> {
    let numbers = match outcome {
        Outcome::Euclidean(o) => vec![o.euclidean_accumulator],
        Outcome::Angular(o) => vec![o.angular_dot_product, o.angular_norm],
        _ => panic!("no distance: {outcome:?}"),
    };
    numbers.into_iter().map(|x| f32::from(x) as i64).collect()
}

fn sums_are_exact<const E: usize, const A: usize>() {
    let mut rng = ChaCha8Rng::seed_from_u64(E as u64);
    let mut model = Functional::<E, A>::new(Rules::Paper);
    let mut running = [vec![0], vec![0, 0]];
    for _ in 0..2000 {
        let kind = [JobKind::Euclidean, JobKind::Angular][rng.random_range(0..2)];
        let reset = rng.random_bool(0.1);
        let (job, added) = beat::<E, A>(kind, reset, &mut rng);
        let sum = &mut running[kind as usize - 2];
        sum.iter_mut().zip(added).for_each(|(sum, more)| *sum += more);
        assert_eq!(sums(&model.run(&job)), *sum, "{E} lanes");
        if reset {
            sum.fill(0);
        }
    }
}

#[test]
fn beats_of_every_width_sum_exactly() {
    sums_are_exact::<2, 1>();
    sums_are_exact::<4, 2>();
    sums_are_exact::<8, 4>();
    sums_are_exact::<16, 8>();
    sums_are_exact::<32, 16>();
    sums_are_exact::<64, 32>();
}

#[test]
fn a_reset_zeroes_the_sums() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for kind in [JobKind::Euclidean, JobKind::Angular] {
        let (job, expected) = beat::<16, 8>(kind, false, &mut rng);
        let mut functional = Functional::new(Rules::Paper);
        functional.run(&job);
        functional.reset();
        assert_eq!(sums(&functional.run(&job)), expected);

        let mut cycle = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
        (0..30).for_each(|_| _ = cycle.cycle(Some(&job), true));
        cycle.reset();
        assert!(cycle.input_ready(kind.opcode()) && cycle.output().is_none());
        cycle.cycle(Some(&job), true);
        let outcome = (0..LATENCY + 5).find_map(|_| cycle.cycle(None, true).output).unwrap();
        assert_eq!(sums(&outcome), expected);
    }
}
