//! Why a verification could not run.

use std::path::Path;
use thiserror::Error;

/// Why a verification could not run. A claim that does not hold is no error: it is a failure in a verdict.
#[derive(Debug, Error)]
pub enum Error {
    /// A program's result is not what it should be.
    #[error("{program}: {problem}, expected {expected}")]
    Program {
        /// The program.
        program: String,
        /// What was found.
        problem: String,
        /// What was expected, or what to do.
        expected: String,
    },
    /// An external program is missing, fails, or was stopped.
    #[error(transparent)]
    Tool(#[from] raypath_tools::ToolError),
    /// A file cannot be read or written.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// The operating system's error.
        problem: std::io::Error,
    },
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A number format with these widths does not exist.
    #[error(transparent)]
    Format(#[from] raypath_float::FormatError),
    /// A module cannot be built or compiled.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}

/// The error of a file operation.
pub(crate) fn file(path: &Path, problem: std::io::Error) -> Error {
    Error::File { path: path.to_path_buf(), problem }
}
