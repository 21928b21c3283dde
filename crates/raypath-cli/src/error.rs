use crate::progress::Stopped;
use raypath_sim::files::FileError;
use raypath_tools::ToolError;
use std::io::ErrorKind;
use std::process::ExitCode;
use thiserror::Error;

/// Why an operation could not be studied.
#[derive(Debug, Error)]
pub enum CliError {
    /// It does not fit the datapath.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A tool is missing, or has something to say about the emitted text.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// It could not be measured.
    #[error(transparent)]
    Measurement(#[from] raypath_ppa::Error),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// What is said cannot be written.
    #[error("standard output: {0}")]
    Output(#[from] std::io::Error),
    /// Answers are wrong, or differ from the models'.
    #[error("{0}")]
    Mismatch(String),
    /// The user stopped it.
    #[error("stopped {0}")]
    Stopped(#[from] Stopped),
}

impl CliError {
    /// Whether the reader of standard output has gone, as `head` does: no fault, and nothing to say.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// 1 for a mismatch, 2 for what cannot be used, 130 after Ctrl-C, 141 where the reader has gone (as shells have it).
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Output(_) if self.is_silent() => ExitCode::from(141),
            Self::Mismatch(_) => ExitCode::from(1),
            Self::Stopped(_) => ExitCode::from(130),
            _ => ExitCode::from(2),
        }
    }

    /// Whether a tool is not installed, which need not end a spec.
    pub fn is_missing_tool(&self) -> bool {
        matches!(
            self,
            Self::Tool(ToolError::Missing(_)) | Self::Measurement(raypath_ppa::Error::Tool(ToolError::Missing(_)))
        )
    }
}
