//! Memories in proofs: as registers in the model checker, as ports in equivalence checks.

use raypath_hdl::mutate::faults;
use raypath_hdl::{Builder, Module, expand_memories, verilog};
use raypath_verify::equivalence::Equivalence;
use raypath_verify::safety::{CheckResult, Method, ModelChecker, SafetyProblem};
use raypath_verify::sat::Prover;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

static GO: AtomicBool = AtomicBool::new(false);

/// A memory with two columns of four bits and everything at ports; rewritten, with equivalent logic before it.
fn store(is_rewritten: bool) -> Arc<Module> {
    let m = Builder::new("store");
    let (write, write_address, data) = (m.input("write_i", 1), m.input("write_address_i", 2), m.input("data_i", 8));
    let (read, read_address) = (m.input("read_i", 1), m.input("read_address_i", 2));
    let memory = m.memory("u_store", 4, &[("high", 4), ("low", 4)]);
    // What is not written does not matter.
    let high = if is_rewritten { write.mux(data.upper(4), data.lower(4)) } else { data.upper(4) };
    memory.write(write, write_address, &[high, data.lower(4)]);
    m.output("data_o", m.concat(&memory.read(read, read_address)));
    m.finish().expect("a memory")
}

/// The word 2 is followed: a read returns what was written last before it.
const CHECK: &str = "
module check (
  input logic clk_i, write_i, read_i,
  input logic [1:0] write_address_i, read_address_i,
  input logic [7:0] data_i
);
  logic [7:0] data, last, expected;
  logic is_written = 1'b0;
  logic is_expected = 1'b0;
  store u_store (
    .clk_i, .write_i, .write_address_i, .data_i, .read_i, .read_address_i, .data_o (data)
  );
  wire writes = write_i && write_address_i == 2'd2;
  always_ff @(posedge clk_i) begin
    if (writes) {is_written, last} <= {1'b1, data_i};
    if (read_i) {is_expected, expected} <= {is_written && read_address_i == 2'd2, last};
  end
  always_comb assert (!is_expected || data == expected);
endmodule
";

fn checked(text: String, method: Method) -> Option<CheckResult> {
    verdict(text, method).expect("a verdict")
}

fn verdict(text: String, method: Method) -> Result<Option<CheckResult>, raypath_verify::Error> {
    let problem = SafetyProblem { name: "store".to_string(), top: "check".to_string(), text, assertions: 1, method };
    ModelChecker::find().expect("pyosys").check(&problem, &GO)
}

#[test]
fn reads_return_what_was_written_last() {
    let module = store(false);
    for module in [&module, &expand_memories(&module).expect("registers")] {
        let text = verilog::text(module).expect("a text") + CHECK;
        for method in [Method::Unbounded, Method::Bounded(6)] {
            assert_eq!(checked(text.clone(), method), Some(CheckResult::Holds), "{method:?}");
        }
        // A read of the word that is written would return the new value.
        let fault = text
            .replace("{is_written && read_address_i", "{writes && read_address_i")
            .replace(", last};\n", ", data_i};\n");
        assert_eq!(checked(fault, Method::Bounded(6)), Some(CheckResult::Fails));
    }
    // Every fault of the memory is found.
    for fault in faults(&module).iter().filter(|fault| fault.to_string().contains("u_store.")) {
        let faulty = Arc::new(fault.apply(&module).expect("a faulty module"));
        // The checker refuses an assertion without state, to which synthesis reduces a memory that is never used.
        let Ok(result) = verdict(verilog::text(&faulty).expect("a text") + CHECK, Method::Bounded(6)) else {
            assert!(fault.to_string().contains("enable: replaced by zero"), "{fault}: no verdict");
            continue;
        };
        let is_harmless = fault.to_string().contains("bit 0 stuck") || fault.to_string().contains("read_enable: ");
        assert!(result == Some(CheckResult::Fails) || is_harmless, "{fault}: {result:?}");
    }
}

#[test]
fn memories_are_compared_by_what_they_take() {
    let module = store(false);
    let rewritten = store(true);
    let faulty: Vec<(String, Arc<Module>)> = faults(&module)
        .iter()
        .map(|fault| (fault.to_string(), Arc::new(fault.apply(&module).expect("a faulty module"))))
        .collect();
    let pairs: Vec<_> =
        [&rewritten].into_iter().chain(faulty.iter().map(|(_, it)| it)).map(|it| (&module, it)).collect();
    let prover = Prover::find().expect("pyosys");
    let results = prover.equivalent(&pairs, Duration::from_secs(60), &GO).expect("results");
    assert_eq!(results[0], Equivalence::Proved);
    for ((fault, _), result) in faulty.iter().zip(&results[1..]) {
        assert!(matches!(result, Equivalence::Different(_)), "{fault}: {result:?}");
    }
}
