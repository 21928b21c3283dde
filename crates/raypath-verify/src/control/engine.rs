//! Yosys and ABC on a module with assertions: text in, verdict out.

use crate::Error;
use raypath_tools::{Abc, ToolError, Yosys, YosysKind};
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// All reachable states: property-directed reachability (Bradley 2011, Eén et al. 2011), an induction that finds its
    /// own lemmas.
    Unbounded,
    /// All reachable states, by induction over some cycles: the assertions hold in the first ones, and follow from
    /// themselves (Sheeran, Singh, Stålmarck 2000).
    Inductive,
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

/// Yosys and ABC, found, and what they have answered.
#[derive(Debug)]
pub struct Engine {
    yosys: Yosys,
    abc: Abc,
    /// Answers by method and graph: equal graphs are judged once.
    answers: Mutex<HashMap<(Method, Vec<u8>), Answer>>,
}

/// Limit for a problem.
const LIMIT: Duration = Duration::from_secs(600);
/// Cycles from the first reset that are looked at before an induction, which goes back at most [`BACK`].
const BASE: u32 = 8;
const BACK: u32 = 3;

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
    /// Finds the Python module `pyosys`, and the ABC that comes with it or Debian's.
    ///
    /// # Errors
    /// One is not there.
    pub fn find() -> Result<Self, Error> {
        let yosys = Yosys::find(Some(YosysKind::Python))?;
        Ok(Self { yosys, abc: Abc::find()?, answers: Mutex::default() })
    }

    /// Judges a problem; nothing where `stop` is set meanwhile.
    ///
    /// # Errors
    /// A program fails, or other assertions than expected reach ABC: none at all, or such as hold for no reason.
    pub fn judge(&self, problem: &Problem, stop: &AtomicBool) -> Result<Option<Answer>, Error> {
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
        match self.yosys.run(folder, "script", &problem.name, stop) {
            Err(ToolError::Stopped) => return Ok(None),
            other => other?,
        }
        self.check(folder, problem)?;
        // Constraints become outputs (fold), and all outputs one; what that does not depend on goes.
        let reduce = "read_aiger problem.aig; fold; strash; orpos; scleanup; trim; write_aiger reduced.aig";
        if self.abc.run(folder, reduce, LIMIT, stop)?.is_none() {
            return Ok(None);
        }
        let path = folder.join("reduced.aig");
        let graph = fs::read(&path).map_err(|problem| Error::File { path, problem })?;
        // ABC ends a graph with a comment that has the time in it.
        let key = (problem.method, without_comment(graph));
        let known = self.answers.lock().ok().and_then(|answers| answers.get(&key).copied());
        if known.is_some() {
            return Ok(known);
        }
        let method = match problem.method {
            Method::Unbounded => "pdr".to_string(),
            Method::Inductive => format!("bmc3 -F {BASE}; print_status; ind -F {BACK}"),
            Method::Bounded(cycles) => format!("bmc3 -F {cycles}"),
        };
        let commands = format!("read_aiger reduced.aig; {method}; print_status");
        let Some(said) = self.abc.run(folder, &commands, LIMIT, stop)? else {
            return Ok((!stop.load(Ordering::Relaxed)).then_some(Answer::Undecided));
        };
        let answer = answer(&said, problem.method);
        if let Ok(mut answers) = self.answers.lock() {
            answers.insert(key, answer);
        }
        Ok(Some(answer))
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
    let base_fails = said.lines().any(|line| line.trim().starts_with("Status = 0 "));
    match (status, method) {
        // The induction, which comes after, does not know of it.
        (_, Method::Inductive) if base_fails => Answer::Fails,
        (Some("1"), Method::Inductive) if !through(BASE) => Answer::Undecided,
        (Some("1"), _) => Answer::Holds,
        (Some("0"), _) => Answer::Fails,
        (Some("-1"), Method::Bounded(cycles)) if through(cycles) => Answer::Holds,
        _ => Answer::Undecided,
    }
}

/// A graph without the last line of the comment that ABC ends it with, which has the time in it. It is the last of its
/// kind in the file, so that nothing of the graph itself goes.
fn without_comment(mut graph: Vec<u8>) -> Vec<u8> {
    const SIGNATURE: &[u8] = b"This file was written by ABC";
    if let Some(end) = graph.windows(SIGNATURE.len()).rposition(|window| window == SIGNATURE) {
        graph.truncate(end);
    }
    graph
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
        let base = "No output asserted in 8 frames.\nStatus = -1  Frames = 7\n";
        assert_eq!(answer(&format!("{base}Status = 1  Frames = -1\n"), Method::Inductive), Answer::Holds);
        assert_eq!(answer("Status = 1  Frames = -1\n", Method::Inductive), Answer::Undecided);
        let refuted = "Status = 0  Frames = 4\nStatus = -1  Frames = -1\n";
        assert_eq!(answer(refuted, Method::Inductive), Answer::Fails);
        assert_eq!(answer(&format!("{base}Status = -1  Frames = -1\n"), Method::Inductive), Answer::Undecided);
        assert_eq!(answer("** cmd error\n", Method::Unbounded), Answer::Undecided);
    }
}
