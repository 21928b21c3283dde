//! Yosys and ABC on a module with assertions: text in, verdict out.

use crate::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A module to be judged, as one SystemVerilog text.
#[derive(Debug, Clone)]
pub struct Problem {
    /// What messages call it.
    pub name: String,
    /// The module.
    pub top: String,
    /// It and all below it.
    pub text: String,
    /// How many assertions reach ABC.
    pub assertions: usize,
    /// How it is judged.
    pub method: Method,
}

/// How far the judgement goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// All reachable states: property-directed reachability (Bradley 2011, Eén et al. 2011), an induction that finds its
    /// own lemmas.
    Unbounded,
    /// So many cycles from the first reset.
    Bounded(u32),
}

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// No assertion fails, as far as the method goes.
    Holds,
    /// One fails.
    Fails,
    /// ABC gave up.
    Undecided,
}

/// The two programs, found.
#[derive(Debug, Clone)]
pub struct Engine {
    abc: PathBuf,
}

/// Seconds for a problem.
const LIMIT: u32 = 120;
const INSTALL: &str = "it after: python3 -m pip install pyosys";
const BESIDE_PYOSYS: &str = "import pyosys, os; print(os.path.join(os.path.dirname(pyosys.__file__), 'yosys-abc'))";
/// Runs commands line by line.
const RUN: &str = "import sys\n\
                   from pyosys import libyosys\n\
                   design = libyosys.Design()\n\
                   for line in open(sys.argv[1]):\n    libyosys.run_pass(line.strip(), design)\n";

/// From text to an and-inverter graph with state. Units are empty modules, and their outputs are free from cycle to
/// cycle; outputs of the module go, so that only what an assertion depends on stays.
const TO_GRAPH: &[&str] = &[
    "proc",
    "flatten",
    "delete t:raypath_fp_*",
    "delete -port o:*",
    "opt_clean",
    "setundef -undriven -anyseq",
    "async2sync",
    "chformal -lower",
    "opt_clean",
    "techmap",
    "opt",
    "dffunmap",
    "opt_clean",
    "aigmap",
    "opt_clean",
];

impl Engine {
    /// Finds the Python module `pyosys` and the ABC that comes with it.
    ///
    /// # Errors
    /// It is not there.
    pub fn find() -> Result<Self, Error> {
        let missing = || Error::Program {
            program: "pyosys".to_string(),
            problem: "not found".to_string(),
            expected: INSTALL.to_string(),
        };
        let output = Command::new("python3").args(["-c", BESIDE_PYOSYS]).output().map_err(|_| missing())?;
        let abc = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
        if output.status.success() && abc.is_file() { Ok(Self { abc }) } else { Err(missing()) }
    }

    /// Judges a problem.
    ///
    /// # Errors
    /// A program fails, or other assertions than expected reach ABC: none at all, or such as hold for no reason.
    pub fn judge(&self, problem: &Problem) -> Result<Answer, Error> {
        let temporary = std::env::temp_dir();
        let folder = tempfile::tempdir().map_err(|error| Error::File { path: temporary, problem: error })?;
        let folder = folder.path();
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|problem| Error::File { path, problem })
        };
        write("problem.sv", &problem.text)?;
        let begin =
            ["read_verilog -sv -formal problem.sv".to_string(), format!("hierarchy -check -top {}", problem.top)];
        let commands = begin.into_iter().chain(TO_GRAPH.iter().map(ToString::to_string));
        let commands: Vec<String> = commands.chain(["write_aiger -zinit -B problem.aig".to_string()]).collect();
        write("script", &(commands.join("\n") + "\n"))?;
        run(folder, Command::new("python3").args(["-c", RUN, "script"]), &problem.name)?;
        self.check(folder, problem)?;
        let method = match problem.method {
            Method::Unbounded => format!("pdr -T {LIMIT}"),
            Method::Bounded(cycles) => format!("bmc3 -F {cycles} -T {LIMIT}"),
        };
        // Constraints become outputs (fold), and all outputs one.
        let commands = format!("read_aiger problem.aig; fold; strash; orpos; {method}; print_status");
        let output = run(folder, Command::new(&self.abc).args(["-q", &commands]), &problem.name)?;
        let said = String::from_utf8_lossy(&output.stdout);
        Ok(answer(&said, problem.method))
    }

    /// The graph has as many assertions as were written, and state and gates on which they depend.
    fn check(&self, folder: &Path, problem: &Problem) -> Result<(), Error> {
        let path = folder.join("problem.aig");
        let bytes = fs::read(&path).map_err(|problem| Error::File { path, problem })?;
        let header = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let header = String::from_utf8_lossy(header).into_owned();
        // "aig", then numbers: variables, inputs, latches, outputs, and-gates, assertions, constraints.
        let numbers: Vec<usize> = header.split(' ').skip(1).map_while(|word| word.parse().ok()).collect();
        match numbers[..] {
            [_, _, latches, _, gates, assertions, ..]
                if latches > 0 && gates > 0 && assertions == problem.assertions =>
            {
                Ok(())
            }
            _ => Err(Error::Program {
                program: "yosys".to_string(),
                problem: format!("{}: made a circuit '{header}'", problem.name),
                expected: format!("one with {} assertions that depend on state", problem.assertions),
            }),
        }
    }
}

/// ABC's verdict is a status, the last one that it prints: 1 proved, 0 refuted, -1 neither.
fn answer(said: &str, method: Method) -> Answer {
    let status = said.lines().rev().find_map(|line| line.trim().strip_prefix("Status = ")?.split_whitespace().next());
    let through = |cycles: u32| said.contains(&format!("No output asserted in {cycles} frames"));
    match (status, method) {
        (Some("1"), _) => Answer::Holds,
        (Some("0"), _) => Answer::Fails,
        (Some("-1"), Method::Bounded(cycles)) if through(cycles) => Answer::Holds,
        _ => Answer::Undecided,
    }
}

fn run(folder: &Path, command: &mut Command, about: &str) -> Result<Output, Error> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.current_dir(folder).env("TMPDIR", folder).output();
    let output = output.map_err(|problem| Error::File { path: PathBuf::from(&program), problem })?;
    if output.status.success() {
        return Ok(output);
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let lines: Vec<&str> = said.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = lines[lines.len().saturating_sub(5)..].join("; ");
    let expected = "it to succeed".to_string();
    Err(Error::Program { program, problem: format!("{about}: {}: {last}", output.status), expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_status_is_a_verdict() {
        let bounded = Method::Bounded(8);
        assert_eq!(answer("Property proved.\nStatus = 1  Frames = -1\n", Method::Unbounded), Answer::Holds);
        assert_eq!(answer("Status = 0  Frames = 3\n", Method::Unbounded), Answer::Fails);
        assert_eq!(answer("Status = 0  Frames = 3\n", bounded), Answer::Fails);
        assert_eq!(answer("No output asserted in 8 frames.\nStatus = -1  Frames = 7\n", bounded), Answer::Holds);
        assert_eq!(answer("No output asserted in 7 frames.\nStatus = -1  Frames = 6\n", bounded), Answer::Undecided);
        assert_eq!(answer("No output asserted in 8 frames.\nStatus = -1\n", Method::Unbounded), Answer::Undecided);
        assert_eq!(answer("** cmd error\n", Method::Unbounded), Answer::Undecided);
    }
}
