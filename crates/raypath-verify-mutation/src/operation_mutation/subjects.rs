//! The operations that get faults, with jobs and the outcomes that the exact oracle expects.

use super::evaluate::{Jobs, Values};
use super::faults::{Fault, faults};
use super::graph::Graph;
use super::jobs::{STREAMS, jobs};
use raypath_float::Format;
use raypath_model::WordModel;
use raypath_ops::operations::{key_compare, octbox, point_in_box, quantised_box, sphere};
use raypath_ops::{BoxBits, Culling, Operation, Rounding, Rules};
use raypath_rtl::{Accumulators, Config, Lanes, OperationVisitor};
use raypath_tools::pool;
use raypath_verify::{Error, Level, Request};
use raypath_verify_datapath::oracle::Oracle;
use raypath_verify_datapath::subjects::{self, Subject as Tested};
use std::convert::Infallible;

/// An operation, and the jobs that its faults run.
pub struct Subject {
    pub name: String,
    pub graph: Graph,
    pub faults: Vec<Fault>,
    pub jobs: Jobs,
    /// The values without a fault. The exact oracle expects their outcomes, so that any other outcome is wrong.
    pub values: Values,
    /// Why the oracle refuses a job without a fault. It must not.
    pub refused: Option<String>,
}

/// The operations of a level, with about `count` jobs each; `oracle` makes their oracles.
///
/// # Errors
/// The user stops the work.
pub fn all(
    request: &mut Request<'_>,
    count: usize,
    oracle: &(dyn Fn(&Tested, &WordModel) -> Oracle + Sync),
) -> Result<Vec<Subject>, Error> {
    let mut plan = Plan::default();
    tested(request.level).iter().for_each(|tested| plan.add_all(tested));
    let seed = request.seed;
    let subject = |planned: &Planned, _: &_| Ok(Some(planned.subject(count, seed, oracle)));
    let subjects = pool::map::<_, _, Error>(&plan.0, pool::ALL_CORES, request.proceed, subject)?;
    Ok(subjects.into_iter().flatten().collect())
}

/// The datapaths whose operations are tested: each operation with its features and rules at level regression, otherwise
/// all of the campaigns in binary32.
fn tested(level: Level) -> Vec<Tested> {
    let (all, small) = (Config::DEFAULT, Config::DEFAULT.lanes(Lanes::None));
    let features = small.facing(true).barycentrics(true);
    let configs = [
        all,
        all.rounding(Rounding::Sum),
        all.accumulators(Accumulators::Four),
        small.rules(Rules::Bounds(BoxBits::DEFAULT)),
        small.conservative(true),
        small.rules(Rules::Chisel),
        features.range(true),
        features.culling(Culling::Front),
        features.culling(Culling::None).range(true),
        features.culling(Culling::None).range(true).rules(Rules::Chisel),
    ];
    let mut tested: Vec<Tested> = configs.map(Tested::from).into();
    let added = ["key_compare", "octbox", "point_in_box", "quantised_box", "sphere"];
    tested.extend(added.map(|name| Tested::with(small, &[name])));
    if level > Level::Regression {
        let campaigns = subjects::all().into_iter();
        tested.extend(campaigns.filter(|tested| tested.config.semantics.format == Format::BINARY32));
    }
    tested
}

/// The operations that get faults, each dataflow once.
#[derive(Default)]
struct Plan(Vec<Planned>);

struct Planned {
    operation: &'static str,
    tested: Tested,
    graph: Graph,
}

/// The datapath whose operations are added to a plan.
struct Visit<'p>(&'p mut Plan, &'p Tested);

impl OperationVisitor for Visit<'_> {
    type Error = Infallible;

    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, _opcode: u64) -> Result<(), Infallible> {
        self.0.add(&operation, self.1);
        Ok(())
    }
}

impl Plan {
    fn add_all(&mut self, tested: &Tested) {
        let Ok(()) = tested.config.semantics.operations(&mut Visit(self, tested));
        for name in &tested.added {
            match name.as_str() {
                "key_compare" => self.add(&key_compare::KeyCompare, tested),
                "octbox" => self.add(&octbox::Octbox, tested),
                "point_in_box" => self.add(&point_in_box::PointInBox, tested),
                "quantised_box" => self.add(&quantised_box::QuantisedBox, tested),
                "sphere" => self.add(&sphere::Sphere, tested),
                other => unreachable!("no operation is called {other}"),
            }
        }
    }

    fn add<O: Operation>(&mut self, operation: &O, tested: &Tested) {
        let graph = Graph::of(operation);
        if self.0.iter().all(|planned| planned.graph != graph) {
            self.0.push(Planned { operation: O::NAME, tested: tested.clone(), graph });
        }
    }
}

impl Planned {
    fn subject(&self, count: usize, seed: u64, oracle: &dyn Fn(&Tested, &WordModel) -> Oracle) -> Subject {
        let Self { operation, tested, graph } = self;
        let (model, options) = (tested.datapath().model(), tested.options());
        let name = if options.is_empty() { operation.to_string() } else { format!("{operation} {options}") };
        let jobs = match model.kind(operation) {
            Some(kind) => jobs(&model, kind, count.div_ceil(STREAMS), seed),
            None => Jobs::default(),
        };
        let values = Values::of(graph, &jobs);
        let refused = (0..STREAMS).find_map(|stream| {
            let mut oracle = oracle(tested, &model);
            (0..jobs.steps.len()).find_map(|step| self.refusal(&model, &mut oracle, &jobs, &values, [step, stream]))
        });
        Subject { name, graph: graph.clone(), faults: faults(graph), jobs, values, refused }
    }

    /// Why the oracle refuses a job of a stream, if it does.
    fn refusal(
        &self,
        model: &WordModel,
        oracle: &mut Oracle,
        jobs: &Jobs,
        values: &Values,
        [step, stream]: [usize; 2],
    ) -> Option<String> {
        let words = &jobs.steps[step][stream];
        let kind = model.kind(self.operation)?;
        let job = model.job_of_words(kind, &model.present_inputs(kind, words.clone()));
        let found = values.outcome(&self.graph, step, stream);
        match oracle.run(&job).map(|outcome| model.all_outputs(&outcome)) {
            Ok(expected) if expected == found => None,
            Ok(expected) => Some(format!("{found:x?}, expected {expected:x?}, for {job:?}")),
            Err(problem) => Some(problem),
        }
    }
}
