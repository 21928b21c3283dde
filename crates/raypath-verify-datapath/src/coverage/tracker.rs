//! Coverage of a running pipeline.

use super::counts::Coverage;
use super::handshakes::Event;
use super::model::{CoverageModel, JobEnd, JobPath, JobPoints};
use super::rules::AccumulatorState;
use raypath_model::Words;
use raypath_sim::engine::Seen;
use std::collections::VecDeque;

/// Follows jobs through a pipeline from a reset on, and counts their coverage points.
pub struct Tracker<'t> {
    model: &'t CoverageModel,
    coverage: &'t mut Coverage,
    /// The points of each job, in the order of presentation.
    jobs: &'t [JobPoints],
    /// The jobs in the pipeline, oldest first, and whether they waited.
    inside: VecDeque<(usize, bool)>,
    /// Whether the job at the entrance has been refused.
    refused: bool,
    /// Whether the sink has stalled the outcome at the output.
    held: bool,
    /// The operation that entered last, and whether it entered in the last cycle.
    entered: Option<(usize, bool)>,
    /// What the next beat of each accumulator of each operation finds.
    accumulators: Vec<Vec<AccumulatorState>>,
}

/// The greatest number of accumulators of an operation.
const MAX_ACCUMULATORS: usize = 16;
/// The outputs that are 1 if an accumulator restarts.
const RESETS: [&str; 2] = ["euclidean_reset_accum", "angular_reset_accum"];

impl<'t> Tracker<'t> {
    /// A tracker of an empty pipeline.
    pub fn new(model: &'t CoverageModel, coverage: &'t mut Coverage, jobs: &'t [JobPoints]) -> Self {
        let accumulators = vec![vec![AccumulatorState::EMPTY; MAX_ACCUMULATORS]; model.operations.len()];
        let inside = VecDeque::new();
        Self { model, coverage, jobs, inside, refused: false, held: false, entered: None, accumulators }
    }

    /// Counts one cycle.
    pub fn observe(&mut self, seen: &Seen) {
        if let Some(job) = seen.withdrawn.and_then(|index| self.jobs.get(index)) {
            self.coverage.handshakes.count(Event::Withdrawn(job.operation, self.refused));
            self.refused = false;
        }
        if seen.cycle.resets {
            return self.reset(seen.inside);
        }
        let (offers, takes) = (seen.cycle.offers, seen.cycle.takes);
        let is_shown = seen.shown.output.is_some();
        self.coverage.handshakes.count_cycle((offers, seen.shown.input_ready), (takes, is_shown), seen.inside);
        if let (Some(_), Some(outcome)) = (seen.left, &seen.shown.output) {
            self.leaves(outcome);
        }
        self.held = is_shown && !takes;
        match seen.entered.and_then(|index| Some((index, self.jobs.get(index)?))) {
            Some((index, job)) => {
                self.inside.push_back((index, std::mem::take(&mut self.refused)));
                if let Some((before, is_next_cycle)) = self.entered.replace((job.operation, true)) {
                    self.coverage.handshakes.count(Event::Pair(before, job.operation, is_next_cycle));
                }
            }
            None => {
                self.refused |= offers;
                self.entered = self.entered.map(|(operation, _)| (operation, false));
            }
        }
    }

    fn leaves(&mut self, outcome: &Words) {
        let Some((index, waited)) = self.inside.pop_front() else { return };
        let mut covered = self.jobs[index];
        let JobPoints { operation, accumulator, .. } = covered;
        let exceptions = self.model.has_exceptions().then(|| outcome.port("exception_flags"));
        let found = self.accumulators[operation][accumulator];
        self.model.add_exit_points(&mut covered, found, exceptions);
        let restarts = RESETS.iter().any(|port| outcome.port(port) == 1);
        let sum = if restarts { 0 } else { outcome.as_words().first().copied().unwrap_or(0) };
        for (other, states) in self.accumulators.iter_mut().enumerate() {
            let others = states.iter_mut().enumerate().filter(|(index, _)| (other, *index) != (operation, accumulator));
            others.for_each(|(_, state)| state.after_others = true);
        }
        self.accumulators[operation][accumulator] = AccumulatorState { sum, after_others: false, after_loss: false };
        let end = if self.held { JobEnd::Held } else { JobEnd::Taken };
        self.coverage.count(&covered, JobPath { waited, end });
    }

    fn reset(&mut self, inside: usize) {
        self.coverage.handshakes.count(Event::Reset(inside.min(self.model.capacity)));
        for (index, waited) in self.inside.drain(..) {
            self.coverage.count(&self.jobs[index], JobPath { waited, end: JobEnd::Lost });
        }
        for found in self.accumulators.iter_mut().flatten() {
            *found = AccumulatorState { after_loss: found.after_loss || found.sum != 0, ..AccumulatorState::EMPTY };
        }
        self.held = false;
        self.entered = None;
    }
}
