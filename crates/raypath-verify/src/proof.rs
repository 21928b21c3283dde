//! Proofs by SAT: that the one output of a combinational circuit is never 1.
//!
//! A [`Problem`] is SystemVerilog with commands for Yosys that leave a circuit, a miter: its output says that two things
//! differ. Yosys makes an and-inverter graph of it (AIGER), and ABC's `&cec` either merges everything into the constant
//! 0, or gives inputs for which the output is 1, or gives up. Only ABC's own words for the first count as a proof.

mod abc;
mod aiger;

use crate::Error;
use abc::Abc;
use aiger::Aiger;
use raypath_ppa::{Yosys, YosysKind};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Yosys with its command `symfpu` and ABC, found.
#[derive(Debug, Clone)]
pub struct Prover {
    yosys: Yosys,
    abc: Abc,
}

/// A circuit whose output should never be 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// What messages call it.
    pub name: String,
    /// SystemVerilog texts, by the file names under which `commands` read them.
    pub sources: Vec<(String, String)>,
    /// Commands for Yosys, a line each, that leave the module `miter`, with one output of one bit.
    pub commands: Vec<String>,
    /// The inputs that `miter` must have, with their widths. More or fewer are an error: a wire that is driven by nothing
    /// would be one more.
    pub inputs: Vec<(String, u32)>,
}

/// What came of a problem.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The output is 0 for all inputs. How many and-gates that took: 0 where making the graph was proof enough.
    Proved {
        /// And-gates of the miter.
        gates: u64,
    },
    /// The output is 1 for these inputs, by name.
    Refuted(BTreeMap<String, u64>),
    /// ABC gave up, for the reason given.
    Undecided(String),
    /// It was stopped.
    Stopped,
}

/// What makes and-gates of a module named `miter`, and nothing else.
const TO_GATES: &[&str] =
    &["hierarchy -check -top miter", "flatten", "opt -full", "techmap", "opt", "aigmap", "opt_clean"];

impl Prover {
    /// Finds the Python module `pyosys`, and the ABC that comes with it or Debian's.
    ///
    /// # Errors
    /// One is not there; the message says what installs it.
    pub fn find() -> Result<Self, Error> {
        Ok(Self { yosys: Yosys::find(Some(YosysKind::Python))?, abc: Abc::find()? })
    }

    /// The versions of the programs.
    pub fn versions(&self) -> String {
        format!("{} and {}", self.yosys, self.abc)
    }

    /// Solves problems, one after the other, with at most `limit` for each; Yosys runs once for all of them.
    ///
    /// # Errors
    /// A program fails, or the circuit is not what the problem says.
    pub fn solve(&self, problems: &[Problem], limit: Duration, stop: &AtomicBool) -> Result<Vec<Answer>, Error> {
        let folder = tempfile::tempdir().map_err(|problem| file(&std::env::temp_dir(), problem))?;
        let graphs = match self.graphs(folder.path(), problems, stop)? {
            Some(graphs) => graphs,
            None => return Ok(vec![Answer::Stopped; problems.len()]),
        };
        let solve = |graph: &Aiger| self.abc.solve(folder.path(), graph, limit, stop);
        graphs.iter().map(solve).collect()
    }

    /// The problems as graphs in a folder; nothing where it was stopped.
    fn graphs(&self, folder: &Path, problems: &[Problem], stop: &AtomicBool) -> Result<Option<Vec<Aiger>>, Error> {
        let mut script = String::new();
        for (number, problem) in problems.iter().enumerate() {
            // Each has a folder of its own, so that file names may repeat.
            let inside = folder.join(number.to_string());
            fs::create_dir(&inside).map_err(|error| file(&inside, error))?;
            for (name, text) in &problem.sources {
                let path = inside.join(name);
                fs::write(&path, text).map_err(|error| file(&path, error))?;
            }
            let to_gates = TO_GATES.iter().map(ToString::to_string);
            let write = format!("write_aiger -symbols -map {number}.map {number}.aig");
            script += "design -reset\n";
            for command in problem.commands.iter().cloned().chain(to_gates).chain([write]) {
                script += &command.replace(SOURCE, &format!("{number}/"));
                script += "\n";
            }
        }
        let path = folder.join("script.ys");
        fs::write(&path, script).map_err(|error| file(&path, error))?;
        let about = problems.first().map(|problem| problem.name.as_str()).unwrap_or_default();
        match self.yosys.run(folder, "script.ys", about, stop) {
            Err(raypath_ppa::Error::Stopped) => return Ok(None),
            other => other?,
        }
        let read = |(number, problem)| Aiger::read(folder, number, problem);
        problems.iter().enumerate().map(read).collect::<Result<_, _>>().map(Some)
    }
}

/// What stands before the name of a source in [`Problem::commands`].
pub const SOURCE: &str = "@/";

fn file(path: &Path, problem: std::io::Error) -> Error {
    Error::File { path: path.to_path_buf(), problem }
}
