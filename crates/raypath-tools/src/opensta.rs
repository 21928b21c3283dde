//! OpenSTA, which finds the slowest paths.

use crate::program::Run;
use crate::{Program, ToolError};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

/// An installed OpenSTA.
#[derive(Debug, Clone)]
pub struct OpenSta {
    /// Its name and version.
    pub version: String,
}

static STA: Program = Program {
    name: "sta",
    expected: "OpenSTA 2.0 or newer",
    install: "apt-get install opensta",
    version: &["sta", "-version"],
};

impl OpenSta {
    /// Finds the program `sta`.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn find() -> Result<Self, ToolError> {
        Ok(Self { version: format!("OpenSTA {}", STA.version()?) })
    }

    /// Runs the commands of the file `script` in `folder`. The output goes to the file `log` there. `about` names in
    /// messages what OpenSTA works on.
    ///
    /// # Errors
    /// It failed, or `stop` was set meanwhile ([`ToolError::Stopped`]).
    pub fn run(&self, folder: &Path, script: &str, log: &str, about: &str, stop: &AtomicBool) -> Result<(), ToolError> {
        let run = Run { folder, log, limit: None, stop };
        run.succeed(&STA, Command::new("sta").args(["-no_splash", "-exit", script]), &self.version, about)
    }
}
