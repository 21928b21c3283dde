use crate::progress::Stopped;
use raypath_sim::InputError;
use raypath_sim::files::FileError;
use raypath_tools::ToolError;
use std::fmt::Display;
use std::io::ErrorKind;
use thiserror::Error;

/// Why a command did not succeed.
#[derive(Debug, Error)]
pub enum CliError {
    /// Results are wrong, or differ from each other.
    #[error("{0}")]
    Mismatch(String),
    /// Input or output cannot be used.
    #[error("{0}")]
    Unusable(String),
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A tool is missing, fails, or reports something about the emitted text.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// Area or timing cannot be measured.
    #[cfg(feature = "workbench")]
    #[error(transparent)]
    Measurement(#[from] raypath_ppa::Error),
    /// Standard output cannot be written.
    #[error("standard output: {0}")]
    Output(#[from] std::io::Error),
    /// The user stopped the command; with its progress.
    #[error("stopped {0}")]
    Stopped(String),
}

impl CliError {
    /// Input or output cannot be used, for this reason.
    pub fn unusable(problem: impl Display) -> Self {
        Self::Unusable(problem.to_string())
    }

    /// Whether the reader of standard output has closed it, as `head` does. Then there is nothing to report.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == ErrorKind::BrokenPipe)
    }

    /// 1 for a mismatch, 2 for input that cannot be used, 130 after Ctrl-C, 141 if the reader has closed standard
    /// output (the codes of shells).
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Output(_) if self.is_silent() => 141,
            Self::Mismatch(_) => 1,
            Self::Stopped(_) => 130,
            _ => 2,
        }
    }

    /// Whether the error is a tool that is not installed; other steps can continue without it.
    pub fn is_missing_tool(&self) -> bool {
        match self {
            Self::Tool(ToolError::Missing(_)) => true,
            #[cfg(feature = "workbench")]
            Self::Measurement(raypath_ppa::Error::Tool(ToolError::Missing(_))) => true,
            _ => false,
        }
    }
}

impl From<Stopped> for CliError {
    fn from(stopped: Stopped) -> Self {
        Self::Stopped(stopped.to_string())
    }
}

/// Errors whose message already names the file, the line and what was expected.
macro_rules! unusable {
    ($($error:ty),* $(,)?) => {$(
        impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                Self::unusable(error)
            }
        }
    )*};
}

unusable!(InputError, FileError, raypath_hdl::Error, raypath_traversal::UnitError);

#[cfg(feature = "full")]
unusable!(
    raypath_embed::Error,
    raypath_hdl::wave::WaveError,
    raypath_search::SearchError,
    raypath_timing::SimulationError
);

/// Errors of rays: those that the traversal unit ends with an error are a wrong result, the others name what is
/// unusable.
#[cfg(feature = "full")]
macro_rules! of_rays {
    ($($error:ident),*) => {$(
        impl From<raypath_render::$error> for CliError {
            fn from(error: raypath_render::$error) -> Self {
                match error {
                    raypath_render::$error::Unit(errors) => Self::Mismatch(errors.to_string()),
                    other => Self::unusable(other),
                }
            }
        }
    )*};
}

#[cfg(feature = "full")]
of_rays!(TraceError, RenderError, PictureError);
