//! The model checker: Yosys and ABC on a module with assertions.

use crate::error::Error;
use crate::proofs::cache;
use crate::sat::header;
use raypath_tools::{Abc, Cache, Key, ToolError, Yosys, YosysKind, digest, read, temporary_folder, write};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A module with assertions, as one SystemVerilog text, and how to check it.
#[derive(Debug, Clone)]
pub struct SafetyProblem {
    /// The problem's name in messages.
    pub name: String,
    /// The module's name.
    pub top: String,
    /// The module and all modules below it.
    pub text: String,
    /// The number of assertions that must reach ABC.
    pub assertions: usize,
    /// The method of the check.
    pub method: Method,
}

/// The method of a check, and how many cycles it covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// All reachable states, by property-directed reachability (Bradley 2011, Eén et al. 2011), which finds its own
    /// inductive lemmas.
    Unbounded,
    /// All reachable states, by k-induction: the assertions hold in the first cycles, and if they hold in k cycles they
    /// hold in the next (Sheeran, Singh, Stålmarck 2000).
    Inductive,
    /// This many cycles from the first reset, by bounded model checking.
    Bounded(u32),
}

/// The result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CheckResult {
    /// No assertion fails in the cycles that the method covers.
    Holds,
    /// An assertion fails.
    Fails,
    /// ABC gave up.
    Undecided,
}

/// Yosys and ABC. Results are kept ([`crate::proofs`]), by the text and by the graph that ABC checks, which different
/// texts may have.
#[derive(Debug)]
pub struct ModelChecker {
    yosys: Yosys,
    abc: Abc,
    cache: Cache,
}

/// The time limit for a problem.
const LIMIT: Duration = Duration::from_secs(600);
/// Cycles of an induction's base case: those of the deepest step.
const BASE_CYCLES: u32 = MAX_DEPTH;
/// Cycles in which an assertion that is not inductive may be refuted.
const REFUTED_CYCLES: u32 = 8;
/// The largest k of an induction.
const MAX_DEPTH: u32 = 3;

/// The commands that convert a text to an and-inverter graph with state. Units are empty modules, so that their outputs
/// are free in every cycle. The module's outputs are deleted, so that only the logic of assertions remains. The words
/// of memories become registers. The data of a register that does not load may be unknown: it is free too.
const TO_GRAPH: &str = "proc; flatten; memory; delete t:raypath_fp_* t:raypath_narrow_* t:raypath_unit_prepare; delete -port o:*; opt_clean; setundef -undriven -anyseq; \
                        async2sync; chformal -lower; opt_clean; techmap; opt; setundef -undriven -anyseq; dffunmap; opt_clean; \
                        aigmap; opt_clean";

/// ABC's commands before the check. Constraints become outputs (fold), all outputs become one, and logic that it does not
/// depend on is removed.
const REDUCE: &str = "read_aiger problem.aig; fold; strash; orpos; scleanup; trim; write_aiger reduced.aig";

impl ModelChecker {
    /// Finds the Python module `pyosys`, and its ABC or Debian's.
    ///
    /// # Errors
    /// A program is missing.
    pub fn find() -> Result<Self, Error> {
        let yosys = Yosys::find(Some(YosysKind::Python))?;
        Ok(Self { yosys, abc: Abc::find()?, cache: cache() })
    }

    /// Keeps results in this folder instead of [`crate::proofs::FOLDER`].
    pub fn keeping_in(self, folder: &Path) -> Self {
        Self { cache: Cache::new(folder), ..self }
    }

    /// Checks a problem; none if `stop` is set meanwhile.
    ///
    /// # Errors
    /// A program fails, or another number of assertions than stated reaches ABC; a result cannot be written.
    pub fn check(&self, problem: &SafetyProblem, stop: &AtomicBool) -> Result<Option<CheckResult>, Error> {
        let script = format!(
            "read_verilog -sv -formal problem.sv\nhierarchy -check -top {}\n{TO_GRAPH}\nwrite_aiger -zinit -B problem.aig\n",
            problem.top
        );
        let method = match problem.method {
            Method::Unbounded => "pdr".to_string(),
            Method::Inductive => format!("bmc3 -F {BASE_CYCLES}; print_status; ind -F {MAX_DEPTH}"),
            Method::Bounded(cycles) => format!("bmc3 -F {cycles}"),
        };
        let (yosys, abc, assertions) = (&self.yosys.version, &self.abc.version, problem.assertions.to_string());
        let key = Key::new("safety", &[&problem.text, &script, &assertions, REDUCE, &method, yosys, abc]);
        self.cache.kept(&key, is_final, || self.check_text(problem, &script, &method, stop))
    }

    fn check_text(
        &self,
        problem: &SafetyProblem,
        script: &str,
        method: &str,
        stop: &AtomicBool,
    ) -> Result<Option<CheckResult>, Error> {
        let folder = temporary_folder()?;
        let folder = folder.path();
        write(&folder.join("problem.sv"), &problem.text)?;
        write(&folder.join("script"), script)?;
        match self.yosys.run(folder, "script", &problem.name, stop) {
            Err(ToolError::Stopped) => return Ok(None),
            other => other?,
        }
        check_graph(folder, problem)?;
        if self.abc.run(folder, REDUCE, LIMIT, stop)?.is_none() {
            return Ok(None);
        }
        let (_, numbers) = header(&folder.join("reduced.aig"))?;
        let (method, kind) = match numbers.get(2) {
            // Methods for state refuse a graph without.
            Some(0) => ("iprove", Method::Unbounded),
            _ => (method, problem.method),
        };
        // ABC's comment at the end holds the time.
        let graph = digest(&without_comment(read(&folder.join("reduced.aig"))?));
        let key = Key::new("graph", &[&graph, method, &self.abc.version]);
        self.cache.kept(&key, is_final, || {
            let run = |method: &str, kind: Method| {
                let commands = format!("read_aiger reduced.aig; {method}; print_status");
                let output = self.abc.run(folder, &commands, LIMIT, stop)?;
                let undecided = (!stop.load(Ordering::Relaxed)).then_some(CheckResult::Undecided);
                Ok::<_, Error>(output.map_or(undecided, |output| Some(result(&output, kind))))
            };
            let found = run(method, kind)?;
            if (found, kind) != (Some(CheckResult::Undecided), Method::Inductive) {
                return Ok(found);
            }
            let refuted = run(&format!("bmc3 -F {REFUTED_CYCLES}"), Method::Bounded(REFUTED_CYCLES))?;
            Ok(refuted.filter(|refuted| *refuted == CheckResult::Fails).or(found))
        })
    }
}

/// Whether a result does not depend on the time that a check had.
fn is_final(result: &Option<CheckResult>) -> bool {
    matches!(result, Some(CheckResult::Holds | CheckResult::Fails))
}

/// Checks that the graph has the problem's number of assertions, and state and gates.
fn check_graph(folder: &Path, problem: &SafetyProblem) -> Result<(), Error> {
    // The numbers of variables, inputs, latches, outputs, and-gates, assertions, constraints.
    let (header, numbers) = header(&folder.join("problem.aig"))?;
    match numbers[..] {
        [_, _, latches, _, gates, found, ..] if latches > 0 && gates > 0 && found == problem.assertions as u64 => {
            Ok(())
        }
        _ => {
            let found = format!("{}: found a circuit '{header}'", problem.name);
            let expected = format!("one with {} assertions that depend on state", problem.assertions);
            Err(ToolError::unexpected("yosys", found, expected).into())
        }
    }
}

/// Reads the last status that ABC prints: 1 proved, 0 refuted, -1 undecided.
fn result(output: &str, method: Method) -> CheckResult {
    let status = output.lines().rev().find_map(|line| line.trim().strip_prefix("Status = ")?.split_whitespace().next());
    let through = |cycles: u32| output.contains(&format!("No output asserted in {cycles} frames"));
    let base_fails = output.lines().any(|line| line.trim().starts_with("Status = 0 "));
    match (status, method) {
        // The induction after the base case ignores its failure.
        (_, Method::Inductive) if base_fails => CheckResult::Fails,
        (Some("1"), Method::Inductive) if !through(BASE_CYCLES) => CheckResult::Undecided,
        (Some("1"), _) => CheckResult::Holds,
        (Some("0"), _) => CheckResult::Fails,
        (Some("-1"), Method::Bounded(cycles)) if through(cycles) => CheckResult::Holds,
        _ => CheckResult::Undecided,
    }
}

/// A graph without ABC's comment at its end, which holds the time. The last match in the file is the comment, so that
/// the graph itself stays whole.
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
    fn only_a_status_is_a_result() {
        let bounded = Method::Bounded(8);
        assert_eq!(result("Property proved.\nStatus = 1  Frames = -1\n", Method::Unbounded), CheckResult::Holds);
        assert_eq!(result("Status = 0  Frames = 3\n", Method::Unbounded), CheckResult::Fails);
        assert_eq!(result("Status = 0  Frames = 3\n", bounded), CheckResult::Fails);
        assert_eq!(result("No output asserted in 8 frames.\nStatus = -1  Frames = 7\n", bounded), CheckResult::Holds);
        assert_eq!(
            result("No output asserted in 7 frames.\nStatus = -1  Frames = 6\n", bounded),
            CheckResult::Undecided
        );
        assert_eq!(result("No output asserted in 8 frames.\nStatus = -1\n", Method::Unbounded), CheckResult::Undecided);
        let base = "No output asserted in 3 frames.\nStatus = -1  Frames = 2\n";
        assert_eq!(result(&format!("{base}Status = 1  Frames = -1\n"), Method::Inductive), CheckResult::Holds);
        assert_eq!(result("Status = 1  Frames = -1\n", Method::Inductive), CheckResult::Undecided);
        let refuted = "Status = 0  Frames = 4\nStatus = -1  Frames = -1\n";
        assert_eq!(result(refuted, Method::Inductive), CheckResult::Fails);
        assert_eq!(result(&format!("{base}Status = -1  Frames = -1\n"), Method::Inductive), CheckResult::Undecided);
        assert_eq!(result("** cmd error\n", Method::Unbounded), CheckResult::Undecided);
    }
}
