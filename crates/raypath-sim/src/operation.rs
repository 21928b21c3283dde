//! Operations whose types are forgotten, so that a list can hold them.

use crate::dynamic::Dynamic;
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, Port, from_words, ports_of, to_canonical_words, to_words};
use raypath_rtl::{Error, Operations};
use std::cell::Cell;

/// An operation as words in and words out, and as a part of a datapath.
pub trait AnyOperation: Send + Sync {
    /// [`Operation::NAME`].
    fn name(&self) -> &'static str;

    /// The ports of its jobs, there or not.
    fn inputs(&self) -> Vec<Port>;

    /// The ports of its answers, there or not.
    fn outputs(&self) -> Vec<Port>;

    /// Whether an input port is there: [`Operation::has_input`].
    fn has_input(&self, port: &str) -> bool;

    /// Whether an output port is there: [`Operation::has_output`].
    fn has_output(&self, port: &str) -> bool;

    /// Answers a job, given on all inputs, in numbers of `format`, on all outputs, there or not. `state` is what the
    /// job before left, empty at first; this leaves another. In binary32 `raised` gets the exceptions of additions and
    /// multiplications.
    fn answer(&self, format: Format, job: &[u64], state: &mut Vec<u64>, raised: Option<&Cell<u64>>) -> Vec<u64>;

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

    fn has_input(&self, port: &str) -> bool {
        Operation::has_input(self, port)
    }

    fn has_output(&self, port: &str) -> bool {
        Operation::has_output(self, port)
    }

    fn answer(&self, format: Format, job: &[u64], state: &mut Vec<u64>, raised: Option<&Cell<u64>>) -> Vec<u64> {
        let circuit = Dynamic::new(format, raised);
        let (output, next) = self.run(circuit, from_words(circuit, job), from_words(circuit, state));
        to_words(&next, state);
        let mut answer = Vec::new();
        to_canonical_words(&output, &mut answer);
        answer
    }

    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error> {
        operations.with(self, opcode)
    }
}
