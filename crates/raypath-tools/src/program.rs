//! What all external programs share: their description, and running one with a log, a time limit and a way to stop it.

use crate::ToolError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An external program, as messages describe it.
#[derive(Debug, PartialEq, Eq)]
pub struct Program {
    /// The command, or the Python module.
    pub name: &'static str,
    /// The version that is expected, in words.
    pub expected: &'static str,
    /// The command that installs it on Debian.
    pub install: &'static str,
    /// The command and arguments that print its version.
    pub version: &'static [&'static str],
}

impl Program {
    /// The version that the installed program prints, without what follows in parentheses: "Yosys 0.23".
    ///
    /// # Errors
    /// [`ToolError::Missing`]: it is not installed.
    pub fn version(&'static self) -> Result<String, ToolError> {
        let [command, arguments @ ..] = self.version else { return Err(ToolError::Missing(self)) };
        first_line(Command::new(command).args(arguments)).ok_or(ToolError::Missing(self))
    }

    /// Runs a command of this program to its end. Returns all that it printed.
    pub(crate) fn output(&'static self, command: &mut Command) -> Result<String, ToolError> {
        let result = command.output().map_err(|problem| self.not_started(problem))?;
        let output = [result.stdout, result.stderr].concat();
        let output = String::from_utf8_lossy(&output).into_owned();
        if result.status.success() { Ok(output) } else { Err(self.failed(output)) }
    }

    /// A failure of this program, with its version.
    pub(crate) fn failed(&'static self, output: String) -> ToolError {
        ToolError::Failed { program: self.version().unwrap_or_else(|_| self.name.to_string()), about: None, output }
    }

    fn not_started(&'static self, problem: std::io::Error) -> ToolError {
        match problem.kind() {
            ErrorKind::NotFound => ToolError::Missing(self),
            _ => ToolError::file(Path::new(self.name), "run", problem),
        }
    }
}

/// The first line of what a command prints, up to a parenthesis. None if it cannot be started or fails.
///
/// A command that succeeded does not run again: installed programs stay as they are, and some are asked for a hundred
/// times.
pub(crate) fn first_line(command: &mut Command) -> Option<String> {
    static KNOWN: Mutex<BTreeMap<String, String>> = Mutex::new(BTreeMap::new());
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let name = format!("{command:?}");
    if let Some(line) = known().get(&name) {
        return Some(line.clone());
    }
    let output = command.stdin(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    let line = String::from_utf8_lossy(&output.stdout).lines().next()?.to_string();
    let line = line.split(" (").next().unwrap_or_default().to_string();
    known().insert(name, line.clone());
    Some(line)
}

/// Python's interpreter. `python3` may be a script of a version manager that takes longer than the interpreter itself.
pub(crate) fn python() -> Command {
    let path = first_line(Command::new("python3").args(["-c", "import sys; print(sys.executable)"]));
    Command::new(path.as_deref().unwrap_or("python3"))
}

/// How a program runs.
pub(crate) struct Run<'a> {
    /// Its working folder, and its folder for temporary files.
    pub folder: &'a Path,
    /// The file in `folder` that all output goes to.
    pub log: &'a str,
    /// The longest time that it may take.
    pub limit: Option<Duration>,
    /// Ends the program when set.
    pub stop: &'a AtomicBool,
}

/// How a program ended.
#[derive(Debug)]
pub(crate) enum Ended {
    Success,
    Failure(#[cfg_attr(not(feature = "cache"), allow(dead_code))] ExitStatus),
    /// It was stopped, or did not end within the limit.
    Cut,
}

const POLL_INTERVAL: Duration = Duration::from_millis(5);

impl Run<'_> {
    /// Runs a command to its end, to the time limit, or until it is stopped.
    pub fn run(&self, program: &'static Program, command: &mut Command) -> Result<Ended, ToolError> {
        let path = self.folder.join(self.log);
        let refused = |problem| ToolError::file(&path, "write", problem);
        let file = File::create(&path).map_err(refused)?;
        let errors = file.try_clone().map_err(refused)?;
        command.current_dir(self.folder).stdin(Stdio::null()).stdout(file).stderr(errors);
        // Yosys caches libraries in the folder for temporary files, under names that different libraries may share.
        command.env("TMPDIR", self.folder);
        own_group(command);
        let mut child = command.spawn().map_err(|problem| program.not_started(problem))?;
        let begin = Instant::now();
        loop {
            if self.stop.load(Ordering::Relaxed) || self.limit.is_some_and(|limit| begin.elapsed() > limit) {
                end(&mut child);
                return Ok(Ended::Cut);
            }
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(Ended::Success),
                Ok(Some(status)) => return Ok(Ended::Failure(status)),
                Ok(None) => std::thread::sleep(POLL_INTERVAL),
                Err(problem) => return Err(ToolError::file(Path::new(program.name), "wait for", problem)),
            }
        }
    }

    /// The same for a run without a time limit that must succeed. `version` and `about` name the program and what it
    /// works on in messages.
    pub fn succeed(
        &self,
        program: &'static Program,
        command: &mut Command,
        version: &str,
        about: &str,
    ) -> Result<(), ToolError> {
        match self.run(program, command)? {
            Ended::Success => Ok(()),
            Ended::Cut => Err(ToolError::Stopped),
            Ended::Failure(_) => {
                let output = last_lines(&self.folder.join(self.log)).unwrap_or_default();
                Err(ToolError::Failed { program: version.to_string(), about: Some(about.to_string()), output })
            }
        }
    }
}

/// The last 20 lines of a log, of at most 16 KiB.
fn last_lines(path: &Path) -> std::io::Result<String> {
    const MAX_BYTES: u64 = 16 << 10;
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(MAX_BYTES)))?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES).read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.lines().collect();
    Ok(lines[lines.len().saturating_sub(20)..].join("\n"))
}

/// Puts the program into a process group of its own, so that its children end with it, and a Ctrl-C at the terminal
/// reaches this program only.
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
        // The standard library cannot signal a group; `kill` takes its negative number.
        let group = format!("kill -s KILL -- -{}", child.id());
        let _ = Command::new("sh").args(["-c", &group]).stderr(Stdio::null()).status();
    }
    // An error means that it has ended already.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;

    static SHELL: Program = Program { name: "sh", expected: "a shell", install: "apt-get install dash", version: &[] };

    #[test]
    fn a_stopped_program_ends_with_its_children() {
        let folder = tempfile::tempdir().expect("a folder");
        let stop = AtomicBool::new(false);
        let mut command = Command::new("sh");
        command.args(["-c", "sleep 600 & echo $! > child; wait"]);
        let child = folder.path().join("child");
        let run = Run { folder: folder.path(), log: "log", limit: None, stop: &stop };
        let result = std::thread::scope(|scope| {
            let running = scope.spawn(|| run.succeed(&SHELL, &mut command, "sh", "nothing"));
            while !fs::read_to_string(&child).is_ok_and(|number| number.ends_with('\n')) {
                std::thread::sleep(POLL_INTERVAL);
            }
            stop.store(true, Ordering::Relaxed);
            running.join().expect("no panic")
        });
        assert!(matches!(result, Err(ToolError::Stopped)), "{result:?}");
        let number = fs::read_to_string(&child).expect("a number");
        // The process is gone, or a zombie until its new parent reaps it.
        let gone = || {
            let status = fs::read_to_string(format!("/proc/{}/stat", number.trim()));
            status.map_or(true, |status| status.contains(") Z "))
        };
        while !gone() {
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Programs that are missing are looked for again.
    #[test]
    fn what_a_program_printed_is_known() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = Command::new("sh");
        let count = folder.path().join("count");
        command.args(["-c", &format!("echo x >> {0} && wc -l < {0} && test -e {0}.ready", count.display())]);
        assert_eq!(first_line(&mut command), None);
        fs::write(count.with_extension("ready"), "").expect("a file");
        for _ in 0..2 {
            assert_eq!(first_line(&mut command).as_deref(), Some("2"));
        }
    }

    #[test]
    fn a_failure_shows_the_output() {
        let folder = tempfile::tempdir().expect("a folder");
        let (never, limit) = (AtomicBool::new(false), Duration::from_millis(50));
        let run = |limit| Run { folder: folder.path(), log: "log", limit, stop: &never };
        let mut command = Command::new("sh");
        command.args(["-c", "echo 'ERROR: no such cell' >&2; exit 3"]);
        let result = run(None).succeed(&SHELL, &mut command, "sh 1.2", "raypath_skid");
        let message = result.expect_err("a failure").to_string();
        assert_eq!(message, "sh 1.2 failed on raypath_skid:\nERROR: no such cell");
        let result = run(None).run(&SHELL, &mut Command::new("no-such-program"));
        assert!(matches!(result, Err(ToolError::Missing(_))), "{result:?}");
        let result = run(Some(limit)).run(&SHELL, Command::new("sleep").arg("600"));
        assert!(matches!(result, Ok(Ended::Cut)), "{result:?}");
    }
}
