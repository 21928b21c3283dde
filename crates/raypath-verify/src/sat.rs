//! Proofs by SAT that the output of a combinational circuit is never 1.
//!
//! A [`Miter`] is SystemVerilog with commands for Yosys that leave a circuit whose output is 1 where two results
//! differ. Yosys converts it to an and-inverter graph (AIGER). ABC's `&cec` then reduces the graph to the constant 0,
//! finds inputs for which the output is 1, or gives up. Only ABC's message for the first case counts as a proof.

mod aiger;
mod certificate;

use crate::error::Error;
use crate::proofs::{cache, kept};
use aiger::Aiger;
pub use aiger::header;
pub use certificate::Certificate;
use certificate::Certifier;
use raypath_tools::{Abc, Cache, Key, ToolError, Yosys, YosysKind, read, temporary_folder, write};
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
        /// Whether a second solver has refuted that the output is 1.
        certificate: Certificate,
    },
    /// The output is 1 for these inputs, by name.
    Refuted(BTreeMap<String, u64>),
    /// ABC gave up, for this reason.
    Undecided(String),
    /// The run was stopped.
    Stopped,
}

/// What begins the line of Yosys's output before the values of a problem.
const EVALUATED: &str = "evaluated problem ";

/// The prefix of a source's file name in [`Miter::commands`].
pub const SOURCE: &str = "@/";

/// Yosys with its command `symfpu`, and ABC. Results are kept ([`crate::proofs`]).
#[derive(Debug, Clone)]
pub struct Prover {
    yosys: Yosys,
    abc: Abc,
    certifier: Option<Certifier>,
    cache: Cache,
}

/// What the cache has of a problem: its result, and the limit of its certificate in seconds.
type Kept = (ProofResult, u64);

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
        Ok(Self { yosys, abc, certifier: None, cache: cache() })
    }

    /// Keeps results in this folder instead of [`crate::proofs::FOLDER`].
    pub fn keeping_in(self, folder: &Path) -> Self {
        Self { cache: Cache::new(folder), ..self }
    }

    /// Also finds CaDiCaL, which repeats each proof in at most `limit`, with a certificate that is checked.
    ///
    /// # Errors
    /// A program is missing.
    pub fn with_certificates(limit: Duration) -> Result<Self, Error> {
        Ok(Self { certifier: Some(Certifier::find(limit)?), ..Self::find()? })
    }

    /// The versions of the programs.
    pub fn versions(&self) -> String {
        match &self.certifier {
            None => format!("{} and {}", self.yosys.version, self.abc.version),
            Some(certifier) => {
                format!("{}, {} and {}", self.yosys.version, self.abc.version, certifier.solver.version)
            }
        }
    }

    /// Solves problems one after the other, in at most `limit` each. Yosys runs once for all whose result is not kept.
    ///
    /// # Errors
    /// A program fails, or a circuit has other inputs or outputs than its problem states; a result cannot be written.
    pub fn solve(&self, problems: &[Miter], limit: Duration, stop: &AtomicBool) -> Result<Vec<ProofResult>, Error> {
        let keys: Vec<Key> = problems.iter().map(|problem| self.key(problem)).collect();
        let mut results: Vec<Option<ProofResult>> = keys.iter().map(|key| self.known(key)).collect();
        let open: Vec<usize> = (0..problems.len()).filter(|&number| results[number].is_none()).collect();
        if !open.is_empty() {
            let folder = temporary_folder()?;
            let problems: Vec<&Miter> = open.iter().map(|&number| &problems[number]).collect();
            let graphs = self.graphs(folder.path(), &problems, stop)?.unwrap_or_default();
            for (&number, graph) in open.iter().zip(&graphs) {
                let result = self.prove(folder.path(), graph, limit, stop)?;
                if matches!(result, ProofResult::Proved { .. } | ProofResult::Refuted(_)) {
                    self.cache.put(&keys[number], &(&result, self.certificate_seconds()))?;
                }
                results[number] = Some(result);
            }
        }
        Ok(results.into_iter().map(|result| result.unwrap_or(ProofResult::Stopped)).collect())
    }

    /// The name of a problem's result: a digest of all that the result depends on.
    fn key(&self, problem: &Miter) -> Key {
        let inputs = problem.inputs.iter().map(|(name, width)| format!("{name} {width}"));
        let state = if self.certifier.is_some() { "certified" } else { "not certified" };
        let counts = format!("{} texts, {} inputs, {state}", problem.sources.len(), problem.inputs.len());
        let others: Vec<String> = [counts, self.versions()].into_iter().chain(inputs).collect();
        let texts = problem.sources.iter().flat_map(|(name, text)| [name, text]).chain(&problem.commands);
        let parts: Vec<&str> = others.iter().chain(texts).map(String::as_str).chain([TO_GATES, TO_CONSTANT]).collect();
        Key::new("sat", &parts)
    }

    /// The kept result, unless its certificate was too long for a shorter limit than this one.
    fn known(&self, key: &Key) -> Option<ProofResult> {
        let (result, seconds) = self.cache.get::<Kept>(key)?;
        let is_open = matches!(result, ProofResult::Proved { certificate: Certificate::TooLong, .. });
        (!is_open || seconds >= self.certificate_seconds()).then_some(result)
    }

    fn certificate_seconds(&self) -> u64 {
        self.certifier.as_ref().map_or(0, |certifier| certifier.limit.as_secs())
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
        let counterexample = || fs::read_to_string(&example).ok().and_then(|word| graph.ports(word.trim()));
        match verdict(&output) {
            Some(true) => self.certified(folder, graph, stop),
            Some(false) => Ok(counterexample().map(ProofResult::Refuted).ok_or_else(|| {
                let found = format!("{}: refuted without a counterexample", graph.problem);
                ToolError::unexpected("abc", found, "a value for each input")
            })?),
            None => Ok(ProofResult::Undecided(Abc::last_line(&output))),
        }
    }

    /// The result for a graph that ABC has proved.
    fn certified(&self, folder: &Path, graph: &Aiger, stop: &AtomicBool) -> Result<ProofResult, Error> {
        let certificate = match &self.certifier {
            Some(certifier) => certifier.certify(folder, &graph.file, stop)?,
            None => Certificate::NotTried,
        };
        Ok(match certificate {
            Certificate::Wrong(why) => ProofResult::Undecided(format!("proved by ABC, but {why}")),
            certificate => ProofResult::Proved { gates: graph.gates, certificate },
        })
    }

    /// The values of a miter's wires for these inputs, evaluated by Yosys, independently of ABC.
    ///
    /// # Errors
    /// Yosys fails, or a wire has no definite value.
    pub fn evaluate(&self, problem: &Miter, values: &BTreeMap<String, u64>, wires: &[&str]) -> Result<Vec<u64>, Error> {
        Ok(self.evaluate_all(&[(problem, values)], wires)?.pop().unwrap_or_default())
    }

    /// Checks with Yosys, independently of ABC, that a wire of each miter is 1 for its inputs.
    ///
    /// # Errors
    /// Yosys fails, or the wire of a miter is not 1.
    pub fn confirm(&self, found: &[(&Miter, &BTreeMap<String, u64>)], wire: &str) -> Result<(), Error> {
        let shown = self.evaluate_all(found, &[wire])?;
        match found.iter().zip(shown).find(|(_, shown)| *shown != [1]) {
            Some(((problem, values), shown)) => {
                let found = format!("{}: not a counterexample: {values:x?} gives {shown:x?}", problem.name);
                Err(ToolError::unexpected("abc", found, "inputs for which the sides differ").into())
            }
            None => Ok(()),
        }
    }

    /// The values of wires of miters, for the inputs of each; kept like proofs.
    fn evaluate_all(
        &self,
        problems: &[(&Miter, &BTreeMap<String, u64>)],
        wires: &[&str],
    ) -> Result<Vec<Vec<u64>>, Error> {
        let asked = problems.iter().map(|(problem, values)| format!("{} {values:?}", self.key(problem).as_str()));
        let asked: Vec<String> = asked.chain([format!("{wires:?}")]).collect();
        let key = Key::new("values", &asked.iter().map(String::as_str).collect::<Vec<_>>());
        kept(&self.cache, &key, |_| true, || self.evaluate_now(problems, wires))
    }

    fn evaluate_now(
        &self,
        problems: &[(&Miter, &BTreeMap<String, u64>)],
        wires: &[&str],
    ) -> Result<Vec<Vec<u64>>, Error> {
        let Some((first, _)) = problems.first() else { return Ok(Vec::new()) };
        let folder = temporary_folder()?;
        let mut script = String::new();
        for (number, (problem, values)) in problems.iter().enumerate() {
            script += &write_sources(problem, folder.path(), number)?;
            let width =
                |name: &str| problem.inputs.iter().find(|(input, _)| input == name).map_or(1, |(_, width)| *width);
            let set: Vec<String> =
                values.iter().map(|(name, value)| format!("-set {name} {}'d{value}", width(name))).collect();
            let show: Vec<String> = wires.iter().map(|wire| format!("-show {wire}")).collect();
            script += &format!(
                "hierarchy -check -top miter\nflatten\nlog {EVALUATED}{number}\neval {} {} miter\n",
                set.join(" "),
                show.join(" ")
            );
        }
        write(&folder.path().join("script.ys"), &script)?;
        self.yosys.run(folder.path(), "script.ys", &first.name, &AtomicBool::new(false))?;
        let log = read(&folder.path().join(Yosys::LOG))?;
        let output = String::from_utf8_lossy(&log);
        let value = |number: usize, problem: &Miter, wire: &str| {
            let begin = format!("{EVALUATED}{number}");
            let lines = output.lines().skip_while(|line| *line != begin).skip(1);
            // Eval result: \a = 16'0011110000000000.
            let begin = format!("Eval result: \\{wire} = ");
            let line = lines.take_while(|line| !line.starts_with(EVALUATED)).find_map(|line| line.strip_prefix(&begin));
            let value = line.and_then(|line| parse_value(line.trim_end_matches('.')));
            Ok(value.ok_or_else(|| {
                let found = format!("{}: evaluated {wire} to {line:?}", problem.name);
                ToolError::unexpected("yosys", found, "a definite value")
            })?)
        };
        let all = problems.iter().enumerate();
        all.map(|(number, (problem, _))| wires.iter().map(|wire| value(number, problem, wire)).collect()).collect()
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

/// Parses a value as Yosys prints it: in binary after its width, but as a signed decimal number if it has 32 bits.
fn parse_value(value: &str) -> Option<u64> {
    match value.split_once('\'') {
        Some((_, digits)) => u64::from_str_radix(digits, 2).ok(),
        None => value.parse::<i32>().ok().map(|number| u64::from(number.cast_unsigned())),
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
