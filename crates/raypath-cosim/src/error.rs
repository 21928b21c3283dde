use std::path::PathBuf;
use thiserror::Error;

/// Why text could not be linted, built or run.
#[derive(Debug, Error)]
pub enum CosimError {
    /// A tool is not installed.
    #[error("{tool} not found; install it with: {install}")]
    MissingTool {
        /// The command that was tried.
        tool: String,
        /// What installs it on Debian.
        install: &'static str,
    },
    /// A tool failed, or found fault with the text.
    #[error("{tool} failed:\n{output}")]
    Tool {
        /// The command.
        tool: String,
        /// All that it printed.
        output: String,
    },
    /// The netlist could not be printed.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
    /// A file could not be written, or a program not be talked to.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file or program.
        path: PathBuf,
        /// What the system said.
        problem: std::io::Error,
    },
    /// A frame does not have a word for each input.
    #[error("frame {cycle} has {found} words, expected {expected}")]
    Frame {
        /// The frame's number, from 0.
        cycle: usize,
        /// Its words.
        found: usize,
        /// `rst_ni`, if there is one, and the inputs.
        expected: usize,
    },
}
