//! Datapaths of any operations: their models equal the typed ones, and operations that do not fit are refused.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_cli::prelude::*;
use raypath_float::Format;
use raypath_model::{Functional, Model, ModelCircuit, Soft};
use raypath_ops::{Binary32, Job, JobKind, RayBox, RayTriangle, Rounding, Rules};
use raypath_rtl::{Budget, Config, Error, Lanes, Units};
use raypath_sim::WordModel;
use raypath_sim::jobs::any_job;

bundle! {
    /// A number.
    pub struct One<C> {
        /// The number.
        pub number: Num<C>,
    }
}

bundle! {
    /// The state: the number of the previous job.
    pub struct Kept<C> {
        /// The number.
        pub before: Num<C>,
    }
}

/// Returns the number of the previous job. `LATE` is the stage of the change.
struct Before<const LATE: u32>;

impl<const LATE: u32> Operation for Before<LATE> {
    const NAME: &'static str = "before";
    type Input<C: Circuit> = One<C>;
    type Output<C: Circuit> = One<C>;
    type State<C: Circuit> = Kept<C>;

    fn run<C: Circuit>(&self, c: C, input: One<C>, state: Kept<C>) -> (One<C>, Kept<C>) {
        c.stage(LATE, "changed");
        let next = c.bit(true).select(input.number, state.before);
        (One { number: state.before + c.zero() }, Kept { before: next })
    }
}

/// The erased model has the outcomes of the typed one for any numbers, including sums and resets.
#[test]
fn an_erased_model_equals_the_typed_one() {
    let binary16 = Config::DEFAULT.format(Format::BINARY16);
    same_outcomes(Binary32, Config::DEFAULT);
    same_outcomes(Soft { format: Format::BINARY16 }, binary16);
}

fn same_outcomes<C: ModelCircuit>(circuit: C, config: Config) {
    let mut typed = Functional::<16, 8, C>::over(circuit, Rules::Paper);
    let mut any: WordModel = Datapath::paper(config).model();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let names: Vec<&str> = any.kinds().iter().map(|kind| kind.name()).collect();
    assert_eq!(names, JobKind::ALL.map(JobKind::name));
    for number in 0..4000 {
        let kind = JobKind::ALL[number % 4];
        let job = any_job(&any, any.kind(kind.name()).expect("an operation"), &mut rng);
        assert_eq!(job.kind().opcode(), kind.opcode());
        let typed_job = Job::from_words_in(circuit, kind, job.as_words());
        let (found, expected) = (any.run(&job), typed.run(&typed_job));
        assert_eq!(found.ports(), expected.ports(), "{config}, job {number}: {job:?}");
        if number % 500 == 499 {
            any.reset();
            typed.reset();
        }
    }
}

/// Typed jobs have typed outcomes. An operation that the datapath does not have gives `None`.
#[test]
fn typed_jobs_and_outcomes() {
    let datapath = Datapath::new().with(Before::<4>);
    let mut model = datapath.model();
    let job = model.job_of::<Before<4>>(&One { number: 2.5.into() }).expect("its operation");
    let first = model.run(&job);
    let second = model.run(&job);
    let number = |outcome| model.output_of::<Before<4>>(outcome).map(|one| f32::from(one.number));
    assert_eq!((number(&first), number(&second)), (Some(0.0), Some(2.5)));
    assert!(
        model
            .job_of::<RayBox>(&raypath_ops::RayBoxInput {
                ray: Ray::new([0.0; 3], [1.0; 3], 1.0).expect("a ray"),
                aabb: [Aabb::new([0.0; 3], [1.0; 3]); 4],
            })
            .is_none()
    );
    assert!(model.output_of::<RayTriangle>(&first).is_none());
    // An operation of another datapath has no ports in this one.
    let other = Datapath::paper(Config::DEFAULT).model();
    let foreign = model.job(other.kind("angular").expect("an operation"), |_| u64::MAX);
    assert!(foreign.as_words().is_empty() && model.run(&foreign).as_words().is_empty());
}

/// An operation gets the lowest free opcode. The port is as wide as the largest opcode, and at least as wide as the
/// paper's.
#[test]
fn opcodes_are_assigned() {
    let rules = Rules::Paper;
    let set = Datapath::new()
        .with(RayBox { rules, is_conservative: false })
        .with_opcode(2, RayTriangle { rules, rounding: Rounding::Unit })
        .with(Before::<4>);
    let opcodes: Vec<u64> = set.model().kinds().iter().map(|kind| kind.opcode()).collect();
    assert_eq!(opcodes, [0, 1, 2]);
    let width = |set: &Datapath| set.elaborate().expect("it fits").top().port_width("opcode_i");
    assert_eq!(width(&set), Some(2));
    assert_eq!(width(&Datapath::new().with(Before::<4>)), Some(2));
    assert_eq!(width(&Datapath::paper(Config::DEFAULT).with(Before::<4>)), Some(3));
    assert_eq!(width(&Datapath::new().with_opcode(8, Before::<4>)), Some(4));

    let error = Datapath::new().with(Before::<4>).with(Before::<5>).elaborate().expect_err("a name twice");
    assert_eq!(error.to_string(), "operation before: its name is taken by another operation");
    let error = Datapath::new().with_opcode(64, Before::<4>).elaborate().expect_err("too large");
    assert!(error.to_string().contains("opcode 64 is too large, expected 0 to 63"), "{error}");
    // A model accepts any opcode; a netlist refuses one that is too large.
    let set = Datapath::new().with_opcode(u64::MAX, Before::<4>);
    assert_eq!(set.model().kinds().len(), 1);
    assert!(matches!(set.cycle_model(), Err(Error::Opcode { opcode: u64::MAX, .. })));
}

/// The error of an operation that exceeds the budget of units names the operation and the stage.
#[test]
fn a_budget_limits_the_units() {
    let graphics = Config::DEFAULT.lanes(Lanes::None);
    assert!(Datapath::paper(graphics).within(Budget::TABLE_VIII).elaborate().is_ok());
    let narrow = Budget::by_stage(|_| Units { add: 9, multiply: 99, compare: 99, ..Units::default() });
    let error = Datapath::paper(graphics).within(narrow).elaborate().expect_err("too many units");
    assert!(matches!(error, Error::TooManyUnits { operation: "quadbox", .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("stage 2") && text.contains("24") && text.contains('9') && text.contains("widen"), "{text}");
}

/// An added operation changes neither the outcomes nor the latency of the others.
#[test]
fn an_added_operation_does_not_change_the_others() {
    let datapath = Datapath::paper(Config::DEFAULT).with(Before::<9>);
    let netlist = datapath.elaborate().expect("it fits");
    let mut engine = datapath.netlist(&netlist).expect("a netlist");
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let model = datapath.model();
    let kinds = model.kinds();
    let jobs: Vec<_> = (0..4000).map(|number| any_job(&model, kinds[number % kinds.len()], &mut rng)).collect();
    let mut traffic = raypath_sim::traffic::Traffic::random(3);
    let found = raypath_sim::lockstep::lockstep(&mut engine, model, jobs.into_iter(), &mut traffic, |_| true);
    assert_eq!((found.jobs, found.different), (4000, 0), "{:?}", found.differences);
    assert_eq!(netlist.latency(), 12);
}
