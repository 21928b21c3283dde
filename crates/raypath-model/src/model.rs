use raypath_ops::{Concrete, Job, JobKind, Outcome, PortValue};
use std::fmt::Debug;

/// What answers jobs, one after another, and remembers what they leave for the next: the arithmetic of a datapath,
/// without time. Everything that carries jobs is generic over it: over lanes and numbers at once.
pub trait Model: Clone + Debug + PartialEq {
    /// What goes in.
    type Job: OnPorts;
    /// What comes out.
    type Outcome: OnPorts;

    /// Answers a job.
    fn run(&mut self, job: &Self::Job) -> Self::Outcome;

    /// A hardware reset: nothing is remembered.
    fn reset(&mut self);

    /// The job of this kind whose ports have the values that `port` gives by name.
    fn job(&self, kind: JobKind, port: impl FnMut(&str) -> u64) -> Self::Job;

    /// The outcome of this kind whose ports have the values that `port` gives by name.
    fn outcome(&self, kind: JobKind, port: impl FnMut(&str) -> u64) -> Self::Outcome;

    /// The job of this kind whose [`words`](OnPorts::words) are these.
    fn job_of_words(&self, kind: JobKind, words: &[u64]) -> Self::Job;

    /// The outcome of this kind whose [`words`](OnPorts::words) are these.
    fn outcome_of_words(&self, kind: JobKind, words: &[u64]) -> Self::Outcome;
}

/// A job or an outcome, of any model.
pub trait OnPorts: Copy + Debug + PartialEq {
    /// Which operation it belongs to.
    fn kind(&self) -> JobKind;

    /// The values of its ports, numbers in IEEE 754's layout; the opcode is not among them.
    fn ports(&self) -> Vec<PortValue>;

    /// The bits of its ports in the order of [`ports`](Self::ports), in place of what `words` held: for who knows ports
    /// by their places, and has no time for names.
    fn words(&self, words: &mut Vec<u64>);
}

impl<const E: usize, const A: usize, C: Concrete> OnPorts for Job<E, A, C> {
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
