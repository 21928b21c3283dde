//! The proofs of operations: a fault is refuted by the first operation that it changes.

use raypath_rtl::{Config, Lanes};
use raypath_verify::control::TextFault;
use raypath_verify::dataflow::{DataflowProver, FAULTS, Subject};
use std::sync::atomic::AtomicBool;

static GO: AtomicBool = AtomicBool::new(false);

/// What is not proved of a configuration with a fault.
fn failures(config: Config, fault: Option<TextFault>) -> Vec<String> {
    let subject = Subject::from(config);
    let proved = DataflowProver::find().expect("pyosys and z3").prove(&subject, fault, &GO).expect("programs that run");
    proved.expect("no stop").failures
}

#[test]
fn operations_without_the_fault_are_proved() {
    let no_reset = FAULTS.iter().find(|fault| fault.from.contains("33'd0")).expect("a fault of a state");
    let expected = "euclidean: euclidean_accumulator can differ from the operation's";
    assert_eq!(failures(Config::DEFAULT, Some(*no_reset)), [expected]);
}

#[test]
fn a_job_that_leaves_early_is_refuted() {
    let config = Config::DEFAULT.lanes(Lanes::None);
    assert!(failures(config, None).is_empty());
    let fault = TextFault { module: "raypath_stage_5", from: ".valid_i, .ready_i", to: ".valid_i (1'b1), .ready_i" };
    let failures = failures(config, Some(fault));
    assert!(failures[0].starts_with("quadbox: output_valid_o after 7 cycles, "), "{failures:?}");
}
