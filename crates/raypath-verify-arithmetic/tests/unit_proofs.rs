//! Proofs of units: what is no proof, and claims about faulty units. The items prove the claims.

use raypath_float::Format;
use raypath_verify::Request;
use raypath_verify::sat::{Miter, ProofResult, Prover, SOURCE};
use raypath_verify_arithmetic::units::proofs::{Operands, Unit, UnitClaim, multiplication, unit_proofs};
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

#[test]
fn a_stop_is_heeded() {
    let mut watch = |_| false;
    for run in [unit_proofs, multiplication] {
        let verdict = run(&mut Request::new(&mut watch)).unwrap();
        assert!(verdict.is_stopped && verdict.failures.is_empty(), "{verdict:?}");
        assert!(verdict.covered.starts_with("0 of "), "{verdict:?}");
    }
}

/// The claim about a faulty unit is refuted, with operands whose words are those of the fault.
#[test]
fn a_faulty_unit_fails_with_operands() {
    let format = Format::new(3, 4).unwrap();
    let claim = UnitClaim::Rounds(Unit::Mul, Operands::All).claim(format).unwrap();
    let miters = [claim.miter(false).unwrap(), claim.miter(true).unwrap()];
    let folder = tempfile::tempdir().unwrap();
    let prover = Prover::find().unwrap().keeping_in(folder.path());
    let answers = prover.solve(&miters, LIMIT, &AtomicBool::new(false)).unwrap();
    let [ProofResult::Proved { .. }, ProofResult::Refuted(values)] = &answers[..] else { panic!("{answers:?}") };
    // The fault is where a product is half the least subnormal number.
    let product = format.to_f64(values["a"]) * format.to_f64(values["b"]);
    assert!(product.abs() < format.to_f64(1), "{values:x?}");
}

#[test]
fn a_timeout_is_not_a_proof() {
    let claim = UnitClaim::Rounds(Unit::Mul, Operands::All).claim(Format::BINARY16).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let prover = Prover::find().unwrap().keeping_in(folder.path());
    let limit = Duration::from_millis(1);
    let answers = prover.solve(&[claim.miter(false).unwrap()], limit, &AtomicBool::new(false)).unwrap();
    assert!(matches!(&answers[..], [ProofResult::Undecided(_)]), "{answers:?}");
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
