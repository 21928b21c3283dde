//! Operations whose types are forgotten, so that a list can hold them.

use raypath_format::Format;
use raypath_model::Soft;
use raypath_ops::{Binary32, Concrete, Operation, Port, from_words, ports_of, to_canonical_words, to_words};
use raypath_rtl::{Error, Operations};

/// An operation as words in and words out, and as a part of a datapath.
pub trait AnyOperation: Send + Sync {
    /// [`Operation::NAME`].
    fn name(&self) -> &'static str;

    /// The ports of its jobs, read or not.
    fn inputs(&self) -> Vec<Port>;

    /// The ports of its answers.
    fn outputs(&self) -> Vec<Port>;

    /// Answers a job in numbers of `format`. `state` is what the job before left, empty at first; this leaves another.
    fn answer(&self, format: Format, job: &[u64], state: &mut Vec<u64>) -> Vec<u64>;

    /// Adds it to the operations of a datapath.
    ///
    /// # Errors
    /// An operation that does not fit: those of [`Operations::with`].
    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error>;
}

impl<O: Operation + Send + Sync> AnyOperation for O {
    fn name(&self) -> &'static str {
        O::NAME
    }

    fn inputs(&self) -> Vec<Port> {
        ports_of::<O::Input<Binary32>>()
    }

    fn outputs(&self) -> Vec<Port> {
        ports_of::<O::Output<Binary32>>()
    }

    fn answer(&self, format: Format, job: &[u64], state: &mut Vec<u64>) -> Vec<u64> {
        if format == Format::BINARY32 {
            answer_over(self, Binary32, job, state)
        } else {
            answer_over(self, Soft { format }, job, state)
        }
    }

    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error> {
        operations.with(self, opcode)
    }
}

fn answer_over<O: Operation, C: Concrete>(operation: &O, circuit: C, job: &[u64], state: &mut Vec<u64>) -> Vec<u64> {
    let (output, next) = operation.run(circuit, from_words(circuit, job), from_words(circuit, state));
    to_words(&next, state);
    let mut answer = Vec::new();
    to_canonical_words(&output, &mut answer);
    answer
}
