use raypath::configuration::ConfigurationError;
use raypath::transactions::TransactionError;
use std::fmt::Display;
use std::io::ErrorKind;
use std::process::ExitCode;
use thiserror::Error;

/// Why a command did not succeed.
#[derive(Debug, Error)]
pub enum Failure {
    /// The command worked, and found that results differ.
    #[error("{0}")]
    Mismatch(String),
    /// Input or output that cannot be used.
    #[error("{0}")]
    Unusable(String),
    /// The datapath could not be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath::rtl::Error),
    /// What the command says cannot be written.
    #[error("standard output: {0}")]
    Output(#[from] std::io::Error),
    /// The user stopped it.
    #[error("stopped {0}")]
    Interrupted(String),
}

impl Failure {
    /// Input or output cannot be used, for this reason.
    pub fn unusable(problem: impl Display) -> Self {
        Self::Unusable(problem.to_string())
    }

    /// Whether the reader of standard output has gone, as `head` does: no fault, and nothing to say.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// 1 for a mismatch, 2 for what cannot be used, 130 after Ctrl-C, 141 where the reader has gone (as shells have it).
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Output(_) if self.is_silent() => ExitCode::from(141),
            Self::Mismatch(_) => ExitCode::from(1),
            Self::Unusable(_) | Self::Elaboration(_) | Self::Output(_) => ExitCode::from(2),
            Self::Interrupted(_) => ExitCode::from(130),
        }
    }
}

impl From<TransactionError> for Failure {
    fn from(error: TransactionError) -> Self {
        Self::unusable(error)
    }
}

impl From<ConfigurationError> for Failure {
    fn from(error: ConfigurationError) -> Self {
        Self::unusable(error)
    }
}

impl From<raypath::hdl::Error> for Failure {
    fn from(error: raypath::hdl::Error) -> Self {
        Self::unusable(error)
    }
}

impl From<raypath::traffic::RecordedError> for Failure {
    fn from(error: raypath::traffic::RecordedError) -> Self {
        Self::unusable(error)
    }
}
