//! Proofs of the control: they hold for the design, and faults are refuted by the same commands.

use raypath_rtl::{Config, Control, Datapath, Lanes, UnitLatency};
use raypath_verify::control::{Answer, Engine, Fault, Texts, faults, problems, vacuous};

fn config(control: Control) -> Config {
    Config { control, lanes: Lanes::Two, unit_latency: UnitLatency::Two, ..Config::DEFAULT }
}

/// What the engine says of the problem that begins with `name`, with and without a fault.
fn judge(config: Config, name: &str, fault: Fault) {
    let engine = Engine::find().expect("pyosys");
    let datapath = Datapath::new(config).expect("a datapath");
    let whole = Texts::new(datapath.top()).expect("text");
    let mut faulty = whole.clone();
    assert!(faulty.insert(fault), "{fault:?}");
    for (texts, expected) in [(whole, Answer::Holds), (faulty, Answer::Fails)] {
        let all = problems(&datapath, config, &texts, 8);
        let problem = all.iter().find(|problem| problem.name.starts_with(name)).expect("a problem");
        assert_eq!(engine.judge(problem).expect("a verdict"), expected, "{config}: {}, {fault:?}", problem.name);
    }
}

#[test]
fn a_job_that_arrives_without_ready_is_found() {
    let fault = Fault { module: "raypath_skid", from: "valid_i & spare_empty_q", to: "valid_i" };
    judge(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn a_register_that_loads_while_it_waits_is_found() {
    let fault = Fault { module: "raypath_skid", from: "= leaves & refill", to: "= refill" };
    judge(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn a_ready_that_is_the_sinks_is_found() {
    let fault =
        Fault { module: "raypath_skid", from: "assign ready_o      = spare_empty_q", to: "assign ready_o = ready_i" };
    judge(config(Control::Skid), "raypath_input: ", fault);
}

#[test]
fn an_accumulator_that_is_written_while_it_waits_is_found() {
    let fault = Fault { module: "raypath_stage_9_2", from: "= advance & (opcode_i", to: "= valid_i & (opcode_i" };
    judge(config(Control::Skid), "raypath_stage_9_2: ", fault);
}

#[test]
fn a_credit_too_many_is_found() {
    let fault = Fault { module: "raypath_credit", from: "available_q <= |count_d", to: "available_q <= 1'b1" };
    judge(config(Control::Credit), "raypath_credit: ", fault);
}

#[test]
fn the_structure_is_as_it_must_be_and_jobs_leave() {
    let engine = Engine::find().expect("pyosys");
    for &control in Control::ALL {
        let config = config(control);
        let datapath = Datapath::new(config).expect("a datapath");
        assert_eq!(faults(&datapath, config).expect("no loop"), Vec::<String>::new());
        let texts = Texts::new(datapath.top()).expect("text");
        let mut never = vacuous(&datapath, config, &texts, "raypath_input");
        assert_eq!(engine.judge(&never).expect("a verdict"), Answer::Fails);
        // Nothing to prove is no proof.
        never.assertions = 2;
        engine.judge(&never).expect_err("one assertion and not two");
    }
}
