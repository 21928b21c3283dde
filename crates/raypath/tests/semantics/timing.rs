//! 24 jobs enter while the sink is not ready. `golden.rs` and `peers/latency.rs` test the latency and the throughput.

use crate::semantics::answers::{self, Typed};
use crate::semantics::random::mixed_jobs;
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
