//! ABC: found, run within a time, and its verdict read.

use super::aiger::Aiger;
use super::{Answer, file};
use crate::Error;
use std::fmt;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// ABC, found.
#[derive(Debug, Clone)]
pub struct Abc {
    program: PathBuf,
    version: String,
}

const BESIDE_PYOSYS: &str = "import pyosys, os; print(os.path.join(os.path.dirname(pyosys.__file__), 'yosys-abc'))";
const BETWEEN_LOOKS: Duration = Duration::from_millis(5);

impl Abc {
    /// Finds the one that comes with pyosys, or else Debian's.
    pub fn find() -> Result<Self, Error> {
        let beside = said(Command::new("python3").args(["-c", BESIDE_PYOSYS])).map(PathBuf::from);
        let known = ["yosys-abc", "berkeley-abc"].map(PathBuf::from);
        let mut programs = beside.into_iter().chain(known);
        let found = programs.find_map(|program| {
            let version = said(Command::new(&program).args(["-q", "version"]))?;
            Some(Self { program, version: version.split(" (").next().unwrap_or_default().to_string() })
        });
        found.ok_or_else(|| Error::Program {
            program: "yosys-abc".to_string(),
            problem: "not found".to_string(),
            expected: "it after: python3 -m pip install pyosys".to_string(),
        })
    }

    /// Solves a graph in a folder.
    pub fn solve(&self, folder: &Path, graph: &Aiger, limit: Duration, stop: &AtomicBool) -> Result<Answer, Error> {
        let (log, example) = (folder.join("abc.log"), folder.join("example"));
        let _ = fs::remove_file(&example);
        let output = File::create(&log).map_err(|error| file(&log, error))?;
        // A limit on conflicts that nothing reaches: time decides.
        let commands = format!("read_aiger {}; &get; &cec -m -C 1000000000; write_cex example", graph.file);
        let mut command = Command::new(&self.program);
        command.args(["-q", &commands]).current_dir(folder).env("TMPDIR", folder);
        command.stdin(Stdio::null()).stdout(output).stderr(Stdio::null());
        own_group(&mut command);
        let mut child = command.spawn().map_err(|error| file(&self.program, error))?;
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().map_err(|error| file(&self.program, error))? {
                break status;
            }
            let is_stopped = stop.load(Ordering::Relaxed);
            if is_stopped || begin.elapsed() > limit {
                // Errors mean that it has ended already.
                let _ = child.kill();
                let _ = child.wait();
                let timeout = || Answer::Undecided(format!("no answer within {} s", limit.as_secs()));
                return Ok(if is_stopped { Answer::Stopped } else { timeout() });
            }
            std::thread::sleep(BETWEEN_LOOKS);
        };
        let said = fs::read(&log).map_err(|error| file(&log, error))?;
        let said = String::from_utf8_lossy(&said);
        if !status.success() {
            return Ok(Answer::Undecided(format!("abc ended with {status}: {}", last_line(&said))));
        }
        let counterexample = || fs::read_to_string(&example).ok().and_then(|word| graph.ports(word.trim()));
        match verdict(&said) {
            Some(true) => Ok(Answer::Proved { gates: graph.gates }),
            Some(false) => counterexample().map(Answer::Refuted).ok_or_else(|| Error::Program {
                program: self.program.display().to_string(),
                problem: format!("{}: refuted without a counterexample", graph.problem),
                expected: "a value for each input".to_string(),
            }),
            None => Ok(Answer::Undecided(last_line(&said))),
        }
    }
}

/// Whether ABC says that it is proved, or refuted: one line, and nothing to the contrary.
fn verdict(said: &str) -> Option<bool> {
    let proved = said.lines().filter(|line| line.starts_with("Networks are equivalent")).count();
    let refuted = said.lines().filter(|line| line.starts_with("Networks are NOT EQUIVALENT")).count();
    match (proved, refuted, said.contains("UNDECIDED")) {
        (1, 0, false) => Some(true),
        (0, 1, false) => Some(false),
        _ => None,
    }
}

fn last_line(said: &str) -> String {
    let line = said.lines().rev().find(|line| !line.trim().is_empty());
    format!("abc said '{}'", line.unwrap_or_default())
}

fn said(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_string)
}

impl fmt::Display for Abc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.version)
    }
}

/// The terminal's Ctrl-C is ours to answer.
#[cfg(unix)]
fn own_group(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    command.process_group(0);
}

#[cfg(not(unix))]
fn own_group(_: &mut Command) {}

#[cfg(test)]
mod tests {
    use super::verdict;

    #[test]
    fn only_abcs_own_words_are_a_verdict() {
        assert_eq!(verdict("Assuming ...\nNetworks are equivalent.  Time =     0.01 sec\n"), Some(true));
        assert_eq!(verdict("Networks are NOT EQUIVALENT.  Time =     0.01 sec\n"), Some(false));
        let both = "Networks are equivalent.\nNetworks are NOT EQUIVALENT.\n";
        let unclear = ["", "Networks are UNDECIDED.", "** cmd error: unknown command '&cec'", "equivalent", both];
        assert!(unclear.iter().all(|said| verdict(said).is_none()));
    }
}
