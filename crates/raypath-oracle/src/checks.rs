//! Checks of the operations of a datapath against oracles, models, and the SystemVerilog in Verilator.

use crate::spec::{AnyOperationSpec, Check, Source};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::Model;
use raypath_rtl as rtl;
use raypath_sim::Datapath;
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Stimulus};
use raypath_sim::jobs::any_job;
use raypath_sim::lockstep::{Comparison, lockstep};
use raypath_sim::traffic::Traffic;
use raypath_sim::transactions::{self, Transaction};
use raypath_sim::{OperationId, Words};
use raypath_tools::{Sources, ToolError, Verilated};
use std::path::{Path, PathBuf};

/// The checks of some operations of a datapath, reproducible by `seed`.
pub struct Checks<'d> {
    /// The datapath.
    pub datapath: &'d Datapath,
    /// The elaborated datapath.
    pub netlist: &'d rtl::DatapathNetlist,
    /// The specifications of the operations to check.
    pub specs: &'d [AnyOperationSpec],
    /// The seed of jobs and traffic.
    pub seed: u64,
    /// The number of jobs of each check.
    pub jobs: usize,
}

/// The result of a comparison of outcomes with an oracle.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OracleReport {
    /// The number of jobs.
    pub jobs: usize,
    /// The number of wrong outcomes.
    pub wrong: usize,
    /// Messages about the first of them.
    pub faults: Vec<String>,
}

/// The result of a simulation in Verilator.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Simulated {
    /// The number of cycles.
    pub cycles: usize,
    /// The number of cycles in which an output port differed from the cycle-exact model.
    pub different: usize,
    /// Messages about the first of them.
    pub faults: Vec<String>,
    /// The comparison of the outcomes with the oracle of each specification that has one.
    pub reports: Vec<OracleReport>,
}

const MAX_MESSAGES: usize = 5;
/// The maximum number of transactions in a file.
const MAX_WRITTEN: usize = 10_000;
/// The probability of a reset in a cycle.
const RESETS: f64 = 0.0005;
/// The fraction of mixed jobs that belong to the operations to check.
const SPECIFIED: f64 = 0.5;

impl Checks<'_> {
    /// Compares outcomes of the functional model with the oracle of each specification that has one for the datapath's
    /// format.
    pub fn against_the_oracles(&self) -> Vec<OracleReport> {
        let reports = self.oracle_runs().into_iter().map(|mut run| {
            self.outcomes(run.spec, run.kind).for_each(|(job, outcome)| run.check(&job, &outcome));
            run.report
        });
        reports.collect()
    }

    /// The jobs of [`against_the_oracles`](Self::against_the_oracles) for an operation of the datapath, with outcomes.
    pub fn transactions(&self, spec: &AnyOperationSpec) -> Vec<Transaction> {
        let kind = self.datapath.model().kind(spec.name());
        let outcomes = kind.into_iter().flat_map(|kind| self.outcomes(spec, kind));
        outcomes.zip(0..).map(|((job, expected), seq)| Transaction { seq, category: 0, job, expected }).collect()
    }

    /// The paths and texts of transaction files, `NAME.txt` in a folder, one for each specified operation that the
    /// datapath has. A file has at most 10,000 [`transactions`](Self::transactions).
    pub fn files(&self, folder: &Path) -> Vec<(PathBuf, String)> {
        let (model, first) = (self.datapath.model(), Checks { jobs: self.jobs.min(MAX_WRITTEN), ..*self });
        let file = |spec: &AnyOperationSpec| {
            let kind = model.kind(spec.name())?;
            let text = transactions::text(&model, kind, &first.transactions(spec), self.datapath.config());
            Some((folder.join(format!("{}.txt", spec.name())), text))
        };
        self.specs.iter().filter_map(file).collect()
    }

    /// Random jobs of an operation, with the outcomes of the functional model.
    fn outcomes(&self, spec: &AnyOperationSpec, kind: OperationId) -> impl Iterator<Item = (Words, Words)> {
        let mut model = self.datapath.model();
        spec.source(&model, kind, self.seed).take(self.jobs).map(move |job| {
            let outcome = model.run(&job);
            (job, outcome)
        })
    }

    /// Compares the netlist with the models in every cycle, for jobs of all operations with bubbles, stalls and resets,
    /// and any values in data registers at the start.
    /// `on_job` gets the number of jobs so far; the comparison ends when it returns false.
    ///
    /// # Errors
    /// A netlist that cannot be compiled.
    pub fn against_the_models(&self, on_job: impl FnMut(usize) -> bool) -> Result<Comparison, rtl::Error> {
        let mut netlist = self.datapath.netlist(self.netlist)?;
        netlist.restart_randomly(self.seed);
        let mut traffic = Traffic::random(self.seed).with_resets(RESETS);
        Ok(lockstep(&mut netlist, self.datapath.model(), self.mixed_jobs().into_iter(), &mut traffic, on_job))
    }

    /// Checks the SystemVerilog. Lints it with Verilator, Yosys and slang, which must report nothing. Then simulates it
    /// in Verilator with the assertions about the control, with resets and any initial state, and compares every cycle
    /// with the cycle-exact model and every outcome of the operations with its oracle.
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
            resets: (1..=self.jobs / 1000).map(|n| n * 1400 + n * n).collect(),
        };
        let cycles = stimulus.cycles(top);
        let mut found = Simulated { cycles: cycles.len(), ..Simulated::default() };
        let ready = top.inputs().iter().position(|port| port.name == "output_ready_i").map_or(0, |index| index + 1);
        let mut runs = self.oracle_runs();
        verilated.run_randomly(
            self.seed as u32,
            cycles.iter().map(|cycle| cycle.inputs.clone()),
            |number, values| {
                let Some(cycle) = cycles.get(number) else { return };
                if cycle.inputs.first() == Some(&0) {
                    runs.iter_mut().for_each(|run| run.reset(self.datapath));
                }
                let Some(expected) = &cycle.expected else { return };
                if let Some(fault) = expected.fault(top, values) {
                    found.different += 1;
                    if found.faults.len() < MAX_MESSAGES {
                        found.faults.push(format!("cycle {number}: {fault}"));
                    }
                }
                // The ports show this outcome, unless a fault was found above.
                if let Some(outcome) = expected.output.as_ref().filter(|_| cycle.inputs.get(ready) == Some(&1))
                    && let Some(job) = cycle.job.and_then(|job| jobs.get(job))
                {
                    let own = runs.iter_mut().filter(|run| run.kind == outcome.kind());
                    own.for_each(|run| run.check(job, outcome));
                }
            },
        )?;
        found.reports = runs.into_iter().map(|run| run.report).collect();
        Ok(found)
    }

    fn oracle_runs(&self) -> Vec<OracleRun<'_>> {
        let model = self.datapath.model();
        let runs = self.specs.iter().filter_map(|spec| {
            let (kind, oracle) = (model.kind(spec.name())?, spec.check(self.datapath)?);
            Some(OracleRun { spec, kind, oracle, report: OracleReport::default() })
        });
        runs.collect()
    }

    /// Random jobs of all operations, half of them of the specified ones.
    fn mixed_jobs(&self) -> Vec<Words> {
        let model = self.datapath.model();
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut own: Vec<(OperationId, Source)> = Vec::new();
        for (spec, seed) in self.specs.iter().zip(self.seed..) {
            own.extend(model.kind(spec.name()).map(|kind| (kind, spec.source(&model, kind, seed))));
        }
        let is_other = |kind: &OperationId| own.iter().all(|(own, _)| own != kind);
        let others: Vec<OperationId> = model.kinds().into_iter().filter(is_other).collect();
        let mut job = || {
            let take_own = others.is_empty() || !own.is_empty() && rng.random_bool(SPECIFIED);
            let index = rng.random_range(0..if take_own { own.len().max(1) } else { others.len() });
            match own.get_mut(index) {
                Some((_, source)) if take_own => source.next(),
                _ => Some(any_job(&model, *others.get(index)?, &mut rng)),
            }
        };
        (0..self.jobs).filter_map(|_| job()).collect()
    }
}

struct OracleRun<'s> {
    spec: &'s AnyOperationSpec,
    kind: OperationId,
    oracle: Check,
    report: OracleReport,
}

impl OracleRun<'_> {
    /// The oracle's state after a reset.
    fn reset(&mut self, datapath: &Datapath) {
        self.oracle = self.spec.check(datapath).unwrap_or_else(|| Box::new(|_, _| Ok(())));
    }

    fn check(&mut self, job: &Words, outcome: &Words) {
        self.report.jobs += 1;
        if let Err(fault) = (self.oracle)(job, outcome) {
            self.report.wrong += 1;
            if self.report.faults.len() < MAX_MESSAGES {
                self.report.faults.push(format!("job {}: {fault}; {job:?} -> {outcome:?}", self.report.jobs - 1));
            }
        }
    }
}
