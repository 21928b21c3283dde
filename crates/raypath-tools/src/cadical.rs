//! CaDiCaL, which decides whether clauses can hold, and writes a certificate if they cannot.

use crate::program::{Ended, Run};
use crate::{Program, ToolError, read};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// An installed CaDiCaL.
#[derive(Debug, Clone)]
pub struct Cadical {
    /// Its name and version.
    pub version: String,
}

static CADICAL: Program = Program {
    name: "cadical",
    expected: "CaDiCaL 1.5 or newer",
    install: "apt-get install cadical",
    version: &["cadical", "--version"],
};

impl Cadical {
    /// Finds the program `cadical`.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn find() -> Result<Self, ToolError> {
        Ok(Self { version: format!("CaDiCaL {}", CADICAL.version()?) })
    }

    /// Decides whether the clauses of a DIMACS file in a folder can hold. If not, the file `certificate` has the proof,
    /// in the binary form of DRAT. None if it was stopped or did not end within the limit.
    ///
    /// # Errors
    /// It cannot be started, or refuses the file.
    pub fn can_hold(
        &self,
        folder: &Path,
        clauses: &str,
        certificate: &str,
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Option<bool>, ToolError> {
        let run = Run { folder, log: "cadical.log", limit: Some(limit), stop };
        match run.run(&CADICAL, Command::new(CADICAL.name).args(["-q", "--binary=1", clauses, certificate]))? {
            Ended::Failure(status) if status.code() == Some(10) => Ok(Some(true)),
            Ended::Failure(status) if status.code() == Some(20) => Ok(Some(false)),
            Ended::Success | Ended::Failure(_) => {
                let output = read(&folder.join(run.log))?;
                Err(CADICAL.failed(String::from_utf8_lossy(&output).into_owned()))
            }
            Ended::Cut => Ok(None),
        }
    }
}
