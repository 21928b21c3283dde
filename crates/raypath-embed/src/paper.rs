//! Single jobs of the paper's operations in native binary32.

use crate::job::{Beat, Job, Outcome, lanes};
use raypath_model::Functional;
use raypath_ops::{self as ops, BeatInput, Binary32, Flags, JobKind, RayBoxInput, RayTriangleInput, Rules};
use std::collections::VecDeque;

/// The functional model of the paper's operations, for any number of lanes.
pub trait Native: Send {
    /// Computes a job in the types of an operation of the paper, and appends the outcome.
    // It writes the outcome where it stays. A copy would read it in pieces of other sizes than it was written in, which
    // stalls the processor.
    fn run(&mut self, job: &Job<'_>, tag: u64, outcomes: &mut VecDeque<(u64, Outcome)>);
    /// Computes a job from the words at its ports.
    fn run_words(&mut self, kind: JobKind, inputs: &[u64]) -> Vec<u64>;
    /// Sets the accumulators to zero.
    fn restart(&mut self);
}

/// The model of `E` Euclidean and `A` angular lanes.
pub struct PaperModel<const E: usize, const A: usize> {
    model: Functional<E, A>,
    euclidean: LastMask<E>,
    angular: LastMask<A>,
}

/// The mask of the last beat as a number and as flags. Most beats have the mask of the one before, and to unpack one
/// takes as long as the beat itself.
struct LastMask<const N: usize> {
    mask: u64,
    flags: Flags<Binary32, N>,
}

impl<const E: usize, const A: usize> PaperModel<E, A> {
    pub fn new(rules: Rules) -> Self {
        Self { model: Functional::new(rules), euclidean: LastMask::new(), angular: LastMask::new() }
    }
}

impl<const E: usize, const A: usize> Native for PaperModel<E, A> {
    fn run(&mut self, job: &Job<'_>, tag: u64, outcomes: &mut VecDeque<(u64, Outcome)>) {
        let outcome = match *job {
            Job::Quadbox { ray, boxes } => {
                let aabb = boxes.each_ref().map(ops::Aabb::from);
                self.model.run(&ops::Job::Quadbox(RayBoxInput { ray: ray.into(), aabb }))
            }
            Job::Triangle { ray, triangle } => {
                self.model.run(&ops::Job::Triangle(RayTriangleInput { ray: ray.into(), triangle: triangle.into() }))
            }
            Job::Euclidean(beat) => self.model.run(&ops::Job::Euclidean(self.euclidean.input(beat))),
            Job::Angular(beat) => self.model.run(&ops::Job::Angular(self.angular.input(beat))),
            Job::Words { .. } | Job::Timing { .. } => return,
        };
        match outcome {
            ops::Outcome::Quadbox(output) => outcomes.push_back((tag, Outcome::Quadbox(output.into()))),
            ops::Outcome::Triangle(output) => outcomes.push_back((tag, Outcome::Triangle(output.into()))),
            ops::Outcome::Euclidean(output) => outcomes.push_back((tag, Outcome::Euclidean(output.into()))),
            ops::Outcome::Angular(output) => outcomes.push_back((tag, Outcome::Angular(output.into()))),
        }
    }

    fn run_words(&mut self, kind: JobKind, inputs: &[u64]) -> Vec<u64> {
        let mut words = Vec::new();
        self.model.run(&ops::Job::from_words_in(Binary32, kind, inputs)).words(&mut words);
        words
    }

    fn restart(&mut self) {
        self.model.reset();
    }
}

impl<const N: usize> LastMask<N> {
    fn new() -> Self {
        Self { mask: 0, flags: Flags::from_mask(0) }
    }

    #[inline(always)]
    fn input(&mut self, Beat { a, b, mask, reset_accum }: Beat<'_>) -> BeatInput<Binary32, N> {
        if self.mask != mask {
            *self = Self { mask, flags: Flags::from_mask(mask) };
        }
        let (a, b) = (lanes(a), lanes(b));
        BeatInput { euclidean: ops::Beat { a, b, mask: self.flags, reset_accum: reset_accum.into() } }
    }
}
