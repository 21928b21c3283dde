use raypath::transactions::TransactionError;
use std::path::Path;
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
    /// The user stopped it.
    #[error("stopped {0}")]
    Interrupted(String),
}

impl Failure {
    /// The operating system refused something about a file.
    pub fn file(path: &Path, doing: &str, problem: impl std::fmt::Display) -> Self {
        Self::Unusable(format!("{}: cannot {doing}: {problem}", path.display()))
    }

    /// 1 for a mismatch, 2 for what cannot be used, 130 after Ctrl-C.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Mismatch(_) => ExitCode::from(1),
            Self::Unusable(_) | Self::Elaboration(_) => ExitCode::from(2),
            Self::Interrupted(_) => ExitCode::from(130),
        }
    }
}

impl From<TransactionError> for Failure {
    fn from(error: TransactionError) -> Self {
        Self::Unusable(error.to_string())
    }
}

impl From<raypath::hdl::Error> for Failure {
    fn from(error: raypath::hdl::Error) -> Self {
        Self::Unusable(error.to_string())
    }
}
