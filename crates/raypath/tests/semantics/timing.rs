//! 24 jobs while the sink is not ready, stable outputs. `golden.rs` and `peers/latency.rs` test the latency and the
//! throughput.

use crate::answers::{self, Typed};
use crate::random::mixed_jobs;
use raypath::model::Functional;
use raypath::ops::{Job, Outcome, Rules};

/// From the cycle that accepts a job to the cycle that shows its outcome.
const LATENCY: usize = 12;
const CAPACITY: usize = 24;

fn on_engines(scenario: impl Fn(&mut Typed<'_>)) {
    answers::on_engines(Rules::Paper, scenario);
}

fn outcomes(jobs: &[Job]) -> Vec<Outcome> {
    let mut model = Functional::new(Rules::Paper);
    jobs.iter().map(|job| model.run(job)).collect()
}

/// Exactly 24 jobs enter while the sink is not ready; the output is stable; then all leave in order, one per cycle.
#[test]
fn twenty_four_jobs_wait_for_the_sink() {
    let jobs = mixed_jobs(60, 13);
    let expected = outcomes(&jobs);
    on_engines(|engine| {
        let mut accepted = 0;
        for cycle in 0..100 {
            engine.present(&jobs[accepted]);
            let shown = engine.cycle(true, false);
            assert_eq!(shown.input_ready, accepted < CAPACITY && cycle == accepted, "cycle {cycle}");
            assert_eq!(shown.output, (cycle >= LATENCY).then_some(expected[0]), "cycle {cycle}: the output holds");
            accepted += usize::from(shown.input_ready);
        }
        assert_eq!(accepted, CAPACITY);
        // A job that is not accepted has no effect.
        for waiting in &jobs[30..40] {
            engine.present(waiting);
            assert!(!engine.cycle(true, false).input_ready);
        }
        for outcome in &expected[..CAPACITY] {
            assert_eq!(engine.cycle(false, true).output, Some(*outcome));
        }
        assert_eq!(engine.cycle(false, true).output, None);
    });
}

/// A sink that is ready in every other cycle gets an outcome each time, in order, and each outcome is stable until
/// taken.
#[test]
fn outputs_hold_until_they_are_taken() {
    let jobs = mixed_jobs(50, 15);
    let expected = outcomes(&jobs);
    for pause in [1, 2, 3, 7] {
        on_engines(|engine| {
            engine.reset();
            let (mut accepted, mut left) = (0, 0);
            for cycle in 0..(LATENCY + jobs.len() * (pause + 1) + 50) {
                if let Some(job) = jobs.get(accepted) {
                    engine.present(job);
                }
                let output_ready = cycle % (pause + 1) == pause;
                let shown = engine.cycle(accepted < jobs.len(), output_ready);
                accepted += usize::from(accepted < jobs.len() && shown.input_ready);
                if let Some(outcome) = shown.output {
                    assert_eq!(outcome, expected[left], "cycle {cycle}");
                    left += usize::from(output_ready);
                }
            }
            assert_eq!(left, jobs.len());
        });
    }
}
