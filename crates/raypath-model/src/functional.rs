use crate::{Model, ModelCircuit, State, StateWords};
use raypath_ops::{
    Angular, AngularOutput, AngularState, BeatInput, Binary32, Euclidean, EuclideanOutput, EuclideanState, Job,
    JobKind, Operation, Outcome, RayBox, RayBoxInput, RayBoxOutput, RayTriangle, RayTriangleInput, RayTriangleOutput,
    Rounding, Rules,
};

/// The functional model of the paper's operations over circuit `C` (the machine's binary32 by default), with `E`
/// Euclidean and `A` angular lanes. Its jobs are in their own types: it is faster than [`WordModel`](crate::WordModel).
#[derive(Debug, Clone, PartialEq)]
pub struct Functional<const E: usize = 16, const A: usize = 8, C: ModelCircuit = Binary32> {
    circuit: C,
    rules: Rules,
    rounding: Rounding,
    is_conservative: bool,
    euclidean: EuclideanState<C>,
    angular: AngularState<C>,
}

impl<const E: usize, const A: usize> State for Functional<E, A> {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.bundle(&mut self.euclidean);
        words.bundle(&mut self.angular);
    }
}

impl<const E: usize, const A: usize> Functional<E, A> {
    /// The model over binary32, with accumulators of zero.
    pub fn new(rules: Rules) -> Self {
        Self::over(Binary32, rules)
    }
}

impl<const E: usize, const A: usize, C: ModelCircuit> Functional<E, A, C> {
    /// The model over `circuit`, with accumulators of zero.
    pub fn over(circuit: C, rules: Rules) -> Self {
        let (euclidean, angular) = (EuclideanState::zero(circuit), AngularState::zero(circuit));
        Self { circuit, rules, rounding: Rounding::Unit, is_conservative: false, euclidean, angular }
    }

    /// The same model with another rounding of sums; [`Rounding::Unit`] by default.
    pub fn rounding(self, rounding: Rounding) -> Self {
        Self { rounding, ..self }
    }

    /// The same model with [conservative](RayBox::is_conservative) boxes, or without them as by default.
    pub fn conservative(self, is_conservative: bool) -> Self {
        Self { is_conservative, ..self }
    }

    /// Computes a job. A beat of a distance updates its accumulator.
    // Always inlined, as are the operations, so that a caller that makes the job for this call does not have to store
    // it.
    #[inline(always)]
    pub fn run(&mut self, job: &Job<E, A, C>) -> Outcome<C> {
        match job {
            Job::Triangle(input) => Outcome::Triangle(self.triangle(input)),
            Job::Quadbox(input) => Outcome::Quadbox(self.quadbox(input)),
            Job::Euclidean(input) => Outcome::Euclidean(self.euclidean(input)),
            Job::Angular(input) => Outcome::Angular(self.angular(input)),
        }
    }

    /// Tests a ray against a triangle.
    #[inline(always)]
    pub fn triangle(&self, input: &RayTriangleInput<C>) -> RayTriangleOutput<C> {
        RayTriangle { rules: self.rules, rounding: self.rounding }.run_with(self.circuit, C::KERNELS, *input, ()).0
    }

    /// Tests a ray against four boxes.
    #[inline(always)]
    pub fn quadbox(&self, input: &RayBoxInput<C>) -> RayBoxOutput<C> {
        let Self { circuit, rules, is_conservative, .. } = *self;
        RayBox { rules, is_conservative }.run_with(circuit, C::KERNELS, *input, ()).0
    }

    /// Adds a beat to the Euclidean distance.
    #[inline(always)]
    pub fn euclidean(&mut self, input: &BeatInput<C, E>) -> EuclideanOutput<C> {
        let operation = Euclidean::<E> { rounding: self.rounding };
        let (output, state) = operation.run_with(self.circuit, C::KERNELS, *input, self.euclidean);
        self.euclidean = state;
        output
    }

    /// Adds a beat to the angular distance.
    #[inline(always)]
    pub fn angular(&mut self, input: &BeatInput<C, A>) -> AngularOutput<C> {
        let operation = Angular::<A> { rounding: self.rounding };
        let (output, state) = operation.run_with(self.circuit, C::KERNELS, *input, self.angular);
        self.angular = state;
        output
    }

    /// A hardware reset: the accumulators are zero.
    pub fn reset(&mut self) {
        (self.euclidean, self.angular) = (EuclideanState::zero(self.circuit), AngularState::zero(self.circuit));
    }
}

impl<const E: usize, const A: usize, C: ModelCircuit> Model for Functional<E, A, C> {
    type Kind = JobKind;
    type Job = Job<E, A, C>;
    type Outcome = Outcome<C>;

    #[inline]
    fn kind(job: &Job<E, A, C>) -> JobKind {
        job.kind()
    }
    // Not inlined, because it is compiled for every number of lanes.
    #[inline(never)]
    fn run(&mut self, job: &Job<E, A, C>) -> Outcome<C> {
        self.run(job)
    }
    fn reset(&mut self) {
        self.reset();
    }
}
