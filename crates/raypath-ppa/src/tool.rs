//! The programs that do the work: found, asked for their versions, run, and stopped.

use crate::Error;
use std::fmt;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How Yosys is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YosysKind {
    /// The program `yosys`.
    Program,
    /// The Python module `pyosys`.
    Python,
}

/// Yosys, found.
#[derive(Debug, Clone)]
pub struct Yosys {
    kind: YosysKind,
    version: String,
}

/// OpenSTA, found.
#[derive(Debug, Clone)]
pub struct OpenSta {
    version: String,
}

const INSTALL_YOSYS: &str = "apt-get install yosys, or python3 -m pip install pyosys";
const INSTALL_PYOSYS: &str = "python3 -m pip install pyosys";
const INSTALL_STA: &str = "apt-get install opensta";

/// Runs a script line by line, as `yosys -s` does.
const PYTHON: &str = "import sys\n\
                      from pyosys import libyosys\n\
                      design = libyosys.Design()\n\
                      for line in open(sys.argv[1]):\n    libyosys.run_pass(line.strip(), design)\n";
const PYTHON_VERSION: &str = "import pyosys, importlib.metadata as m; print('pyosys', m.version('pyosys'))";

impl Yosys {
    /// Finds Yosys: of the kind asked for, otherwise `pyosys`, which is newer wherever both are installed on Debian, or
    /// else the program.
    ///
    /// # Errors
    /// It is not there.
    pub fn find(kind: Option<YosysKind>) -> Result<Self, Error> {
        match kind {
            Some(YosysKind::Program) => Self::program(),
            Some(YosysKind::Python) => Self::python().ok_or_else(|| missing("pyosys", INSTALL_PYOSYS)),
            None => Self::python().map_or_else(Self::program, Ok),
        }
    }

    fn program() -> Result<Self, Error> {
        let said = first_line(Command::new("yosys").arg("-V"));
        // "Yosys 0.23 (git sha1 ...)"
        let version = said.map(|line| line.split(" (").next().unwrap_or_default().to_string());
        version.map(|version| Self { kind: YosysKind::Program, version }).ok_or_else(|| missing("yosys", INSTALL_YOSYS))
    }

    fn python() -> Option<Self> {
        let version = first_line(Command::new("python3").args(["-c", PYTHON_VERSION]))?;
        Some(Self { kind: YosysKind::Python, version })
    }

    /// Runs the commands of a file in a folder, a line each; what it prints goes to `yosys.log` there. `about` is what a
    /// message says that it worked on.
    ///
    /// # Errors
    /// It failed, or `stop` was set meanwhile ([`Error::Stopped`]).
    pub fn run(&self, folder: &Path, script: &str, about: &str, stop: &AtomicBool) -> Result<(), Error> {
        let mut command = match self.kind {
            YosysKind::Program => Command::new("yosys"),
            YosysKind::Python => Command::new("python3"),
        };
        match self.kind {
            YosysKind::Program => command.args(["-q", "-s", script]),
            YosysKind::Python => command.args(["-c", PYTHON, script]),
        };
        run(&mut command, folder, "yosys.log", about, stop)
    }
}

impl OpenSta {
    /// Finds the program `sta`.
    ///
    /// # Errors
    /// It is not there.
    pub fn find() -> Result<Self, Error> {
        let version = first_line(Command::new("sta").arg("-version")).ok_or_else(|| missing("sta", INSTALL_STA))?;
        Ok(Self { version: format!("OpenSTA {version}") })
    }

    /// Runs the commands of a file in a folder; what it prints goes to a file there.
    pub(crate) fn run(
        &self,
        folder: &Path,
        script: &str,
        log: &str,
        about: &str,
        stop: &AtomicBool,
    ) -> Result<(), Error> {
        run(Command::new("sta").args(["-no_splash", "-exit", script]), folder, log, about, stop)
    }
}

impl fmt::Display for Yosys {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.version)
    }
}

impl fmt::Display for OpenSta {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.version)
    }
}

fn missing(program: &str, install: &'static str) -> Error {
    Error::MissingTool { program: program.to_string(), install }
}

fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_string)
}

const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// Runs a command to its end, or ends it when asked to stop. What it prints goes to a file in its folder.
fn run(command: &mut Command, folder: &Path, log: &str, about: &str, stop: &AtomicBool) -> Result<(), Error> {
    let program = command.get_program().to_string_lossy().into_owned();
    let path = folder.join(log);
    let file = File::create(&path).map_err(|problem| Error::file(&path, "write", problem))?;
    let errors = file.try_clone().map_err(|problem| Error::file(&path, "write", problem))?;
    command.current_dir(folder).stdin(Stdio::null()).stdout(file).stderr(errors);
    // Yosys keeps libraries in a folder for temporary files, under names that different ones may share.
    command.env("TMPDIR", folder);
    own_group(command);
    let mut child = command.spawn().map_err(|problem| match problem.kind() {
        ErrorKind::NotFound => missing(&program, if program == "sta" { INSTALL_STA } else { INSTALL_YOSYS }),
        _ => Error::file(Path::new(&program), "run", problem),
    })?;
    let status = loop {
        if stop.load(Ordering::Relaxed) {
            end(&mut child);
            return Err(Error::Stopped);
        }
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => std::thread::sleep(BETWEEN_LOOKS),
            Err(problem) => return Err(Error::file(Path::new(&program), "wait for", problem)),
        }
    };
    if status.success() {
        return Ok(());
    }
    let output = last_lines(&path).unwrap_or_default();
    Err(Error::Tool { program, about: Some(about.to_string()), output })
}

/// The end of what a program printed: 20 lines, but no more than a message has room for.
fn last_lines(path: &Path) -> std::io::Result<String> {
    const MOST_BYTES: u64 = 16 << 10;
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(MOST_BYTES)))?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes)?;
    let said = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = said.lines().collect();
    Ok(lines[lines.len().saturating_sub(20)..].join("\n"))
}

/// Yosys has children of its own, which must end with it; and the terminal's Ctrl-C is ours to answer.
#[cfg(unix)]
fn own_group(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    command.process_group(0);
}

#[cfg(not(unix))]
fn own_group(_: &mut Command) {}

/// Ends a program and its children.
fn end(child: &mut Child) {
    if cfg!(unix) {
        // A group is ended by a minus before its number, which the standard library cannot say.
        let group = format!("kill -s KILL -- -{}", child.id());
        let _ = Command::new("sh").args(["-c", &group]).stderr(Stdio::null()).status();
    }
    // Errors mean that it has ended already.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_program_is_stopped_with_its_children() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let mut command = Command::new("sh");
        command.args(["-c", "sleep 600 & echo $! > child; wait"]);
        let child = folder.path().join("child");
        let result = std::thread::scope(|scope| {
            let running = scope.spawn(|| run(&mut command, folder.path(), "log", "nothing", &stop));
            while !fs::read_to_string(&child).is_ok_and(|number| number.ends_with('\n')) {
                std::thread::sleep(BETWEEN_LOOKS);
            }
            stop.store(true, Ordering::Relaxed);
            running.join().expect("no panic")
        });
        assert!(matches!(result, Err(Error::Stopped)), "{result:?}");
        let number = fs::read_to_string(&child).expect("a number");
        // It is gone, or waits for its new parent to take notice.
        let gone = || {
            let status = fs::read_to_string(format!("/proc/{}/stat", number.trim()));
            status.map_or(true, |status| status.contains(") Z "))
        };
        while !gone() {
            std::thread::sleep(BETWEEN_LOOKS);
        }
    }

    #[test]
    fn a_failure_shows_what_the_program_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = Command::new("sh");
        command.args(["-c", "echo 'ERROR: no such cell' >&2; exit 3"]);
        let result = run(&mut command, folder.path(), "log", "raypath_skid", &AtomicBool::new(false));
        let said = result.expect_err("a failure").to_string();
        assert_eq!(said, "sh failed on raypath_skid:\nERROR: no such cell");
        let result = run(&mut Command::new("no-such-program"), folder.path(), "log", "", &AtomicBool::new(false));
        assert!(matches!(result, Err(Error::MissingTool { .. })), "{result:?}");
    }
}
