//! Proofs of the control: they hold for the design, and the same commands find deliberate faults.

use raypath_rtl::{Config, Control, Datapath, Lanes, UnitLatency};
use raypath_verify::control::{
    CheckResult, ModelChecker, ModuleTexts, TextFault, never_leaves, problems, structural_faults,
};
use std::sync::atomic::AtomicBool;

static GO: AtomicBool = AtomicBool::new(false);

fn config(control: Control) -> Config {
    Config::DEFAULT.control(control).lanes(Lanes::Two).unit_latency(UnitLatency::Two)
}

/// Checks the problem that begins with `name`: it holds without the fault and fails with it.
fn assert_found(config: Config, name: &str, fault: TextFault) {
    let checker = ModelChecker::find().expect("pyosys");
    let datapath = Datapath::new(config).expect("a datapath");
    let whole = ModuleTexts::new(datapath.top()).expect("text");
    let mut faulty = whole.clone();
    assert!(faulty.insert(fault), "{fault:?}");
    for (texts, expected) in [(whole, CheckResult::Holds), (faulty, CheckResult::Fails)] {
        let all = problems(&datapath, config, &texts);
        let problem = all.iter().find(|problem| problem.name.starts_with(name)).expect("a problem");
        assert_eq!(
            checker.check(problem, &GO).expect("a verdict"),
            Some(expected),
            "{config}: {}, {fault:?}",
            problem.name
        );
    }
}

#[test]
fn a_job_that_arrives_without_ready_is_found() {
    let fault = TextFault { module: "raypath_skid", from: "valid_i & spare_empty_q", to: "valid_i" };
    assert_found(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn a_register_that_loads_while_it_waits_is_found() {
    let fault = TextFault { module: "raypath_skid", from: "= leaves & refill", to: "= refill" };
    assert_found(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn a_ready_that_is_the_sinks_is_found() {
    let fault =
        TextFault { module: "raypath_skid", from: "assign ready_o = spare_empty_q", to: "assign ready_o = ready_i" };
    assert_found(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn an_accumulator_that_is_written_while_it_waits_is_found() {
    let fault =
        TextFault { module: "raypath_stage_9_2", from: "= advance & (data_i.opcode", to: "= valid_i & (data_i.opcode" };
    assert_found(config(Control::Skid), "raypath_stage_9_2: ", fault);
}

#[test]
fn a_credit_too_many_is_found() {
    let fault = TextFault { module: "raypath_credit", from: "available_q <= |count_d", to: "available_q <= 1'b1" };
    assert_found(config(Control::Credit), "raypath_credit: ", fault);
}

/// Checks only that the problem fails with the fault; the item proves the design.
fn assert_refuted(config: Config, name: &str, fault: TextFault) {
    let checker = ModelChecker::find().expect("pyosys");
    let datapath = Datapath::new(config).expect("a datapath");
    let mut texts = ModuleTexts::new(datapath.top()).expect("text");
    assert!(texts.insert(fault), "{fault:?}");
    let all = problems(&datapath, config, &texts);
    let problem = all.iter().find(|problem| problem.name.starts_with(name)).expect("a problem");
    assert_eq!(
        checker.check(problem, &GO).expect("a verdict"),
        Some(CheckResult::Fails),
        "{}, {fault:?}",
        problem.name
    );
}

#[test]
fn a_job_that_overtakes_those_that_wait_at_the_exit_is_found() {
    let one = config(Control::Credit).unit_latency(UnitLatency::One);
    let fault = TextFault { module: "raypath_exit", from: "valid_i & (stored | ~leaves)", to: "valid_i & ~leaves" };
    assert_refuted(one, "raypath_stage_11: raypath_order", fault);
}

#[test]
fn an_output_that_changes_while_it_is_stalled_is_found() {
    let one = config(Control::Credit).unit_latency(UnitLatency::One);
    let fault = TextFault { module: "raypath_exit", from: "= leaves & (stored | valid_i)", to: "= stored | valid_i" };
    assert_refuted(one, "raypath: raypath_stall", fault);
}

#[test]
fn a_beat_that_reads_before_the_one_before_has_written_is_found() {
    let fault = TextFault { module: "raypath_stage_9_1", from: "= angular_pending_q & is_angular", to: "= 1'b0" };
    assert_refuted(config(Control::Skid), "raypath: raypath_stall", fault);
}

#[test]
fn the_structure_is_as_it_must_be_and_jobs_leave() {
    let checker = ModelChecker::find().expect("pyosys");
    for &control in Control::ALL {
        let config = config(control);
        let datapath = Datapath::new(config).expect("a datapath");
        assert_eq!(structural_faults(&datapath, config).expect("no loop"), Vec::<String>::new());
        let texts = ModuleTexts::new(datapath.top()).expect("text");
        let mut never = never_leaves(&datapath, config, &texts, "raypath_input");
        assert_eq!(checker.check(&never, &GO).expect("a verdict"), Some(CheckResult::Fails));
        let exit = datapath.module(datapath.steps().count() - 1).expect("a last step");
        let leaves = never_leaves(&datapath, config, &texts, exit.name());
        assert_eq!(checker.check(&leaves, &GO).expect("a verdict"), Some(CheckResult::Fails));
        // A wrong number of assertions is an error.
        never.assertions = 2;
        checker.check(&never, &GO).expect_err("one assertion and not two");
    }
}
