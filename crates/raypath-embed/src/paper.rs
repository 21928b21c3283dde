//! Single jobs of the paper's operations in native binary32.

use crate::job::{Beat, Outcome, lanes};
use crate::layout::{Bounds, Ray, Vertices};
use raypath_model::{Functional, State, StateWords};
use raypath_ops::{self as ops, BeatInput, Binary32, Flags, JobKind, RayBoxInput, RayTriangleInput, Rules};

/// The functional model of the paper's operations, for any number of lanes.
// The outcome is written where it stays. A copy would read it in pieces of other sizes than it was written in, which
// stalls the processor.
pub trait Native: Send {
    /// Tests a ray against four boxes.
    fn quadbox(&mut self, ray: &Ray, boxes: &[Bounds; 4], outcome: &mut Outcome);
    /// Tests a ray against a triangle.
    fn triangle(&mut self, ray: &Ray, triangle: &Vertices, outcome: &mut Outcome);
    /// Adds a beat to the Euclidean distance.
    fn euclidean(&mut self, beat: &Beat<'_>, outcome: &mut Outcome);
    /// Adds a beat to the angular distance.
    fn angular(&mut self, beat: &Beat<'_>, outcome: &mut Outcome);
    /// Computes a job from the words at its ports.
    fn run_words(&mut self, kind: JobKind, inputs: &[u64]) -> Vec<u64>;
    /// Sets the accumulators to zero.
    fn restart(&mut self);
    /// Passes the accumulators.
    fn pass(&mut self, words: &mut StateWords<'_>);
    /// The same model once more.
    fn boxed(&self) -> Box<dyn Native>;
}

impl Clone for Box<dyn Native> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// The model of `E` Euclidean and `A` angular lanes.
#[derive(Clone)]
pub struct PaperModel<const E: usize, const A: usize> {
    model: Functional<E, A>,
    euclidean: LastMask<E>,
    angular: LastMask<A>,
}

/// The mask of the last beat as a number and as flags. Most beats have the mask of the one before, and to unpack one
/// takes as long as the beat itself.
#[derive(Clone)]
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
    fn quadbox(&mut self, ray: &Ray, boxes: &[Bounds; 4], outcome: &mut Outcome) {
        let aabb = boxes.each_ref().map(ops::Aabb::from);
        *outcome = Outcome::Quadbox(self.model.quadbox(&RayBoxInput { ray: ray.into(), aabb }).into());
    }

    fn triangle(&mut self, ray: &Ray, triangle: &Vertices, outcome: &mut Outcome) {
        let input = RayTriangleInput { ray: ray.into(), triangle: triangle.into() };
        *outcome = Outcome::Triangle(self.model.triangle(&input).into());
    }

    fn euclidean(&mut self, beat: &Beat<'_>, outcome: &mut Outcome) {
        *outcome = Outcome::Euclidean(self.model.euclidean(&self.euclidean.input(beat)).into());
    }

    fn angular(&mut self, beat: &Beat<'_>, outcome: &mut Outcome) {
        *outcome = Outcome::Angular(self.model.angular(&self.angular.input(beat)).into());
    }

    fn run_words(&mut self, kind: JobKind, inputs: &[u64]) -> Vec<u64> {
        let mut words = Vec::new();
        self.model.run(&ops::Job::from_words_in(Binary32, kind, inputs)).words(&mut words);
        words
    }

    fn restart(&mut self) {
        self.model.reset();
    }

    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.model.pass(words);
    }

    fn boxed(&self) -> Box<dyn Native> {
        Box::new(self.clone())
    }
}

impl<const N: usize> LastMask<N> {
    fn new() -> Self {
        Self { mask: 0, flags: Flags::from_mask(0) }
    }

    #[inline(always)]
    fn input(&mut self, &Beat { a, b, mask, reset_accum }: &Beat<'_>) -> BeatInput<Binary32, N> {
        if self.mask != mask {
            *self = Self { mask, flags: Flags::from_mask(mask) };
        }
        let (a, b) = (lanes(a), lanes(b));
        BeatInput { euclidean: ops::Beat { a, b, mask: self.flags, reset_accum: reset_accum.into() } }
    }
}
