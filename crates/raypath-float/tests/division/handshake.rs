//! Latency, interval, stalls, tags, and what is refused.

use crate::division::driver::{ALWAYS, Job, Outcome, Traffic, Unit};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::{DivSqrt, Format};

const FORMAT: Format = Format::BINARY16;

fn jobs(count: u32) -> Vec<Job> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    (0..count)
        .map(|_| Job {
            a: random.random_range(0..1 << 16),
            b: random.random_range(0..1 << 16),
            is_root: random.random(),
        })
        .collect()
}

fn traffics() -> impl Iterator<Item = Traffic> {
    let shares = [1, 4, 8, 15, 16];
    shares.into_iter().flat_map(move |source| {
        shares.into_iter().map(move |sink| Traffic { source, sink, seed: u64::from(source * 100 + sink) })
    })
}

#[test]
fn a_pipelined_unit_takes_operands_in_every_cycle() {
    for latency in [1, 2, 5, 14] {
        let outcomes =
            Unit::pipelined(DivSqrt::QuotientOrRoot, FORMAT, latency).check(&jobs(200), |x| FORMAT.encode(x), ALWAYS);
        for (number, outcome) in (0..).zip(outcomes) {
            assert_eq!((outcome.accepted, outcome.valid), (number, number + u64::from(latency)));
        }
    }
}

#[test]
fn an_iterative_unit_has_its_latency_for_all_operands() {
    for digits in [1, 2, 3, 4, 5, 13] {
        let outcomes =
            Unit::iterative(DivSqrt::QuotientOrRoot, FORMAT, digits).check(&jobs(200), |x| FORMAT.encode(x), ALWAYS);
        let latency = u64::from(DivSqrt::iterative_latency(FORMAT, digits));
        assert_eq!(latency, 13_u64.div_ceil(digits.into()) + 1);
        for (number, outcome) in (0..).zip(outcomes) {
            assert_eq!((outcome.accepted, outcome.valid), (number * latency, (number + 1) * latency));
        }
    }
}

/// No job is lost, repeated or reordered, and none waits longer than the sink and the jobs before it make it wait.
#[test]
fn stalls_lose_nothing() {
    for traffic in traffics() {
        for latency in [1, 3, 14] {
            let mut unit = Unit::pipelined(DivSqrt::Quotient, FORMAT, latency);
            let outcomes = unit.check(&jobs(300), |x| FORMAT.encode(x), traffic);
            assert!(outcomes.iter().all(|outcome| outcome.valid >= outcome.accepted + u64::from(latency)));
        }
        for digits in [1, 5] {
            let mut unit = Unit::iterative(DivSqrt::QuotientOrRoot, FORMAT, digits);
            let outcomes = unit.check(&jobs(300), |x| FORMAT.encode(x), traffic);
            let latency = u64::from(DivSqrt::iterative_latency(FORMAT, digits));
            assert!(outcomes.iter().all(|outcome| outcome.valid == outcome.accepted + latency));
            let in_turn = |pair: &[Outcome]| pair[1].accepted >= pair[0].taken;
            assert!(outcomes.windows(2).all(in_turn), "one job at a time");
        }
    }
}

#[test]
fn counts_that_no_unit_has_are_refused() {
    let function = DivSqrt::Quotient;
    for parts in [0, 15] {
        assert!(function.parts(FORMAT, parts).is_err() && function.pipelined(FORMAT, parts, 0).is_err(), "{parts}");
    }
    for digits in [0, 14] {
        let message = function.iterative(FORMAT, digits, 0).map(|_| ()).expect_err("refused").to_string();
        assert!(message.contains(&format!("signal digits: are {digits} a cycle, expected 1 to 13")), "{message}");
    }
    assert!(function.iterative(FORMAT, 1, 65).is_err() && function.pipelined(FORMAT, 1, 65).is_err());
}
