//! Proofs of units: both multiplications of binary32, of which level `regression` proves one, and claims about faulty
//! units, which are refuted. The item `unit-proofs` proves the others.

use raypath_float::Format;
use raypath_verify::Request;
use raypath_verify::sat::{Miter, ProofResult, Prover, SOURCE};
use raypath_verify_arithmetic::units::proofs::{Claim, Subject, check, multiplication, unit_proofs};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(300);

fn circuit(text: &str, commands: &[&str]) -> Miter {
    let mut all = vec![format!("read_verilog -sv {SOURCE}miter.sv"), "hierarchy -top miter".into(), "proc".into()];
    all.extend(commands.iter().map(ToString::to_string));
    Miter {
        name: "test".to_string(),
        sources: vec![("miter.sv".to_string(), text.to_string())],
        commands: all,
        inputs: vec![("a".to_string(), 8)],
    }
}

fn solve(problem: Miter) -> Result<Vec<ProofResult>, raypath_verify::Error> {
    Prover::find()?.solve(&[problem], LIMIT, &AtomicBool::new(false))
}

/// The multipliers of binary32, of gates and with `*`, with a fault for each lemma.
#[test]
fn multiplication_of_binary32_is_proved() {
    let mut watch = |_| true;
    let verdict = multiplication(&mut Request::new(&mut watch)).unwrap();
    assert_eq!(verdict.failures, [""; 0]);
    let expected = "2 theorems, and 25 faults refuted: multiplication at (8,24) by 20 lemmas; multiplication with * at \
                    (8,24) by 5 lemmas";
    assert_eq!(verdict.covered, expected);
    let certified = "25 proofs repeated by CaDiCaL, each step of their certificates checked";
    assert_eq!((verdict.remarks.len(), verdict.remarks[1].as_str()), (27, certified), "{:#?}", verdict.remarks);
    assert!(!verdict.is_stopped);
}

#[test]
fn a_stop_is_heeded() {
    let mut watch = |_| false;
    let verdict = unit_proofs(&mut Request::new(&mut watch)).unwrap();
    assert!(verdict.is_stopped && verdict.failures.is_empty());
    assert_eq!(verdict.covered, "nothing proved");
    let verdict = multiplication(&mut Request::new(&mut watch)).unwrap();
    assert!(verdict.is_stopped && verdict.failures.is_empty());
}

/// The claim about a faulty unit is refuted, with operands.
#[test]
fn a_faulty_unit_fails_with_operands() {
    let format = Format::new(3, 4).unwrap();
    let claim = Claim::all(Subject::Mul, format);
    let faulty = claim.miter(true).unwrap();
    let prover = Prover::find().unwrap();
    let answers = prover.solve(std::slice::from_ref(&faulty), LIMIT, &AtomicBool::new(false)).unwrap();
    let ProofResult::Refuted(values) = &answers[0] else { panic!("{answers:?}") };
    let shown = prover.evaluate(&faulty, values, &["a", "b", "ours", "wanted"]).unwrap();
    // The software's product of the same operands.
    assert_eq!(shown[3], format.mul(shown[0], shown[1]));
    assert_ne!(shown[2], shown[3]);
}

#[test]
fn a_timeout_is_not_a_proof() {
    let claim = Claim::all(Subject::Mul, Format::BINARY16);
    let limit = Duration::from_millis(1);
    let done = check(&Prover::find().unwrap(), claim, false, limit, &AtomicBool::new(false)).unwrap().unwrap();
    let why = done.outcome.unwrap_err();
    assert!(why.contains("undecided"), "{why}");
}

#[test]
fn a_wire_that_nothing_drives_is_an_error() {
    let text = "module miter (input [7:0] a, output differ); wire u; assign differ = u && (a == 0); endmodule";
    let error = solve(circuit(text, &[])).unwrap_err().to_string();
    assert!(error.contains("the inputs a (8)"), "{error}");
}

#[test]
fn a_missing_module_or_side_is_an_error() {
    let text = "module miter (input [7:0] a, output differ); absent u (.a(a), .o(differ)); endmodule";
    assert!(solve(circuit(text, &[])).is_err());
    let text = "module miter (input [7:0] a, output differ); wire s = 0; assign differ = s; endmodule";
    assert!(matches!(solve(circuit(text, &[])).unwrap()[..], [ProofResult::Proved { gates: 0, .. }]));
    // Every proof of a unit has such a command.
    let guard = "select -assert-min 1 miter/w:s %ci* miter/w:a %i";
    assert!(solve(circuit(text, &[guard])).is_err());
}

#[test]
fn assertions_left_in_a_circuit_are_an_error() {
    let text = "module miter (input [7:0] a, output differ);\n\
                assign differ = 0; always @* assert (a != 3);\nendmodule";
    assert!(solve(circuit(text, &[])).is_err());
    assert!(solve(circuit(text, &["chformal -remove"])).is_ok());
}
