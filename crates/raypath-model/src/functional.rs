use raypath_ops::{
    Angular, AngularState, Binary32, Euclidean, EuclideanState, Job, Operation, Outcome, RayBox, RayTriangle, Rules,
};

/// What the datapath answers, job by job: the operations over the machine's own binary32, and their accumulators.
#[derive(Debug, Clone)]
pub struct Functional<const E: usize = 16, const A: usize = 8> {
    rules: Rules,
    euclidean: EuclideanState<Binary32>,
    angular: AngularState<Binary32>,
}

impl<const E: usize, const A: usize> Functional<E, A> {
    /// A datapath whose accumulators are zero.
    pub fn new(rules: Rules) -> Self {
        let zero = 0.0.into();
        Self {
            rules,
            euclidean: EuclideanState { accumulator: zero },
            angular: AngularState { dot_product: zero, norm: zero },
        }
    }

    /// Answers a job; a beat of a distance job leaves its sum for the next.
    #[inline]
    pub fn run(&mut self, job: &Job<E, A>) -> Outcome {
        let rules = self.rules;
        match job {
            Job::Triangle(input) => Outcome::Triangle(RayTriangle { rules }.run(Binary32, *input, ()).0),
            Job::Quadbox(input) => Outcome::Quadbox(RayBox { rules }.run(Binary32, *input, ()).0),
            Job::Euclidean(input) => {
                let (output, state) = Euclidean::<E>.run(Binary32, *input, self.euclidean);
                self.euclidean = state;
                Outcome::Euclidean(output)
            }
            Job::Angular(input) => {
                let (output, state) = Angular::<A>.run(Binary32, *input, self.angular);
                self.angular = state;
                Outcome::Angular(output)
            }
        }
    }

    /// A hardware reset: the accumulators are zero again.
    pub fn reset(&mut self) {
        *self = Self::new(self.rules);
    }
}
