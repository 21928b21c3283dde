//! What is asked of an operation in a datapath: the oracle, the models, and the emitted text in Verilator.

use crate::check::{Comparison, lockstep};
use crate::datapath::Datapath;
use crate::engine::{PortEncoding, shape};
use crate::frames::{Answers, Stimulus};
use crate::model::{AnyKind, Words};
use crate::stimuli::any_job;
use crate::study::AnyStudy;
use crate::traffic::Traffic;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_cosim::{CosimError, Sources, Verilated};
use raypath_format::Format;
use raypath_model::{Model, OnPorts};
use raypath_rtl as rtl;
use std::path::Path;

/// The checks of one operation in a datapath, reproducible by `seed`.
pub struct Checks<'d> {
    /// The datapath, which has the operation.
    pub datapath: &'d Datapath,
    /// The same, elaborated.
    pub netlist: &'d rtl::Datapath,
    /// The operation, with its jobs and its oracle.
    pub study: &'d AnyStudy,
    /// Seed of jobs and traffic.
    pub seed: u64,
    /// How many jobs.
    pub jobs: usize,
}

/// Answers of the functional model, held against the oracle.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Judged {
    /// How many jobs.
    pub jobs: usize,
    /// How many answers were wrong.
    pub wrong: usize,
    /// The first few of them, in words.
    pub faults: Vec<String>,
}

/// Cycles of the emitted text in Verilator.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Simulated {
    /// How many cycles.
    pub cycles: usize,
    /// Cycles in which a port showed something else than the cycle-exact model.
    pub different: usize,
    /// The first few of them, in words.
    pub faults: Vec<String>,
    /// Answers of the operation that Verilator showed, held against the oracle.
    pub judged: Judged,
}

const SHOWN: usize = 5;
/// Part of the jobs that are the operation's; the others are of the rest of the datapath.
const OWN: f64 = 0.5;

impl Checks<'_> {
    /// The operation's answers to its jobs. `None` where the study has no oracle, or the datapath is not in binary32,
    /// which oracles speak of.
    pub fn against_the_oracle(&self) -> Option<Judged> {
        let mut model = self.datapath.model();
        let mut judge = self.judge()?;
        let kind = model.kind(self.study.name())?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        for _ in 0..self.jobs {
            let job = self.study.job(&model, kind, &mut rng);
            let outcome = model.run(&job);
            judge.hold(&job, &outcome);
        }
        Some(judge.judged)
    }

    /// Netlist, cycle-exact and functional model side by side: jobs of all operations, bubbles and stalls. `on_job` is told
    /// how many have left, and says whether to go on.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn against_the_models(&self, on_job: impl FnMut(usize) -> bool) -> Result<Comparison, rtl::Error> {
        let mut netlist = self.datapath.netlist(self.netlist)?;
        let mut traffic = Traffic::random(self.seed);
        Ok(lockstep(&mut netlist, self.datapath.model(), self.mixed_jobs().into_iter(), &mut traffic, on_job))
    }

    /// The emitted text: past Verilator, Yosys and slang without a word, then in Verilator, in every cycle like the
    /// cycle-exact model, and each answer of the operation before the oracle.
    ///
    /// # Errors
    /// A tool that is not installed, or that has something to say.
    pub fn in_verilator(&self, folder: &Path) -> Result<Simulated, CosimError> {
        let top = self.netlist.top();
        let sources = Sources::write(top, folder)?;
        sources.lint()?;
        let verilated = Verilated::build_sources(&sources.files, top, folder, &Default::default())?;
        let config = self.datapath.config();
        let jobs = self.mixed_jobs();
        let stimulus = Stimulus {
            shape: shape(config, self.netlist),
            encoding: PortEncoding::of(config),
            jobs: &jobs,
            answers: Answers::Model(self.datapath.model()),
            traffic: Traffic::random(self.seed),
            resets: Vec::new(),
        };
        let (inputs, expected): (Vec<_>, Vec<_>) =
            stimulus.cycles(top).into_iter().map(|cycle| (cycle.inputs, cycle.expected)).unzip();
        let mut found = Simulated { cycles: inputs.len(), ..Simulated::default() };
        let is_taken = output_ready(top, &inputs);
        let mut judge = self.judge();
        let own = |words: &&Words| words.kind().name() == self.study.name();
        let mut waiting = jobs.iter();
        verilated.run(inputs, |cycle, values| {
            let Some(expected) = expected.get(cycle).and_then(Option::as_ref) else { return };
            if let Some(fault) = expected.fault(top, values) {
                found.different += 1;
                if found.faults.len() < SHOWN {
                    found.faults.push(format!("cycle {cycle}: {fault}"));
                }
            }
            // What the ports show is this outcome, or else a fault was found above.
            let outcome = expected.output.as_ref().filter(|_| is_taken.get(cycle).copied().unwrap_or(false));
            if let (Some(outcome), Some(judge)) = (outcome.filter(own), &mut judge)
                && let Some(job) = waiting.find(own)
            {
                judge.hold(job, outcome);
            }
        })?;
        found.judged = judge.map(|judge| judge.judged).unwrap_or_default();
        Ok(found)
    }

    fn judge(&self) -> Option<Judge> {
        let is_binary32 = self.datapath.config().format == Format::BINARY32;
        let oracle = self.study.oracle.as_ref().filter(|_| is_binary32)?;
        Some(Judge { judge: (oracle.judge)(), judged: Judged::default() })
    }

    /// Jobs of all operations, half of them the operation's own.
    fn mixed_jobs(&self) -> Vec<Words> {
        let model = self.datapath.model();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let kinds = model.kinds();
        let (own, others): (Vec<AnyKind>, Vec<AnyKind>) =
            kinds.iter().copied().partition(|kind| kind.name() == self.study.name());
        let mut job = || {
            let take_own = others.is_empty() || rng.random_bool(OWN);
            let from = if take_own { &own } else { &others };
            let kind = from.get(rng.random_range(0..from.len().max(1))).copied()?;
            Some(if take_own { self.study.job(&model, kind, &mut rng) } else { any_job(&model, kind, &mut rng) })
        };
        (0..self.jobs).filter_map(|_| job()).collect()
    }
}

/// An oracle at work.
struct Judge {
    judge: crate::study::Judge,
    judged: Judged,
}

impl Judge {
    fn hold(&mut self, job: &Words, outcome: &Words) {
        self.judged.jobs += 1;
        if let Err(fault) = (self.judge)(job.as_words(), outcome.as_words()) {
            self.judged.wrong += 1;
            if self.judged.faults.len() < SHOWN {
                self.judged.faults.push(format!("job {}: {fault}; {job:?} -> {outcome:?}", self.judged.jobs - 1));
            }
        }
    }
}

/// In which cycles the sink takes.
fn output_ready(top: &raypath_hdl::Module, inputs: &[Vec<u64>]) -> Vec<bool> {
    let place = top.inputs().iter().position(|port| port.name == "output_ready_i").map_or(0, |place| place + 1);
    inputs.iter().map(|frame| frame.get(place) == Some(&1)).collect()
}
