//! What is asked of operations in a datapath: the oracle, the models, and the emitted text in Verilator.

use crate::spec::AnyOperationSpec;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::Model;
use raypath_rtl as rtl;
use raypath_sim::Datapath;
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Stimulus};
use raypath_sim::jobs::any_job;
use raypath_sim::lockstep::{Comparison, lockstep};
use raypath_sim::traffic::Traffic;
use raypath_sim::transactions::{self, Transaction};
use raypath_sim::{OperationId, WordModel, Words};
use raypath_tools::{Sources, ToolError, Verilated};
use std::path::{Path, PathBuf};

/// The checks of some of a datapath's operations, reproducible by `seed`.
pub struct Checks<'d> {
    /// The datapath, which has these operations.
    pub datapath: &'d Datapath,
    /// The same, elaborated.
    pub netlist: &'d rtl::Datapath,
    /// The operations, with their jobs and oracles.
    pub specs: &'d [AnyOperationSpec],
    /// Seed of jobs and traffic.
    pub seed: u64,
    /// How many jobs.
    pub jobs: usize,
}

/// Answers of the functional model, held against the oracle.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OracleReport {
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
    /// Answers that Verilator showed, held against the oracles: for each spec that has one.
    pub reports: Vec<OracleReport>,
}

const SHOWN: usize = 5;
/// Transactions of a file at most.
const MOST_WRITTEN: usize = 10_000;
/// Part of the jobs that are of the studied operations; the others are of the rest of the datapath.
const OWN: f64 = 0.5;

impl Checks<'_> {
    /// The operations' answers to their jobs: for each spec that has an oracle, as many jobs. None where the datapath
    /// is not in binary32, which oracles speak of.
    pub fn against_the_oracles(&self) -> Vec<OracleReport> {
        let model = self.datapath.model();
        let reports = self.oracle_runs().into_iter().map(|mut run| {
            let answered = self.answered(run.spec, run.kind);
            answered.for_each(|(job, outcome)| run.check_answer(&model, &job, &outcome));
            run.report
        });
        reports.collect()
    }

    /// The same jobs of one of the operations with the answers, for benches of one's own. None where the datapath does
    /// not have it.
    pub fn transactions(&self, spec: &AnyOperationSpec) -> Vec<Transaction> {
        let kind = self.datapath.model().kind(spec.name());
        let answered = kind.into_iter().flat_map(|kind| self.answered(spec, kind));
        let numbered = answered.zip(0..);
        numbered.map(|((job, expected), seq)| Transaction { seq, category: 0, job, expected }).collect()
    }

    /// A file of transactions for each spec that the datapath has, `NAME.txt` in a folder: the first of those jobs,
    /// 10,000 at most.
    pub fn files(&self, folder: &Path) -> Vec<(PathBuf, String)> {
        let (model, first) = (self.datapath.model(), Checks { jobs: self.jobs.min(MOST_WRITTEN), ..*self });
        let file = |spec: &AnyOperationSpec| {
            let kind = model.kind(spec.name())?;
            let text = transactions::text(&model, kind, &first.transactions(spec), self.datapath.config());
            Some((folder.join(format!("{}.txt", spec.name())), text))
        };
        self.specs.iter().filter_map(file).collect()
    }

    /// An operation's own jobs, and what the functional model answers.
    fn answered(&self, spec: &AnyOperationSpec, kind: OperationId) -> impl Iterator<Item = (Words, Words)> {
        let mut model = self.datapath.model();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        (0..self.jobs).map(move |_| {
            let job = spec.job(&model, kind, &mut rng);
            let outcome = model.run(&job);
            (job, outcome)
        })
    }

    /// Netlist, cycle-exact and functional model side by side: jobs of all operations, bubbles and stalls. `on_job` is
    /// told how many have left, and says whether to go on.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn against_the_models(&self, on_job: impl FnMut(usize) -> bool) -> Result<Comparison, rtl::Error> {
        let mut netlist = self.datapath.netlist(self.netlist)?;
        let mut traffic = Traffic::random(self.seed);
        Ok(lockstep(&mut netlist, self.datapath.model(), self.mixed_jobs().into_iter(), &mut traffic, on_job))
    }

    /// Checks the emitted text. Verilator, Yosys and slang must report nothing. Then Verilator simulates it with the
    /// assertions of the control bound, and compares every cycle with the cycle-exact model and every result of these
    /// operations with its oracle.
    ///
    /// # Errors
    /// A tool is not installed or reports something, or an assertion fails.
    pub fn in_verilator(&self, folder: &Path) -> Result<Simulated, ToolError> {
        let top = self.netlist.top();
        let mut sources = Sources::write(top, folder)?;
        sources.lint()?;
        sources.add(folder.join("raypath_properties.sv"), &self.netlist.properties().to_string())?;
        let verilated = Verilated::build_sources(&sources.files, top, folder, &Default::default())?;
        let config = self.datapath.config();
        let (jobs, model) = (self.mixed_jobs(), self.datapath.model());
        let stimulus = Stimulus {
            shape: shape(config, self.netlist),
            encoding: PortEncoding::of(config),
            jobs: &jobs,
            answers: Answers::Model(model.clone()),
            traffic: Traffic::random(self.seed),
            resets: Vec::new(),
        };
        let (inputs, expected): (Vec<_>, Vec<_>) =
            stimulus.cycles(top).into_iter().map(|cycle| (cycle.inputs, cycle.expected)).unzip();
        let mut found = Simulated { cycles: inputs.len(), ..Simulated::default() };
        let is_taken = output_ready(top, &inputs);
        // Each with the jobs of its operation that have not left yet.
        let mut runs: Vec<(OracleRun<'_>, _)> = self.oracle_runs().into_iter().map(|run| (run, jobs.iter())).collect();
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
            for (run, waiting) in &mut runs {
                let kind = run.kind;
                if let Some(outcome) = outcome.filter(|outcome| outcome.kind() == kind)
                    && let Some(job) = waiting.find(|job| job.kind() == kind)
                {
                    run.check_answer(&model, job, outcome);
                }
            }
        })?;
        found.reports = runs.into_iter().map(|(run, _)| run.report).collect();
        Ok(found)
    }

    fn oracle_runs(&self) -> Vec<OracleRun<'_>> {
        let model = self.datapath.model();
        let runs = self.specs.iter().filter(|_| model.format() == Format::BINARY32).filter_map(|spec| {
            let (oracle, kind) = (spec.oracle.as_ref()?, model.kind(spec.name())?);
            Some(OracleRun { spec, kind, check: (oracle.check)(), report: OracleReport::default() })
        });
        runs.collect()
    }

    /// Jobs of all operations, half of them of those that are studied.
    fn mixed_jobs(&self) -> Vec<Words> {
        let model = self.datapath.model();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let own: Vec<(OperationId, &AnyOperationSpec)> =
            self.specs.iter().filter_map(|spec| Some((model.kind(spec.name())?, spec))).collect();
        let is_other = |kind: &OperationId| own.iter().all(|(own, _)| own != kind);
        let others: Vec<OperationId> = model.kinds().into_iter().filter(is_other).collect();
        let mut job = || {
            let take_own = others.is_empty() || !own.is_empty() && rng.random_bool(OWN);
            let place = rng.random_range(0..if take_own { own.len().max(1) } else { others.len() });
            Some(match (take_own, own.get(place)) {
                (true, Some((kind, spec))) => spec.job(&model, *kind, &mut rng),
                _ => any_job(&model, *others.get(place)?, &mut rng),
            })
        };
        (0..self.jobs).filter_map(|_| job()).collect()
    }
}

/// An oracle at work.
struct OracleRun<'s> {
    spec: &'s AnyOperationSpec,
    kind: OperationId,
    check: crate::spec::Check,
    report: OracleReport,
}

impl OracleRun<'_> {
    fn check_answer(&mut self, model: &WordModel, job: &Words, outcome: &Words) {
        self.report.jobs += 1;
        if let Err(fault) = (self.check)(&model.all_inputs(job), &model.all_outputs(outcome)) {
            self.report.wrong += 1;
            if self.report.faults.len() < SHOWN {
                self.report.faults.push(format!("job {}: {fault}; {job:?} -> {outcome:?}", self.report.jobs - 1));
            }
        }
    }
}

/// In which cycles the sink takes.
fn output_ready(top: &raypath_hdl::Module, inputs: &[Vec<u64>]) -> Vec<bool> {
    let place = top.inputs().iter().position(|port| port.name == "output_ready_i").map_or(0, |place| place + 1);
    inputs.iter().map(|frame| frame.get(place) == Some(&1)).collect()
}
