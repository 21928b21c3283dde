use raypath_sim::InputError;
use raypath_sim::files::FileError;
use thiserror::Error;

/// Why a call failed.
#[derive(Debug, Error)]
pub enum Error {
    /// A configuration that is not valid.
    #[error(transparent)]
    Configuration(#[from] InputError),
    /// A datapath that cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A traversal unit that cannot be built.
    #[error(transparent)]
    Unit(#[from] raypath_traversal::UnitError),
    /// A datapath without the operation.
    #[error("'{name}' is not an operation of this datapath, expected {expected}")]
    Operation {
        /// The name or opcode that was given.
        name: String,
        /// The names of the datapath's operations.
        expected: String,
    },
    /// An argument that is not valid: what was found, and what was expected.
    #[error("{0}")]
    Argument(String),
    /// A file that cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl From<raypath_hdl::Error> for Error {
    fn from(error: raypath_hdl::Error) -> Self {
        Self::Elaboration(error.into())
    }
}
