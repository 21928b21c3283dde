//! ABC, which proves properties of and-inverter graphs.

use crate::program::{Ended, Run, first_line};
use crate::{Program, ToolError, digest, read};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// An installed ABC.
#[derive(Debug, Clone)]
pub struct Abc {
    program: PathBuf,
    /// Its name and version, with the first digits of its file's SHA-256 digest: all builds have the same version.
    pub version: String,
}

static ABC: Program = Program {
    name: "yosys-abc",
    expected: "ABC as pyosys 0.70 or newer has it",
    install: "python3 -m pip install pyosys",
    version: &["yosys-abc", "-q", "version"],
};

const ABC_IN_PYOSYS: &str = "import pyosys, os; print(os.path.join(os.path.dirname(pyosys.__file__), 'yosys-abc'))";

/// The first digits of the digest of a program, which is found as a shell does. It is read once.
fn digest_of(program: &Path) -> Result<String, ToolError> {
    static KNOWN: Mutex<BTreeMap<PathBuf, String>> = Mutex::new(BTreeMap::new());
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let mut paths = std::env::split_paths(&folders).map(|folder| folder.join(program));
    let path = paths.find(|path| path.is_file()).ok_or(ToolError::Missing(&ABC))?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if !known.contains_key(&path) {
        let digest = digest(&read(&path)?);
        known.insert(path.clone(), digest[..12].to_string());
    }
    Ok(known[&path].clone())
}

impl Abc {
    /// Finds the ABC that comes with pyosys, or else Debian's.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: neither is installed.
    pub fn find() -> Result<Self, ToolError> {
        let in_pyosys = first_line(Command::new("python3").args(["-c", ABC_IN_PYOSYS])).map(PathBuf::from);
        let mut programs = in_pyosys.into_iter().chain(["yosys-abc", "berkeley-abc"].map(PathBuf::from));
        let found =
            programs.find_map(|program| Some((first_line(Command::new(&program).args(["-q", "version"]))?, program)));
        let (version, program) = found.ok_or(ToolError::Missing(&ABC))?;
        let version = format!("{version} (sha256 {})", digest_of(&program)?);
        Ok(Self { program, version })
    }

    /// Runs commands in a folder. Returns what ABC printed, or that it failed and its last line; None if it was stopped
    /// or did not end within the limit.
    ///
    /// # Errors
    /// It cannot be started, or its output cannot be read.
    pub fn run(
        &self,
        folder: &Path,
        commands: &str,
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Option<String>, ToolError> {
        let run = Run { folder, log: "abc.log", limit: Some(limit), stop };
        let ended = run.run(&ABC, Command::new(&self.program).args(["-q", commands]))?;
        let output = String::from_utf8_lossy(&read(&folder.join(run.log))?).into_owned();
        Ok(match ended {
            Ended::Success => Some(output),
            // Results that were printed before a failure do not count.
            Ended::Failure(status) => Some(format!("abc ended with {status}: {}", Self::last_line(&output))),
            Ended::Cut => None,
        })
    }

    /// The last line that ABC printed, for messages.
    pub fn last_line(output: &str) -> String {
        let line = output.lines().rev().find(|line| !line.trim().is_empty());
        format!("abc said '{}'", line.unwrap_or_default())
    }
}
