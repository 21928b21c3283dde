use raypath_model::WordOperation;
use raypath_ops::Operation;
use raypath_rtl::{Error, Operations};

/// An operation of any type: a function on words ([`WordOperation`]) and a part of a datapath.
pub trait AnyOperation: WordOperation {
    /// Adds the operation to those of a datapath.
    ///
    /// # Errors
    /// An operation that does not fit: those of [`Operations::with`].
    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error>;
}

impl<O: Operation + Send + Sync> AnyOperation for O {
    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error> {
        operations.with(self, opcode)
    }
}
