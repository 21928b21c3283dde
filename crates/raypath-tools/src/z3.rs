//! Z3, which decides questions in SMT-LIB 2.

use crate::program::{Ended, Run};
use crate::{Program, ToolError, read, write};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// An installed Z3.
#[derive(Debug, Clone)]
pub struct Z3 {
    /// Its name and version.
    pub version: String,
}

// Debian's version 4.8 expands definitions again and again.
static Z3: Program = Program {
    name: "z3",
    expected: "Python's module z3 5.4 or newer",
    install: "python3 -m pip install z3-solver",
    version: &["python3", "-c", "import z3; print('Z3', z3.get_version_string())"],
};

/// Prints the answers of each script.
const PYTHON: &str = "import sys, z3\n\
                      for name in sys.argv[1:]:\n    \
                      context = z3.Context()\n    \
                      text = open(name).read()\n    \
                      print(z3.Z3_eval_smtlib2_string(context.ref(), text), end='', flush=True)\n";

impl Z3 {
    /// Finds Python's module `z3`.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn find() -> Result<Self, ToolError> {
        Ok(Self { version: Z3.version()? })
    }

    /// Runs scripts in a folder, each by itself. Returns all that Z3 printed, or none if it was stopped or did not end
    /// within the limit.
    ///
    /// # Errors
    /// It cannot be started, or it refuses a script.
    pub fn run(
        &self,
        folder: &Path,
        scripts: &[String],
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Option<String>, ToolError> {
        let names: Vec<String> = (0..scripts.len()).map(|number| format!("question_{number}.smt2")).collect();
        for (name, script) in names.iter().zip(scripts) {
            write(&folder.join(name), script)?;
        }
        let run = Run { folder, log: "z3.log", limit: Some(limit), stop };
        let ended = run.run(&Z3, Command::new("python3").args(["-c", PYTHON]).args(&names))?;
        let output = String::from_utf8_lossy(&read(&folder.join(run.log))?).into_owned();
        match ended {
            Ended::Success => Ok(Some(output)),
            Ended::Failure(_) => Err(Z3.failed(output)),
            Ended::Cut => Ok(None),
        }
    }
}
