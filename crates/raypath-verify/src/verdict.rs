//! What a piece of verification found.

use thiserror::Error;

/// What was covered, and what was wrong.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Verdict {
    /// What was tried or proved, with numbers, in a line: "7,496,192 cases of each of 4 functions".
    pub covered: String,
    /// What is wrong, a line each; the first few. Empty where all is well.
    pub failures: Vec<String>,
    /// What a reader should know besides: what was not hit, what was skipped.
    pub remarks: Vec<String>,
    /// Whether the user stopped it before all was done.
    pub is_stopped: bool,
}

/// Why something could not be verified at all.
#[derive(Debug, Error)]
pub enum Error {
    /// A program's result is not what it should be.
    #[error("{program}: {problem}, expected {expected}")]
    Program {
        /// The program.
        program: String,
        /// What is wrong with it.
        problem: String,
        /// What would help.
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
        /// What the system said.
        problem: std::io::Error,
    },
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// There is no such number format.
    #[error(transparent)]
    Format(#[from] raypath_float::FormatError),
    /// A module cannot be built or compiled.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}
