//! The operations that get faults, with jobs and the outcomes that the exact oracle expects.

use super::evaluate::{Dataflow, Jobs, Values};
use super::faults::{Fault, faults};
use super::jobs::{STREAMS, jobs};
use raypath_model::WordModel;
use raypath_ops::operations::NAMES;
use raypath_ops::{BoxBits, Culling, PortValue, Rounding, Rules};
use raypath_rtl::{Accumulators, Config, Lanes};
use raypath_verify_datapath::datapaths::TestedDatapath;
use raypath_verify_datapath::oracle::Oracle;

/// An operation, and the jobs that its faults run.
pub struct FaultyOperation<'p> {
    pub name: String,
    pub planned: &'p Planned,
    pub jobs: Jobs,
    /// The values without a fault. The exact oracle expects their outcomes, so that any other outcome is wrong.
    pub values: Values,
    /// Why the oracle refuses a job without a fault. It must not.
    pub refused: Option<String>,
}

/// The dataflow of an operation of a datapath, and its faults.
pub struct Planned {
    pub tested: TestedDatapath,
    pub flow: Dataflow,
    pub faults: Vec<Fault>,
}

/// The oracle of a datapath, with a model that has its ports.
pub type OracleOf<'a> = &'a (dyn Fn(&TestedDatapath, &WordModel) -> Oracle + Sync);

/// The oracle without a mistake.
pub fn exact(tested: &TestedDatapath, model: &WordModel) -> Oracle {
    Oracle::new(tested.config.semantics, model)
}

/// Datapaths that together have all operations in binary32: all rules and both roundings, each number of lanes, all
/// features, and the added operations.
fn datapaths() -> Vec<TestedDatapath> {
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let features = small.barycentrics(true).facing(true).range(true).conservative(true).exception_flags(true);
    let configs = [
        small.rules(Rules::Chisel),
        small.rules(Rules::Bounds(BoxBits::DEFAULT)),
        small.rounding(Rounding::Sum),
        features.culling(Culling::None).accumulators(Accumulators::Four),
        small.range(true).culling(Culling::Front),
    ];
    let lanes = Lanes::ALL.iter().map(|&lanes| Config::DEFAULT.lanes(lanes));
    let mut all: Vec<TestedDatapath> = lanes.chain(configs).map(TestedDatapath::from).collect();
    all.push(TestedDatapath::with(Config::DEFAULT.lanes(Lanes::None), &NAMES));
    all
}

/// The operations of these datapaths, each dataflow once.
pub fn plan() -> Vec<Planned> {
    let mut all: Vec<Planned> = Vec::new();
    for tested in datapaths() {
        for graph in tested.datapath().dataflows() {
            let flow = Dataflow { graph, inverted: None };
            if all.iter().all(|planned| planned.flow != flow) {
                all.push(Planned { tested: tested.clone(), faults: faults(&flow), flow });
            }
        }
    }
    all
}

impl Planned {
    /// The subject with about `count` jobs; `oracle` makes its oracle.
    pub fn subject(&self, count: usize, seed: u64, oracle: OracleOf<'_>) -> FaultyOperation<'_> {
        let Self { tested, flow, .. } = self;
        let (model, options, operation) = (tested.datapath().model(), tested.options(), flow.graph.name);
        let name = if options.is_empty() { operation.to_string() } else { format!("{operation} {options}") };
        let jobs = match model.kind(operation) {
            Some(kind) => jobs(&model, kind, count.div_ceil(STREAMS), seed),
            None => Jobs::default(),
        };
        let values = Values::of(flow, &jobs);
        let refused = (0..STREAMS).find_map(|stream| {
            let mut oracle = oracle(tested, &model);
            (0..jobs.steps.len()).find_map(|step| self.refusal(&model, &mut oracle, &jobs, &values, [step, stream]))
        });
        let refused = refused.map(|refused| format!("{name}: without a fault refused by the oracle: {refused}"));
        FaultyOperation { name, planned: self, jobs, values, refused }
    }

    /// Why the oracle refuses a job of a stream, if it does.
    fn refusal(
        &self,
        model: &WordModel,
        oracle: &mut Oracle,
        jobs: &Jobs,
        values: &Values,
        at: [usize; 2],
    ) -> Option<String> {
        let job = model.job_of_words(model.kind(self.flow.graph.name)?, &jobs.steps[at[0]][at[1]]);
        let expected = match oracle.run(&job) {
            Ok(expected) => expected.ports(),
            Err(problem) => return Some(problem),
        };
        let found = |port: &str| values.word(&self.flow, port, at);
        // The elaborator adds these two to any operation.
        let is_own = |port: &&PortValue| !["tag", "exception_flags"].contains(&port.name.as_str());
        let wrong = expected.iter().filter(is_own).find(|port| found(&port.name) != Some(port.bits))?;
        Some(format!("{}: {:x?}, expected {:x}, for {job:?}", wrong.name, found(&wrong.name), wrong.bits))
    }
}
