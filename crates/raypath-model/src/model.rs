use raypath_ops::JobKind;
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
    type Job: Clone + Debug + PartialEq;
    /// The outcome of a job.
    type Outcome: Clone + Debug + PartialEq;

    /// The operation of a job.
    fn kind(job: &Self::Job) -> Self::Kind;

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
