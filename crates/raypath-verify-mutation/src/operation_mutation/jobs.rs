//! Jobs that show faults of an operation.

use super::evaluate::Jobs;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use raypath_model::{Model, OperationId, WordModel};
use raypath_ops::{Port, PortKind};
use raypath_sim::jobs::any_job;
use raypath_verify_datapath::stimuli::Stimuli;

/// Jobs of a step. Each is the next of a stream of its own.
pub const STREAMS: usize = 64;

/// Jobs of an operation: those of the campaigns, and those of the regression tests, whose
/// ports are drawn one by one. Many have numbers that show particular faults, or are next to a decision.
pub fn jobs(model: &WordModel, kind: OperationId, steps: usize, seed: u64) -> Jobs {
    let mut source = Source::new(model, kind, seed);
    let mut step = || (0..STREAMS).map(|_| model.job_of_words(kind, &source.next(model)).as_words().to_vec()).collect();
    Jobs { ports: model.inputs(kind).to_vec(), steps: (0..steps).map(|_| step()).collect() }
}

struct Source<'m> {
    kind: OperationId,
    inputs: &'m [Port],
    stimuli: Stimuli,
    rng: ChaCha8Rng,
    /// The model whose decisions jobs are next to. It judges no outcome.
    decider: WordModel,
    waiting: Vec<Vec<u64>>,
}

impl<'m> Source<'m> {
    fn new(model: &'m WordModel, kind: OperationId, seed: u64) -> Self {
        Self {
            kind,
            inputs: model.inputs(kind),
            stimuli: Stimuli::new(model, seed),
            rng: ChaCha8Rng::seed_from_u64(seed),
            decider: model.clone(),
            waiting: Vec::new(),
        }
    }

    fn next(&mut self, model: &WordModel) -> Vec<u64> {
        if let Some(waiting) = self.waiting.pop() {
            return waiting;
        }
        let job = self.independent(model);
        if self.rng.random_bool(0.3) {
            let other = self.independent(model);
            let pair = self.next_to_decision(job.clone(), other);
            self.waiting.extend(pair.into_iter().flatten());
        }
        job
    }

    fn independent(&mut self, model: &WordModel) -> Vec<u64> {
        let mut words = Vec::new();
        if self.rng.random_bool(0.3) {
            words.extend(any_job(model, self.kind, &mut self.rng).as_words());
        } else {
            self.stimuli.next_of(self.kind, &mut words);
        }
        self.disturb(&mut words);
        words
    }

    /// Replaces numbers of about half of the jobs.
    fn disturb(&mut self, words: &mut [u64]) {
        let rng = &mut self.rng;
        let numbers = words.iter_mut().zip(self.inputs).filter(|(_, port)| port.kind == PortKind::Number);
        match rng.random_range(0..6) {
            // Special numbers.
            0 => {
                const SPECIAL: [f32; 7] = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1.0, -1.0];
                let share = [0.1, 0.3][rng.random_range(0..2)];
                for (word, _) in numbers {
                    if rng.random_bool(share) {
                        *word = one_of(&SPECIAL, rng);
                    }
                }
            }
            // Zeros and infinities along an axis: an inverse of zero matters only beside an infinite bound.
            1 => {
                const SPECIAL: [f32; 4] = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY];
                let axis = ["x", "y", "z"][rng.random_range(0..3)];
                let has = |port: &Port, wanted: &str| port.name.split('_').any(|part| part == wanted);
                for (word, port) in numbers.filter(|(_, port)| has(port, axis) && !has(port, "origin")) {
                    if has(port, "inv") || rng.random_bool(0.25) {
                        *word = one_of(&SPECIAL, rng);
                    }
                }
            }
            // Numbers near one with a short significand: a margin matters only there.
            2 => {
                let dropped = rng.random_range(1..17);
                for (word, _) in numbers {
                    if rng.random_bool(0.5) {
                        *word =
                            ((*word >> dropped << dropped) as u32).wrapping_add_signed(rng.random_range(-5..=5)).into();
                    }
                }
            }
            _ => {}
        }
    }

    /// Two jobs between these that differ in one word, by a unit if it is a number, and for which the operation decides
    /// differently: the words of its outcome that are no numbers differ. None if it decides alike for these.
    fn next_to_decision(&mut self, from: Vec<u64>, to: Vec<u64>) -> Option<[Vec<u64>; 2]> {
        let mut places: Vec<usize> = (0..from.len()).filter(|&place| from[place] != to[place]).collect();
        places.shuffle(&mut self.rng);
        let with = |count: usize| {
            let mut words = from.clone();
            places[..count].iter().for_each(|&place| words[place] = to[place]);
            words
        };
        let first = self.decision(&from);
        // The numbers of replaced words, with the decision of `from` and with another one.
        let (mut low, mut high) = (0, places.len());
        if self.decision(&to) == first {
            return None;
        }
        while high - low > 1 {
            let middle = (low + high) / 2;
            *(if self.decision(&with(middle)) == first { &mut low } else { &mut high }) = middle;
        }
        let (mut before, mut after) = (with(low), with(high));
        let place = places[low];
        if self.inputs[place].kind == PortKind::Number {
            let (mut low, mut high) = (position(before[place]), position(after[place]));
            while (high - low).abs() > 1 {
                let middle = (low + high) / 2;
                before[place] = number(middle);
                *(if self.decision(&before) == first { &mut low } else { &mut high }) = middle;
            }
            (before[place], after[place]) = (number(low), number(high));
        }
        Some([before, after])
    }

    /// The words of the outcome that are no numbers. A job that finds another state can be decided differently.
    fn decision(&mut self, words: &[u64]) -> Vec<u64> {
        self.decider.reset();
        let outcome = self.decider.run(&self.decider.job_of_words(self.kind, words));
        let ports = self.decider.outputs(self.kind).iter();
        ports.zip(outcome.as_words()).filter(|(port, _)| port.kind != PortKind::Number).map(|(_, &word)| word).collect()
    }
}

fn one_of(numbers: &[f32], rng: &mut ChaCha8Rng) -> u64 {
    numbers[rng.random_range(0..numbers.len())].to_bits().into()
}

/// The place of a binary32 number in the order of all: neighbours differ by 1, and −0 is before +0.
fn position(word: u64) -> i64 {
    let magnitude = (word & 0x7fff_ffff) as i64;
    if word >> 31 & 1 == 1 { -1 - magnitude } else { magnitude }
}

fn number(position: i64) -> u64 {
    if position < 0 { 0x8000_0000 | (-1 - position) as u64 } else { position as u64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::{Config, Lanes};
    use raypath_verify_datapath::datapaths::TestedDatapath;

    /// The sum of the second overflows, if it is added to the first.
    #[test]
    fn equal_jobs_are_decided_alike() {
        let config = Config::DEFAULT.lanes(Lanes::Two).exception_flags(true);
        let model = TestedDatapath::from(config).datapath().model();
        let kind = model.kinds().into_iter().find(|kind| kind.name() == "euclidean").expect("Euclidean distance");
        let word =
            |port: &Port| if port.kind == PortKind::Number { (1.5 * 2_f32.powi(63)).to_bits().into() } else { 0 };
        let mut job: Vec<u64> = model.inputs(kind).iter().map(word).collect();
        job[0] = 0;
        job[model.inputs(kind).iter().position(|port| port.name.contains("mask")).expect("a mask")] = 1;
        let mut source = Source::new(&model, kind, 1);
        assert_eq!(source.decision(&job), source.decision(&job));
        assert_eq!(source.next_to_decision(job.clone(), job), None);
    }
}
