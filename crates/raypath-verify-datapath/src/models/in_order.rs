//! The cycle-exact model, with a source without bubbles and a sink that stalls 8 cycles of 64.

use raypath_model::{CycleModel, Model, Shape};
use std::collections::VecDeque;
use std::fmt::Debug;

pub struct InOrder<M: Model> {
    model: CycleModel<M>,
    expected: VecDeque<M::Outcome>,
    cycles: u64,
}

impl<M: Model<Outcome: Debug + Clone + PartialEq>> InOrder<M> {
    pub fn new(model: M, shape: &Shape) -> Self {
        Self { model: CycleModel::new(model, shape), expected: VecDeque::new(), cycles: 0 }
    }

    /// Offers a job until it is accepted. Returns the first difference of the outcomes that leave meanwhile.
    pub fn next(&mut self, job: &M::Job, outcome: M::Outcome) -> Option<String> {
        loop {
            let (left, is_accepted) = self.cycle(Some(job));
            if left.is_some() {
                return left;
            }
            if is_accepted {
                self.expected.push_back(outcome);
                return None;
            }
        }
    }

    /// Lets all jobs leave. Returns the first difference of their outcomes.
    pub fn finish(&mut self) -> Option<String> {
        /// More cycles than the jobs of a pipeline need to leave.
        const ENOUGH: u64 = 10_000;
        for _ in 0..ENOUGH {
            if self.expected.is_empty() {
                return None;
            }
            if let (Some(difference), _) = self.cycle(None) {
                return Some(difference);
            }
        }
        Some(format!("{} jobs do not leave the cycle-exact model", self.expected.len()))
    }

    /// One cycle: the difference of the outcome that leaves, and whether the job was accepted.
    fn cycle(&mut self, job: Option<&M::Job>) -> (Option<String>, bool) {
        self.cycles += 1;
        let transfer = self.model.cycle(job, self.cycles % 64 >= 8);
        let difference = transfer.output.and_then(|found| {
            let expected = self.expected.pop_front();
            let is_right = expected.as_ref() == Some(&found);
            let what = || format!("the cycle-exact model's outcome is {found:?}, the functional model's {expected:?}");
            (!is_right).then(what)
        });
        (difference, transfer.accepted)
    }
}
