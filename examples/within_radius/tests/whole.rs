//! The generated files, the checks and the cost of the operation.

use raypath::ops::{RayBox, RayTriangle, Rounding, Rules};
use raypath::oracle::{AnyOperationSpec, Checks, add_operation};
use raypath::prelude::*;
use raypath::rtl::{Config, Lanes};
use raypath::sim::transactions::read;
use raypath::workbench::{Arguments, Cost, run};
use within_radius::nearest::{Distance, NearestSoFar};
use within_radius::{Near, Points, WithinRadius, check, spec, stimulus};

const NAME: &str = "within_radius";

/// Declares an operation of points with a name.
macro_rules! operation {
    ($operation:ident = $name:literal, $output:ty, |$c:ident, $points:ident| $body:expr) => {
        struct $operation;

        impl Operation for $operation {
            const NAME: &'static str = $name;
            type Input<C: Circuit> = Points<C>;
            type Output<C: Circuit> = $output;
            type State<C: Circuit> = ();

            fn run<C: Circuit>(&self, $c: C, $points: Points<C>, _: ()) -> ($output, ()) {
                ($body, ())
            }
        }
    };
}

fn arguments(folder: &std::path::Path, more: &[&str]) -> Arguments {
    let out = folder.display().to_string();
    let line = ["within_radius", "--quick", "--out", &out].into_iter().chain(more.iter().copied());
    clap::Parser::parse_from(line)
}

#[test]
fn the_function_has_at_most_50_lines() {
    let text = include_str!("../src/lib.rs");
    let operation = text.split("// ANCHOR: operation").nth(1).and_then(|rest| rest.split("// ANCHOR_END").next());
    let operation = operation.expect("the operation is between its anchors").trim();
    let lines = operation.lines().filter(|line| !line.contains("// ANCHOR")).count();
    assert!(lines <= 50, "{lines} lines");
}

/// The operation shares all units with the paper's operations, and adds only multiplexers and registers.
#[test]
fn it_adds_no_unit() {
    let datapath = Datapath::paper(Default::default()).with(WithinRadius);
    let cost = Cost::of(&datapath, NAME).expect("it fits");
    assert_eq!(cost.added_units(), Default::default());
    assert_eq!((cost.without.latency, cost.with.latency), (12, 12));
    assert!(cost.with.flip_flops > cost.without.flip_flops);
}

/// The linters report nothing, and Verilator agrees with the cycle-exact model and the oracle.
#[test]
fn verilator_agrees_with_the_oracle() {
    let datapath = Datapath::paper(Config::DEFAULT.lanes(Lanes::Two)).with(WithinRadius);
    let netlist = datapath.elaborate().expect("it fits");
    let specs = [AnyOperationSpec::from(spec())];
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 3, jobs: 5000 };
    let folder = tempfile::tempdir().expect("a folder");
    let found = checks.in_verilator(folder.path()).expect("no report from the tools");
    assert_eq!((found.different, found.reports[0].wrong), (0, 0), "{found:?}");
    assert!(found.reports[0].jobs > 2000, "{found:?}");
}

/// With an oracle that rejects every result, the command fails.
#[test]
fn a_wrong_answer_is_found() {
    let spec =
        OperationSpec::of(WithinRadius).oracle("an oracle that rejects everything", |_, _| Err("no".to_string()));
    let folder = tempfile::tempdir().expect("a folder");
    let mut out = Vec::new();
    let error = run(&spec.into(), &arguments(folder.path(), &["--jobs", "100"]), &mut out).expect_err("wrong answers");
    assert_eq!(error.to_string(), "100 of 100 results of within_radius are wrong");
}

/// The area of the operation, measured in binary16, which is fast to synthesise.
#[test]
fn it_has_an_area() {
    let half: raypath::rtl::Preset = "half".parse().expect("a preset");
    let datapath = Datapath::paper(half.config).with(WithinRadius);
    let cache = std::env::temp_dir().join("raypath-within-radius");
    let cost = Cost::of(&datapath, NAME).expect("it fits").measured(&datapath, NAME, &cache).expect("a measurement");
    let added = cost.added_area().expect("an area");
    let share = added / cost.without.area.expect("an area").0;
    assert!((0.001..0.2).contains(&share), "{}", cost.table());
}

#[test]
fn the_command_writes_files_and_reports_results() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut out = Vec::new();
    run(&spec().into(), &arguments(folder.path(), &["--jobs", "500"]), &mut out).expect("all is well");
    let out = String::from_utf8(out).expect("text");
    assert!(out.contains("Oracle of within_radius (f64): 0 of 500 random jobs have wrong results."), "{out}");
    assert!(out.contains("500 jobs of all operations") && out.contains(" 0 mismatches"), "{out}");
    for file in ["raypath.sv", "raypath.f", "pipeline.svg", "rtl/raypath_stage_2.sv", "within_radius.txt"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    let text = std::fs::read_to_string(folder.path().join("raypath.sv")).expect("a file");
    assert!(text.contains("input  logic [2:0]  opcode_i") || text.contains("[2:0]"), "five operations need three bits");
    assert!(text.contains("point_3_z_i") && text.contains("squared_distance_0_o"));
    // The file has the jobs that were compared with the oracle.
    let datapath = Datapath::paper(Default::default()).with(WithinRadius);
    let (netlist, specs) = (datapath.elaborate().expect("it fits"), [AnyOperationSpec::from(spec())]);
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 1, jobs: 500 };
    let path = folder.path().join("within_radius.txt");
    let recorded = read(&path, None, &datapath.model(), Default::default()).expect("transactions");
    assert_eq!(recorded, checks.transactions(&specs[0]));
    assert_eq!(recorded.len(), 500);
}

/// The automatically staged operation gives the same results with at most as many registers.
#[test]
fn a_first_cut_needs_no_stages() {
    use within_radius::first_cut::FirstCut;
    let auto = Datapath::paper(Default::default()).with(FirstCut);
    let cost = Cost::of(&auto, "first_cut").expect("it fits");
    assert_eq!((cost.added_units(), cost.with.latency), (Default::default(), 12));
    let by_hand = Cost::of(&Datapath::paper(Default::default()).with(WithinRadius), NAME).expect("it fits");
    assert!(cost.with.flip_flops <= by_hand.with.flip_flops, "{cost:?}, by hand {by_hand:?}");

    let netlist = auto.elaborate().expect("it fits");
    let oracle = OperationSpec::of(FirstCut).oracle("the operation by hand", |job, answer| {
        let (expected, ()) = WithinRadius.run(Binary32, *job, ());
        if *answer == expected { Ok(()) } else { Err(format!("expected {expected:?}")) }
    });
    let specs = [AnyOperationSpec::from(oracle)];
    let checks = Checks { datapath: &auto, netlist: &netlist, specs: &specs, seed: 7, jobs: 3000 };
    assert_eq!(checks.against_the_oracles()[0].wrong, 0);
    assert_eq!(checks.against_the_models(|_| true).expect("a netlist").different, 0);
}

/// The models in Rust, as the documentation shows them.
#[test]
fn the_models_are_a_few_lines() {
    let rules = Rules::Paper;
    // ANCHOR: models
    // Hardware: SystemVerilog, schedule, units, registers.
    let datapath = Datapath::new()
        .with(RayBox { rules, is_conservative: false })
        .with(RayTriangle { rules, rounding: Rounding::Unit })
        .with(WithinRadius);
    let netlist = datapath.elaborate().expect("it fits");

    // The function itself, at native speed, for points at distances 1 to 4 and a radius of 2.5.
    let point = [1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0].into());
    let points = Points { query: [0.0; 3].into(), radius: 2.5.into(), point };
    let (near, ()) = WithinRadius.run(Binary32, points, ());
    assert_eq!(near.is_near.to_array(), [true, true, false, false]);

    // The functional model, which computes jobs of any operation.
    let mut functional = datapath.model();
    let job = functional.job_of::<WithinRadius>(&points).expect("one of its operations");
    let outcome = functional.run(&job);
    assert_eq!(functional.output_of::<WithinRadius>(&outcome), Some(near));

    // The cycle-exact model, which adds the timing.
    let mut cycles = datapath.cycle_model().expect("it fits");
    assert!(cycles.cycle(Some(&job), true).accepted);
    assert_eq!(1 + cycles.idle(100), u64::from(netlist.latency()));
    assert_eq!(cycles.output(), Some(&outcome));
    // ANCHOR_END: models
    assert_eq!(netlist.latency(), 12);
}

#[test]
fn the_oracle_rejects_nan() {
    operation!(NoNumber = "no_number", Near<C>, |c, _points| {
        c.stage(2, "∞ - ∞");
        let none = c.infinity() - c.infinity();
        Near { is_near: Flags([c.bit(false); 4]), squared_distance: [none; 4] }
    });
    let spec: AnyOperationSpec = OperationSpec::of(NoNumber).stimulus(stimulus).oracle("f64", check).into();
    let datapath = Datapath::new().with_any(spec.operation());
    let (netlist, specs) = (datapath.elaborate().expect("it fits"), [spec]);
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 1, jobs: 100 };
    assert_eq!(checks.against_the_oracles()[0].wrong, 100);
}

/// The report does not name an operation that adds no units as a cause of units.
#[test]
fn it_is_not_a_cause_of_units() {
    let config = Default::default();
    let netlist = Datapath::paper(config).with(WithinRadius).elaborate().expect("it fits");
    for step in 0..netlist.steps().count() {
        let causes = raypath::rtl::report::tables::difference(&netlist, config, step);
        assert!(!causes.contains(&"operations beside the paper's"), "step {step}: {causes:?}");
    }
}

#[path = "../../../crates/raypath-cli/src/commands/new_operation/template.rs"]
#[allow(dead_code)] // its `main`
mod template;

/// What `raypath new-operation` writes.
#[test]
fn the_template_is_right() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut out = Vec::new();
    run(&template::spec().into(), &arguments(folder.path(), &["--jobs", "500"]), &mut out).expect("all is well");
    let out = String::from_utf8(out).expect("text");
    assert!(out.contains("Oracle of point_plane (f64): 0 of 500 random jobs have wrong results."), "{out}");
}

operation!(BuiltIn = "quadbox", Near<C>, |c, points| WithinRadius.run(c, points, ()).0);
operation!(Capitals = "MyOp", Near<C>, |c, points| WithinRadius.run(c, points, ()).0);
// An operation whose output has no name.
operation!(Bare = "bare", Num<C>, |_c, points| points.radius);

#[test]
fn operations_that_a_datapath_cannot_have_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = |spec: AnyOperationSpec| {
        run(&spec, &arguments(folder.path(), &[]), &mut Vec::new()).expect_err("a wrong name").to_string()
    };
    assert_eq!(error(OperationSpec::of(BuiltIn).into()), "operation quadbox: its name is taken by another operation");
    let expected = "its name is not in snake_case, expected small letters, digits and _, the first a letter";
    assert_eq!(error(OperationSpec::of(Capitals).into()), format!("operation MyOp: {expected}"));
    assert!(error(OperationSpec::of(Bare).into()).starts_with("operation bare: its output is a bare value"));
}

/// The state follows the jobs through the model, and through the netlist with stalls.
#[test]
fn state_stays_from_job_to_job() {
    let datapath = Datapath::new().with(NearestSoFar);
    let mut model = datapath.model();
    let mut nearest = |distance: f32, is_first: bool| {
        let job = Distance { distance: distance.into(), is_first: is_first.into() };
        let job = model.job_of::<NearestSoFar>(&job).expect("its operation");
        let outcome = model.run(&job);
        f32::from(model.output_of::<NearestSoFar>(&outcome).expect("its outcome").nearest)
    };
    let jobs = [(5.0, true), (7.0, false), (3.0, false), (4.0, false), (9.0, true), (8.0, false)];
    assert_eq!(jobs.map(|(distance, is_first)| nearest(distance, is_first)), [5.0, 5.0, 3.0, 3.0, 9.0, 8.0]);
    let netlist = datapath.elaborate().expect("it fits");
    let specs = [AnyOperationSpec::from(OperationSpec::of(NearestSoFar))];
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 1, jobs: 500 };
    assert_eq!(checks.against_the_models(|_| true).expect("a netlist").different, 0);
}

/// A command of raypath, run by the crate's program, finds the operation by its name.
#[test]
fn commands_of_raypath_take_the_operation() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str| {
        let program = std::process::Command::new(env!("CARGO_BIN_EXE_within_radius"))
            .args(["generate", "--jobs", "200", "--with", name, "--out"])
            .arg(folder.path())
            .output()
            .expect("the program");
        (program.status.code(), String::from_utf8_lossy(&[program.stdout, program.stderr].concat()).into_owned())
    };
    let (code, text) = run(NAME);
    assert!(code == Some(0) && text.contains("Oracle of within_radius"), "{code:?} {text}");
    let (code, text) = run("nothing");
    assert!(code == Some(2) && text.contains("sphere or within_radius"), "{code:?} {text}");
    let taken = add_operation(OperationSpec::of(RayBox { rules: Default::default(), is_conservative: false }))
        .expect_err("a name that is taken");
    assert!(taken.contains("there is an operation 'quadbox'"), "{taken}");
}
