use raypath_ops::{Concrete, Job, JobKind, Outcome, PortValue};
use std::fmt::{Debug, Display};

/// What answers jobs, one after another, and remembers what they leave for the next: the arithmetic of a datapath,
/// without time. Everything that carries jobs is generic over it: over lanes and numbers at once.
pub trait Model: Clone + Debug + PartialEq {
    /// Which operation a job is for.
    type Kind: Kind;
    /// What goes in.
    type Job: OnPorts<Kind = Self::Kind>;
    /// What comes out.
    type Outcome: OnPorts<Kind = Self::Kind>;

    /// The operations that it answers, in order of their opcodes.
    fn kinds(&self) -> Vec<Self::Kind>;

    /// Answers a job.
    fn run(&mut self, job: &Self::Job) -> Self::Outcome;

    /// A hardware reset: nothing is remembered.
    fn reset(&mut self);

    /// The job of this kind whose ports have the values that `port` gives by name.
    fn job(&self, kind: Self::Kind, port: impl FnMut(&str) -> u64) -> Self::Job;

    /// The outcome of this kind whose ports have the values that `port` gives by name.
    fn outcome(&self, kind: Self::Kind, port: impl FnMut(&str) -> u64) -> Self::Outcome;

    /// The job of this kind whose [`words`](OnPorts::words) are these.
    fn job_of_words(&self, kind: Self::Kind, words: &[u64]) -> Self::Job;

    /// The outcome of this kind whose [`words`](OnPorts::words) are these.
    fn outcome_of_words(&self, kind: Self::Kind, words: &[u64]) -> Self::Outcome;
}

/// An operation, as jobs name it.
pub trait Kind: Copy + Debug + Display + Eq {
    /// What stands for it on the ports `opcode_i` and `opcode_o`.
    fn opcode(self) -> u64;
}

impl Kind for JobKind {
    #[inline]
    fn opcode(self) -> u64 {
        self.opcode()
    }
}

/// A job or an outcome, of any model.
pub trait OnPorts: Clone + Debug + PartialEq {
    /// How it names its operation.
    type Kind: Kind;

    /// Which operation it belongs to.
    fn kind(&self) -> Self::Kind;

    /// The values of its ports, numbers in IEEE 754's layout; the opcode is not among them.
    fn ports(&self) -> Vec<PortValue>;

    /// The bits of its ports in the order of [`ports`](Self::ports), in place of what `words` held: for who knows ports
    /// by their places, and has no time for names.
    fn words(&self, words: &mut Vec<u64>);
}

impl<const E: usize, const A: usize, C: Concrete> OnPorts for Job<E, A, C> {
    type Kind = JobKind;

    #[inline]
    fn kind(&self) -> JobKind {
        self.kind()
    }
    fn ports(&self) -> Vec<PortValue> {
        self.ports()
    }
    fn words(&self, words: &mut Vec<u64>) {
        self.words(words);
    }
}

impl<C: Concrete> OnPorts for Outcome<C> {
    type Kind = JobKind;

    #[inline]
    fn kind(&self) -> JobKind {
        self.kind()
    }
    fn ports(&self) -> Vec<PortValue> {
        self.ports()
    }
    fn words(&self, words: &mut Vec<u64>) {
        self.words(words);
    }
}
