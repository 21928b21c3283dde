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
    /// A unit cannot be synthesised.
    #[error(transparent)]
    Synthesis(#[from] raypath_ppa::Error),
    /// A traversal unit cannot be built.
    #[error(transparent)]
    Unit(#[from] raypath_unit::UnitError),
    /// A text names no shard.
    #[error(transparent)]
    Shard(#[from] raypath_tools::pool::ShardError),
}
