use raypath_ops::{Concrete, Job, JobKind, Outcome};
use std::fmt::{Debug, Display};

/// The arithmetic of a datapath, without time: computes the outcomes of jobs one after another, and keeps the
/// accumulators between them. [`CycleModel`](crate::CycleModel) adds the timing.
///
/// [`WordModel`](crate::WordModel) computes jobs of any operations, as words at their ports.
/// [`Functional`](crate::Functional) computes jobs of the paper's operations in their own types, which is faster.
pub trait Model: Clone + Debug + PartialEq {
    /// The operation of a job.
    type Kind: Kind;
    /// A job.
    type Job: OfKind<Kind = Self::Kind>;
    /// The outcome of a job.
    type Outcome: OfKind<Kind = Self::Kind>;

    /// Computes a job.
    fn run(&mut self, job: &Self::Job) -> Self::Outcome;

    /// A hardware reset: the accumulators are zero.
    fn reset(&mut self);
}

/// An operation that a job names.
pub trait Kind: Copy + Debug + Display + Eq {
    /// The value of the ports `opcode_i` and `opcode_o`.
    fn opcode(self) -> u64;
}

impl Kind for JobKind {
    #[inline]
    fn opcode(self) -> u64 {
        self.opcode()
    }
}

/// A job or an outcome, which belongs to an operation.
pub trait OfKind: Clone + Debug + PartialEq {
    /// The type that names operations.
    type Kind: Kind;

    /// The operation.
    fn kind(&self) -> Self::Kind;
}

impl<const E: usize, const A: usize, C: Concrete> OfKind for Job<E, A, C> {
    type Kind = JobKind;

    #[inline]
    fn kind(&self) -> JobKind {
        self.kind()
    }
}

impl<C: Concrete> OfKind for Outcome<C> {
    type Kind = JobKind;

    #[inline]
    fn kind(&self) -> JobKind {
        self.kind()
    }
}
