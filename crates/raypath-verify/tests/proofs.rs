//! Results are kept by what is proved: a second time no program runs, and a change of a character is proved again.

use raypath_verify::safety::{CheckResult, Method, ModelChecker, SafetyProblem};
use raypath_verify::sat::{Miter, ProofResult, Prover, SOURCE};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(60);

/// With this flag every program is ended before it has a result.
static STOP: AtomicBool = AtomicBool::new(true);
static GO: AtomicBool = AtomicBool::new(false);

/// Wrong for one value of `a`, or for none.
fn miter(condition: &str) -> Miter {
    let text = format!(
        "module miter (input [7:0] a, output differ); wire [7:0] sum = a + 1;\nassign differ = {condition}; endmodule"
    );
    Miter {
        name: "sum".to_string(),
        sources: vec![("miter.sv".to_string(), text)],
        commands: [&format!("read_verilog -sv {SOURCE}miter.sv"), "hierarchy -top miter", "proc"]
            .map(String::from)
            .into(),
        inputs: vec![("a".to_string(), 8)],
    }
}

#[test]
fn the_same_problem_is_solved_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let prover = Prover::find().expect("pyosys").keeping_in(folder.path());
    let problems = ["sum == a", "sum == a - 9 + a"].map(miter);
    let solved = prover.solve(&problems, LIMIT, &GO).expect("results");
    assert!(matches!(solved[..], [ProofResult::Proved { .. }, ProofResult::Refuted(_)]), "{solved:?}");
    let ProofResult::Refuted(values) = &solved[1] else { unreachable!() };
    assert_eq!(values["a"], 10);
    assert_eq!(prover.solve(&problems, LIMIT, &STOP).expect("results"), solved);
    // Other results than these are not kept: a problem that was stopped is solved when there is time.
    let mut changed = [miter("sum == a "), problems[0].clone(), problems[0].clone(), problems[0].clone()];
    changed[1].commands.push("opt".to_string());
    changed[2].sources[0].0 = "miter.v".to_string();
    changed[3].inputs[0].1 = 9;
    assert_eq!(prover.solve(&changed, LIMIT, &STOP).expect("results"), vec![ProofResult::Stopped; 4]);
    let again = prover.solve(&[changed[0].clone(), problems[1].clone()], LIMIT, &GO).expect("results");
    assert_eq!(again, solved);
}

fn counter(limit: u32) -> SafetyProblem {
    let text = format!(
        "module check (input logic clk_i);\n  logic [3:0] count = 0;\n\
         always_ff @(posedge clk_i) count <= count == 9 ? 0 : count + 1;\n\
         always_comb assert (count < {limit});\nendmodule\n"
    );
    let (top, method) = ("check".to_string(), Method::Unbounded);
    SafetyProblem { name: "counter".to_string(), top, text, assertions: 1, method }
}

#[test]
fn the_same_assertion_is_checked_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let checker = ModelChecker::find().expect("pyosys").keeping_in(folder.path());
    for (limit, expected) in [(10, CheckResult::Holds), (9, CheckResult::Fails)] {
        let problem = counter(limit);
        assert_eq!(checker.check(&problem, &GO).expect("a verdict"), Some(expected));
        assert_eq!(checker.check(&problem, &STOP).expect("a verdict"), Some(expected));
        let others = [
            SafetyProblem { text: problem.text.clone() + " ", ..problem.clone() },
            SafetyProblem { method: Method::Bounded(20), ..problem.clone() },
            SafetyProblem { assertions: 2, ..problem },
        ];
        for other in others {
            assert_eq!(checker.check(&other, &STOP).expect("no verdict"), None);
        }
    }
}

#[test]
fn an_assertion_whose_state_falls_away_is_decided() {
    let folder = tempfile::tempdir().expect("a folder");
    let checker = ModelChecker::find().expect("pyosys").keeping_in(folder.path());
    // ABC, but not Yosys, finds that both sides are the same logic.
    let same = "(q & b) == ~(~q | ~b)";
    for (condition, expected) in [(same, CheckResult::Holds), (&format!("{same} && !(a & b)"), CheckResult::Fails)] {
        let text = format!(
            "module state (input clk, a, b); logic q; always_ff @(posedge clk) q <= a; \
             always_comb assert ({condition}); endmodule"
        );
        let (name, top) = ("state".to_string(), "state".to_string());
        for method in [Method::Inductive, Method::Unbounded, Method::Bounded(4)] {
            let problem =
                SafetyProblem { name: name.clone(), top: top.clone(), text: text.clone(), assertions: 1, method };
            assert_eq!(checker.check(&problem, &GO).expect("a verdict"), Some(expected), "{condition}, {method:?}");
        }
    }
}
