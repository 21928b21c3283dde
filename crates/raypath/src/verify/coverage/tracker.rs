use super::rules::Onto;
use super::{Atlas, Coverage, End, Features, Way};
use crate::engine::Seen;
use raypath_model::OnPorts;
use raypath_ops::JobKind;
use std::collections::VecDeque;

/// Follows jobs through an engine, from a reset on, and counts what they exercise.
pub struct Tracker<'t> {
    atlas: &'t Atlas,
    coverage: &'t mut Coverage,
    /// What each job exercises, in the order in which they are presented.
    jobs: &'t [Features],
    /// The jobs inside, oldest first, and whether they waited.
    inside: VecDeque<(usize, bool)>,
    /// The job at the entrance has been refused.
    refused: bool,
    /// The outcome at the output has been refused.
    held: bool,
    /// The kind that entered last, and whether that was in the last cycle.
    entered: Option<(JobKind, bool)>,
    /// What the next beat of each kind finds.
    onto: [Onto; JobKind::ALL.len()],
    words: Vec<u64>,
}

const NOTHING: Onto = Onto { sum: 0, after_others: true, after_loss: false };

impl<'t> Tracker<'t> {
    /// Nothing is inside.
    pub fn new(atlas: &'t Atlas, coverage: &'t mut Coverage, jobs: &'t [Features]) -> Self {
        let onto = [NOTHING; JobKind::ALL.len()];
        let (inside, words) = (VecDeque::new(), Vec::new());
        Self { atlas, coverage, jobs, inside, refused: false, held: false, entered: None, onto, words }
    }

    /// One cycle.
    pub fn watch<O: OnPorts>(&mut self, seen: &Seen<O>) {
        if let Some(features) = seen.withdrawn.and_then(|index| self.jobs.get(index)) {
            self.coverage.handshakes.withdrawn(features.kind, self.refused);
            self.refused = false;
        }
        if seen.cycle.resets {
            return self.reset(seen.inside);
        }
        let (offers, takes) = (seen.cycle.offers, seen.cycle.takes);
        let is_shown = seen.shown.output.is_some();
        self.coverage.handshakes.cycle((offers, seen.shown.input_ready), (takes, is_shown), seen.inside);
        if let (Some(_), Some(outcome)) = (seen.left, &seen.shown.output) {
            self.leaves(outcome);
        }
        self.held = is_shown && !takes;
        match seen.entered.and_then(|index| Some((index, self.jobs.get(index)?))) {
            Some((index, features)) => {
                self.inside.push_back((index, std::mem::take(&mut self.refused)));
                if let Some((before, is_next_cycle)) = self.entered.replace((features.kind, true)) {
                    self.coverage.handshakes.pair(before, features.kind, is_next_cycle);
                }
            }
            None => {
                self.refused |= offers;
                self.entered = self.entered.map(|(kind, _)| (kind, false));
            }
        }
    }

    fn leaves(&mut self, outcome: &impl OnPorts) {
        let Some((index, waited)) = self.inside.pop_front() else { return };
        let mut features = self.jobs[index];
        let kind = features.kind;
        if matches!(kind, JobKind::Euclidean | JobKind::Angular) {
            self.atlas.at_exit(&mut features, self.onto[kind as usize]);
            outcome.words(&mut self.words);
            let (sum, is_last) = (self.words.first(), self.words.last());
            let sum = if is_last == Some(&1) { 0 } else { sum.copied().unwrap_or(0) };
            self.onto[kind as usize] = Onto { sum, after_others: false, after_loss: false };
        }
        let others = JobKind::ALL.into_iter().filter(|other| *other != kind);
        others.for_each(|other| self.onto[other as usize].after_others = true);
        let end = if self.held { End::Held } else { End::Taken };
        self.coverage.count(&features, Way { waited, end });
    }

    fn reset(&mut self, inside: usize) {
        self.coverage.handshakes.reset(inside);
        for (index, waited) in self.inside.drain(..) {
            self.coverage.count(&self.jobs[index], Way { waited, end: End::Lost });
        }
        for onto in &mut self.onto {
            *onto = Onto { after_loss: onto.after_loss || onto.sum != 0, ..NOTHING };
        }
        self.held = false;
        self.entered = None;
    }
}
