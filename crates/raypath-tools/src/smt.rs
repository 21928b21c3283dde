//! Z3 and Bitwuzla, which decide questions in SMT-LIB 2.

use crate::program::{Ended, Run, python};
use crate::{Program, ToolError, read, write};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// An installed solver.
#[derive(Debug, Clone)]
pub struct SmtSolver {
    /// Its name and version.
    pub version: String,
    program: &'static Program,
    /// The Python program that prints the answers of each script.
    python: &'static str,
}

// Debian's version 4.8 expands definitions again and again.
static Z3: Program = Program {
    name: "z3",
    expected: "Python's module z3 5.4 or newer",
    install: "python3 -m pip install z3-solver",
    version: &["python3", "-c", "import z3; print('Z3', z3.get_version_string())"],
};

const PYTHON_Z3: &str = "import sys, z3\n\
                         for name in sys.argv[1:]:\n    \
                         context = z3.Context()\n    \
                         text = open(name).read()\n    \
                         print(z3.Z3_eval_smtlib2_string(context.ref(), text), end='', flush=True)\n";

static BITWUZLA: Program = Program {
    name: "bitwuzla",
    expected: "Python's module bitwuzla 0.9 or newer",
    install: "python3 -m pip install bitwuzla",
    version: &[
        "python3",
        "-c",
        "from importlib.metadata import version; import bitwuzla; print('Bitwuzla', version('bitwuzla'))",
    ],
};

const PYTHON_BITWUZLA: &str = "import sys, bitwuzla\n\
                               for name in sys.argv[1:]:\n    \
                               options = bitwuzla.Options()\n    \
                               options.set(bitwuzla.Option.PRODUCE_MODELS, True)\n    \
                               bitwuzla.Parser(bitwuzla.TermManager(), options).parse(name)\n";

impl SmtSolver {
    /// Finds Python's module `z3`.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn z3() -> Result<Self, ToolError> {
        Ok(Self { version: Z3.version()?, program: &Z3, python: PYTHON_Z3 })
    }

    /// Finds Python's module `bitwuzla`.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn bitwuzla() -> Result<Self, ToolError> {
        Ok(Self { version: BITWUZLA.version()?, program: &BITWUZLA, python: PYTHON_BITWUZLA })
    }

    /// Runs scripts in a folder, each by itself. Returns all that the solver printed, or none if it was stopped or did
    /// not end within the limit.
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
        let run = Run { folder, log: "solver.log", limit: Some(limit), stop };
        let ended = run.run(self.program, python().args(["-c", self.python]).args(&names))?;
        let output = String::from_utf8_lossy(&read(&folder.join(run.log))?).into_owned();
        match ended {
            Ended::Success => Ok(Some(output)),
            Ended::Failure(_) => Err(self.program.failed(output)),
            Ended::Cut => Ok(None),
        }
    }
}
