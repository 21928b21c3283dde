//! Proofs by SAT that the output of a combinational circuit is never 1.
//!
//! A [`Miter`] is SystemVerilog with commands for Yosys that leave a circuit whose output is 1 where two results
//! differ. Yosys converts it to an and-inverter graph (AIGER). ABC's `&cec` then reduces the graph to the constant 0,
//! finds inputs for which the output is 1, or gives up. Only ABC's message for the first case counts as a proof.

mod aiger;

use crate::error::Error;
use crate::proofs::cache;
use aiger::Aiger;
pub use aiger::header;
use raypath_tools::{Abc, Cache, Key, ToolError, Yosys, YosysKind, temporary_folder, write};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A circuit whose output must never be 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Miter {
    /// The problem's name in messages.
    pub name: String,
    /// SystemVerilog texts, by the file names that `commands` use.
    pub sources: Vec<(String, String)>,
    /// Commands for Yosys, a line each, that leave the module `miter` with one output of one bit.
    pub commands: Vec<String>,
    /// The inputs of `miter`, with their widths. Other inputs are an error: an undriven wire would be an input.
    pub inputs: Vec<(String, u32)>,
}

/// The result of a proof.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProofResult {
    /// The output is 0 for all inputs.
    Proved {
        /// And-gates of the miter; 0 if the conversion to gates already reduced it to the constant 0.
        gates: u64,
    },
    /// The output is 1 for these inputs, by name.
    Refuted(BTreeMap<String, u64>),
    /// ABC gave up, for this reason.
    Undecided(String),
    /// The run was stopped.
    Stopped,
}

/// The prefix of a source's file name in [`Miter::commands`].
pub const SOURCE: &str = "@/";

/// Yosys with its command `symfpu`, and ABC. Results are kept ([`crate::proofs`]).
#[derive(Debug, Clone)]
pub struct Prover {
    yosys: Yosys,
    abc: Abc,
    cache: Cache,
}

/// The commands that convert the module `miter` to and-gates. An undriven wire becomes an input, which the check of the
/// inputs rejects; otherwise optimisation would choose its value.
const TO_GATES: &str = "hierarchy -check -top miter; flatten; setundef -undriven -anyseq; opt -full; techmap; opt; aigmap; \
                        opt_clean";

/// ABC's commands. Their limit on conflicts is never reached: time decides.
const TO_CONSTANT: &str = "&get; &cec -m -C 1000000000; write_cex example";

impl Prover {
    /// Finds the Python module `pyosys`, and its ABC or Debian's.
    ///
    /// # Errors
    /// A program is missing; the message says how to install it.
    pub fn find() -> Result<Self, Error> {
        let (yosys, abc) = (Yosys::find(Some(YosysKind::Python))?, Abc::find()?);
        Ok(Self { yosys, abc, cache: cache() })
    }

    /// Keeps results in this folder instead of [`crate::proofs::FOLDER`].
    pub fn keeping_in(self, folder: &Path) -> Self {
        Self { cache: Cache::new(folder), ..self }
    }

    /// The versions of the programs.
    pub fn versions(&self) -> String {
        format!("{} and {}", self.yosys.version, self.abc.version)
    }

    /// Solves problems one after the other, in at most `limit` each. Yosys runs once for all whose result is not kept.
    ///
    /// # Errors
    /// A program fails, or a circuit has other inputs or outputs than its problem states; a result cannot be written.
    pub fn solve(&self, problems: &[Miter], limit: Duration, stop: &AtomicBool) -> Result<Vec<ProofResult>, Error> {
        let keys: Vec<Key> = problems.iter().map(|problem| self.key(problem)).collect();
        let mut results: Vec<Option<ProofResult>> = keys.iter().map(|key| self.cache.get(key)).collect();
        let open: Vec<usize> = (0..problems.len()).filter(|&number| results[number].is_none()).collect();
        if !open.is_empty() {
            let folder = temporary_folder()?;
            let problems: Vec<&Miter> = open.iter().map(|&number| &problems[number]).collect();
            let graphs = self.graphs(folder.path(), &problems, stop)?.unwrap_or_default();
            for (&number, graph) in open.iter().zip(&graphs) {
                let result = self.prove(folder.path(), graph, limit, stop)?;
                if matches!(result, ProofResult::Proved { .. } | ProofResult::Refuted(_)) {
                    self.cache.put(&keys[number], &result)?;
                }
                results[number] = Some(result);
            }
        }
        Ok(results.into_iter().map(|result| result.unwrap_or(ProofResult::Stopped)).collect())
    }

    /// The name of a problem's result: a digest of all that the result depends on.
    fn key(&self, problem: &Miter) -> Key {
        let inputs = problem.inputs.iter().map(|(name, width)| format!("{name} {width}"));
        let counts = format!("{} texts, {} inputs", problem.sources.len(), problem.inputs.len());
        let others: Vec<String> = [counts, self.versions()].into_iter().chain(inputs).collect();
        let texts = problem.sources.iter().flat_map(|(name, text)| [name, text]).chain(&problem.commands);
        let parts: Vec<&str> = others.iter().chain(texts).map(String::as_str).chain([TO_GATES, TO_CONSTANT]).collect();
        Key::new("sat", &parts)
    }

    /// Proves with ABC that a graph's output is 0.
    fn prove(&self, folder: &Path, graph: &Aiger, limit: Duration, stop: &AtomicBool) -> Result<ProofResult, Error> {
        let example = folder.join("example");
        let _ = fs::remove_file(&example);
        let commands = format!("read_aiger {}; {TO_CONSTANT}", graph.file);
        let Some(output) = self.abc.run(folder, &commands, limit, stop)? else {
            let timeout = || ProofResult::Undecided(format!("no answer within {} s", limit.as_secs()));
            return Ok(if stop.load(Ordering::Relaxed) { ProofResult::Stopped } else { timeout() });
        };
        let counterexample = || fs::read_to_string(&example).ok().and_then(|word| graph.counterexample(word.trim()));
        match verdict(&output) {
            Some(true) => Ok(ProofResult::Proved { gates: graph.graph.gates.len() as u64 }),
            Some(false) => Ok(counterexample().map(ProofResult::Refuted).ok_or_else(|| {
                let found = format!("{}: refuted by no counterexample", graph.problem);
                ToolError::unexpected("abc", found, "inputs for which the output is 1")
            })?),
            None => Ok(ProofResult::Undecided(Abc::last_line(&output))),
        }
    }

    /// Writes the problems as graphs into a folder; none if the run was stopped.
    fn graphs(&self, folder: &Path, problems: &[&Miter], stop: &AtomicBool) -> Result<Option<Vec<Aiger>>, Error> {
        let mut script = String::new();
        for (number, problem) in problems.iter().enumerate() {
            script += &write_sources(problem, folder, number)?;
            script += &format!("{TO_GATES}\nwrite_aiger -symbols -map {number}.map {number}.aig\n");
        }
        write(&folder.join("script.ys"), &script)?;
        let about = problems.first().map(|problem| problem.name.as_str()).unwrap_or_default();
        match self.yosys.run(folder, "script.ys", about, stop) {
            Err(ToolError::Stopped) => return Ok(None),
            other => other?,
        }
        let graphs = problems.iter().enumerate().map(|(number, problem)| Aiger::read(folder, number, problem));
        graphs.collect::<Result<_, _>>().map(Some)
    }
}

/// Writes a problem's sources to a subfolder, so that problems can have the same file names, and returns its commands.
fn write_sources(problem: &Miter, folder: &Path, number: usize) -> Result<String, Error> {
    let inside = folder.join(number.to_string());
    fs::create_dir(&inside).map_err(|problem| ToolError::file(&inside, "create the folder", problem))?;
    for (name, text) in &problem.sources {
        write(&inside.join(name), text)?;
    }
    let commands = problem.commands.iter().map(|command| command.replace(SOURCE, &format!("{number}/")) + "\n");
    Ok(std::iter::once("design -reset\n".to_string()).chain(commands).collect())
}

/// Whether ABC reports a proof, or a refutation: exactly one such line, and none of the other kind.
fn verdict(output: &str) -> Option<bool> {
    let proved = output.lines().filter(|line| line.starts_with("Networks are equivalent")).count();
    let refuted = output.lines().filter(|line| line.starts_with("Networks are NOT EQUIVALENT")).count();
    match (proved, refuted, output.contains("UNDECIDED")) {
        (1, 0, false) => Some(true),
        (0, 1, false) => Some(false),
        _ => None,
    }
}

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
