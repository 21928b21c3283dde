use crate::kernels::ModelCircuit;
use crate::model::Model;
use raypath_ops::{
    Angular, AngularState, Binary32, Euclidean, EuclideanState, Job, JobKind, KernelOperation, Outcome, RayBox,
    RayTriangle, Rules,
};

/// What the datapath answers, job by job: the operations over the numbers of circuit `C`, by default the machine's own
/// binary32, and their accumulators.
#[derive(Debug, Clone, PartialEq)]
pub struct Functional<const E: usize = 16, const A: usize = 8, C: ModelCircuit = Binary32> {
    circuit: C,
    rules: Rules,
    euclidean: EuclideanState<C>,
    angular: AngularState<C>,
}

impl<const E: usize, const A: usize> Functional<E, A> {
    /// A datapath over binary32 whose accumulators are zero.
    pub fn new(rules: Rules) -> Self {
        Self::over(Binary32, rules)
    }
}

impl<const E: usize, const A: usize, C: ModelCircuit> Functional<E, A, C> {
    /// A datapath over the numbers of `circuit` whose accumulators are zero.
    pub fn over(circuit: C, rules: Rules) -> Self {
        let zero = circuit.zero();
        Self {
            circuit,
            rules,
            euclidean: EuclideanState { accumulator: zero },
            angular: AngularState { dot_product: zero, norm: zero },
        }
    }

    /// Answers a job; a beat of a distance job leaves its sum for the next.
    #[inline]
    pub fn run(&mut self, job: &Job<E, A, C>) -> Outcome<C> {
        let (circuit, rules) = (self.circuit, self.rules);
        match job {
            Job::Triangle(input) => {
                Outcome::Triangle(RayTriangle { rules }.run_with(circuit, C::KERNELS, *input, ()).0)
            }
            Job::Quadbox(input) => Outcome::Quadbox(RayBox { rules }.run_with(circuit, C::KERNELS, *input, ()).0),
            Job::Euclidean(input) => {
                let (output, state) = Euclidean::<E>.run_with(circuit, C::KERNELS, *input, self.euclidean);
                self.euclidean = state;
                Outcome::Euclidean(output)
            }
            Job::Angular(input) => {
                let (output, state) = Angular::<A>.run_with(circuit, C::KERNELS, *input, self.angular);
                self.angular = state;
                Outcome::Angular(output)
            }
        }
    }

    /// A hardware reset: the accumulators are zero again.
    pub fn reset(&mut self) {
        *self = Self::over(self.circuit, self.rules);
    }
}

impl<const E: usize, const A: usize, C: ModelCircuit> Model for Functional<E, A, C> {
    type Kind = JobKind;
    type Job = Job<E, A, C>;
    type Outcome = Outcome<C>;

    fn kinds(&self) -> Vec<JobKind> {
        JobKind::ALL.to_vec()
    }

    /// Not inlined: a program that offers all configurations has this function for each of them.
    #[inline(never)]
    fn run(&mut self, job: &Job<E, A, C>) -> Outcome<C> {
        self.run(job)
    }
    fn reset(&mut self) {
        self.reset();
    }
    fn job(&self, kind: JobKind, port: impl FnMut(&str) -> u64) -> Job<E, A, C> {
        Job::from_ports_in(self.circuit, kind, port)
    }
    fn outcome(&self, kind: JobKind, port: impl FnMut(&str) -> u64) -> Outcome<C> {
        Outcome::from_ports_in(self.circuit, kind, port)
    }
    fn job_of_words(&self, kind: JobKind, words: &[u64]) -> Job<E, A, C> {
        Job::from_words_in(self.circuit, kind, words)
    }
    fn outcome_of_words(&self, kind: JobKind, words: &[u64]) -> Outcome<C> {
        Outcome::from_words_in(self.circuit, kind, words)
    }
}
