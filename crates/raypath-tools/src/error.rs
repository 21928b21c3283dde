use crate::Program;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why an external program could not do its work.
#[derive(Debug, Error)]
pub enum ToolError {
    /// A program is not installed.
    #[error("{} not found, expected {}; install it with: {}", .0.name, .0.expected, .0.install)]
    Missing(&'static Program),
    /// A program failed, or a linter reported something.
    #[error("{program} failed{}:\n{output}", about.as_ref().map(|name| format!(" on {name}")).unwrap_or_default())]
    Failed {
        /// The program, with its version where it is known.
        program: String,
        /// The module or problem that it worked on.
        about: Option<String>,
        /// What it printed, or the end of it.
        output: String,
    },
    /// A program's result has another form than expected.
    #[error("{program}: {found}, expected {expected}")]
    Unexpected {
        /// The program or file.
        program: String,
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// The system refused an operation on a file, folder or process.
    #[error("{}: cannot {doing}: {problem}", path.display())]
    File {
        /// The file, folder or program.
        path: PathBuf,
        /// The operation: "read".
        doing: &'static str,
        /// The system's error.
        problem: std::io::Error,
    },
    /// A module cannot be printed as SystemVerilog.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
    /// A frame of stimuli does not have a word for each input.
    #[error("frame {cycle} has {found} words, expected {expected}")]
    Frame {
        /// The frame's number, from 0.
        cycle: usize,
        /// Its words.
        found: usize,
        /// Words expected: `rst_ni`, if the module has a reset, and the inputs.
        expected: usize,
    },
    /// The user stopped the run.
    #[error("stopped")]
    Stopped,
}

impl ToolError {
    /// The system refused to do this with a file.
    pub fn file(path: &Path, doing: &'static str, problem: std::io::Error) -> Self {
        Self::File { path: path.to_path_buf(), doing, problem }
    }

    /// A program's result has another form than expected.
    pub fn unexpected(program: &str, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Unexpected { program: program.to_string(), found: found.into(), expected: expected.into() }
    }
}
