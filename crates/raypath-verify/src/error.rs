//! Why a verification could not run.

use thiserror::Error;

/// Why a verification could not run. A claim that does not hold is no error: it is a failure in a verdict.
#[derive(Debug, Error)]
pub enum Error {
    /// An external program is missing, fails, was stopped, or has an unexpected result; or a file cannot be read or
    /// written.
    #[error(transparent)]
    Tool(#[from] raypath_tools::ToolError),
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A number format with these widths does not exist.
    #[error(transparent)]
    Format(#[from] raypath_float::FormatError),
    /// A module cannot be built or compiled.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
    /// What is verified cannot be built.
    #[error(transparent)]
    Subject(Box<dyn std::error::Error + Send + Sync>),
    /// A text names no shard.
    #[error(transparent)]
    Shard(#[from] raypath_work::pool::ShardError),
}

impl Error {
    /// The error of a crate whose errors have no variant here.
    pub fn subject(problem: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Subject(Box::new(problem))
    }
}
