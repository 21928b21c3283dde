use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a design could not be measured.
#[derive(Debug, Error)]
pub enum Error {
    /// The system refused something about a file.
    #[error("{}: cannot {doing}: {problem}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What was tried: "read".
        doing: &'static str,
        /// What the system said.
        problem: std::io::Error,
    },
    /// A cell library is no Liberty file.
    #[error("{}:{line}: found {found}, expected {expected}", path.display())]
    Liberty {
        /// The library.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What a Liberty file has there.
        expected: &'static str,
    },
    /// A cell library lacks something without which nothing can be measured.
    #[error("{}: no {what} in this library, expected one", path.display())]
    Lacks {
        /// The library.
        path: PathBuf,
        /// What it should have.
        what: String,
    },
    /// A tool is not installed.
    #[error("{program} not found; install it with: {install}")]
    MissingTool {
        /// The program that was tried.
        program: String,
        /// What installs it.
        install: &'static str,
    },
    /// A tool failed.
    #[error("{program} failed{}:\n{output}", about.as_ref().map(|name| format!(" on {name}")).unwrap_or_default())]
    Tool {
        /// The program.
        program: String,
        /// The module that it worked on.
        about: Option<String>,
        /// The end of what it printed.
        output: String,
    },
    /// A tool did something that this crate does not understand.
    #[error("{program}: {found}, expected {expected}")]
    Unexpected {
        /// The program.
        program: String,
        /// What came out.
        found: String,
        /// What should have come out.
        expected: String,
    },
    /// The netlist could not be printed.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
    /// Whoever watches wanted to stop.
    #[error("stopped")]
    Stopped,
}

impl Error {
    pub(crate) fn file(path: &Path, doing: &'static str, problem: std::io::Error) -> Self {
        Self::File { path: path.to_path_buf(), doing, problem }
    }

    pub(crate) fn unexpected(program: &str, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Unexpected { program: program.to_string(), found: found.into(), expected: expected.into() }
    }
}
