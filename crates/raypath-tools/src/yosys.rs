//! Yosys, which synthesises: as a program, or as a Python module.

use crate::program::{Run, python};
use crate::{Program, ToolError};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

/// How Yosys is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YosysKind {
    /// The program `yosys`.
    Program,
    /// The Python module `pyosys`.
    Python,
}

/// An installed Yosys.
#[derive(Debug, Clone)]
pub struct Yosys {
    kind: YosysKind,
    /// Its name and version.
    pub version: String,
}

/// The program `yosys`.
pub(crate) static YOSYS: Program = Program {
    name: "yosys",
    expected: "Yosys 0.23 or newer",
    install: "apt-get install yosys, or python3 -m pip install pyosys",
    version: &["yosys", "-V"],
};

static PYOSYS: Program = Program {
    name: "pyosys",
    expected: "Python's module pyosys 0.70 or newer",
    install: "python3 -m pip install pyosys",
    version: &["python3", "-c", "import pyosys, importlib.metadata as m; print('pyosys', m.version('pyosys'))"],
};

/// Runs a script line by line, as `yosys -s` does.
const PYTHON: &str = "import sys\n\
                      from pyosys import libyosys\n\
                      design = libyosys.Design()\n\
                      for line in open(sys.argv[1]):\n    libyosys.run_pass(line.strip(), design)\n";

impl Yosys {
    /// The file in a run's folder that Yosys's output goes to.
    pub const LOG: &str = "yosys.log";

    /// Finds Yosys of this kind. Without a kind it is `pyosys`, which is newer than Debian's program, or else the
    /// program.
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn find(kind: Option<YosysKind>) -> Result<Self, ToolError> {
        let program = || Ok(Self { kind: YosysKind::Program, version: YOSYS.version()? });
        let python = || Ok(Self { kind: YosysKind::Python, version: PYOSYS.version()? });
        match kind {
            Some(YosysKind::Program) => program(),
            Some(YosysKind::Python) => python(),
            None => python().or_else(|_: ToolError| program()),
        }
    }

    /// Runs the commands of the file `script` in `folder`, a line each. The output goes to [`Self::LOG`]. `about` names
    /// in messages what Yosys works on.
    ///
    /// # Errors
    /// It failed, or `stop` was set meanwhile ([`ToolError::Stopped`]).
    pub fn run(&self, folder: &Path, script: &str, about: &str, stop: &AtomicBool) -> Result<(), ToolError> {
        let (program, mut command, options) = match self.kind {
            YosysKind::Program => (&YOSYS, Command::new("yosys"), ["-q", "-s"]),
            YosysKind::Python => (&PYOSYS, python(), ["-c", PYTHON]),
        };
        let run = Run { folder, log: Self::LOG, limit: None, stop };
        run.succeed(program, command.args(options).arg(script), &self.version, about)
    }
}
