//! A full adder whose gates, energies and transitions are known.

use super::*;
use crate::Library;
use crate::netlist::YosysDesign;
use raypath_hdl::Builder;
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::Path;
use std::sync::Arc;

/// Energies without dependence on slews and loads. The unit is pF V² = pJ.
const POWER: &str = "rise_power (scalar) { values (\"RISE\"); } fall_power (scalar) { values (\"FALL\"); }";
const TIMES: &str = "cell_rise (scalar) { values (\"0.1\"); } cell_fall (scalar) { values (\"0.1\"); }
    rise_transition (scalar) { values (\"0.1\"); } fall_transition (scalar) { values (\"0.1\"); }";

fn internal(related: &str, rise: f64, fall: f64) -> String {
    let power = POWER.replace("RISE", &rise.to_string()).replace("FALL", &fall.to_string());
    format!("internal_power () {{ {related} {power} }}")
}

fn gate(name: &str, inputs: &str, function: &str, output: &str) -> String {
    let pin = |pin: char| format!("pin ({pin}) {{ direction : input; capacitance : 0.002; }} ");
    let timing = |pin: char| format!("timing () {{ related_pin : \"{pin}\"; {TIMES} }} ");
    format!(
        "cell ({name}) {{ area : 2; cell_leakage_power : 3; {} pin (Y) {{ direction : output; function : \"{function}\";
         {output} {} }} }}\n",
        inputs.chars().map(pin).collect::<String>(),
        inputs.chars().map(timing).collect::<String>()
    )
}

fn library() -> Library {
    let nand = internal("related_pin : \"A\";", 0.010, 0.020) + &internal("related_pin : \"B\";", 0.014, 0.024);
    let xor = internal("related_pin : \"A\";", 0.030, 0.050) + &internal("related_pin : \"B\";", 0.030, 0.050);
    let cells = [
        gate("NAND2", "AB", "!(A B)", &nand),
        gate("XOR2", "AB", "A^B", &xor),
        gate("BUFX2", "A", "A", ""),
        format!(
            "cell (DFF) {{ area : 9; cell_leakage_power : 5; ff (IQ, IQN) {{ next_state : \"D\"; clocked_on : \"CK\"; }}
             pin (CK) {{ direction : input; clock : true; capacitance : 0.001; {} }}
             pin (D) {{ direction : input; capacitance : 0.004; {}
               timing () {{ related_pin : \"CK\"; timing_type : setup_rising;
                 rise_constraint (scalar) {{ values (\"0.1\"); }} fall_constraint (scalar) {{ values (\"0.1\"); }} }} }}
             pin (Q) {{ direction : output; function : \"IQ\"; {}
               timing () {{ related_pin : \"CK\"; timing_type : rising_edge; {TIMES} }} }} }}\n",
            internal("", 0.018, 0.022),
            internal("", 0.001, 0.003),
            internal("related_pin : \"CK\";", 0.040, 0.060)
        ),
        format!(
            "cell (ICG) {{ area : 6; cell_leakage_power : 0; clock_gating_integrated_cell : \"latch_posedge\";
             pin (CK) {{ direction : input; clock : true; clock_gate_clock_pin : true; capacitance : 0.003; {} }}
             pin (EN) {{ direction : input; clock_gate_enable_pin : true; capacitance : 0.002; {} }}
             pin (GCK) {{ direction : output; clock_gate_out_pin : true; state_function : \"CK\"; {}
               timing () {{ related_pin : \"CK\"; timing_sense : positive_unate; {TIMES} }} }} }}\n",
            internal("", 0.006, 0.010),
            internal("", 0.001, 0.003),
            internal("related_pin : \"CK\";", 0.012, 0.016)
        ),
    ];
    let units = "time_unit : \"1ns\"; voltage_unit : \"1V\"; current_unit : \"1mA\"; capacitive_load_unit (1, pf);
        leakage_power_unit : \"1nW\"; nom_voltage : 2.0; nom_process : 1; nom_temperature : 25;
        operating_conditions (typical) { process : 1; voltage : 2.0; temperature : 25; }
        default_operating_conditions : typical;";
    Library::of(format!("library (l) {{ {units}\n {} }}", cells.concat()), Path::new("l.lib")).expect("a library")
}

/// a_i + b_i + c_i, with both sums in flip-flops. The nets: 2 to 4 the inputs, 5 the clock, 6 a ^ b, 7 !(a b),
/// 8 !((a ^ b) c), 9 the sum, 10 the carry, 11 and 12 the outputs.
const NETLIST: &str = r#"{"modules": {"adder": {
    "ports": {"a_i": {"direction": "input", "bits": [2]}, "b_i": {"direction": "input", "bits": [3]},
              "c_i": {"direction": "input", "bits": [4]}, "clk_i": {"direction": "input", "bits": [5]},
              "s_o": {"direction": "output", "bits": [11]}, "c_o": {"direction": "output", "bits": [12]}},
    "cells": {"c0": {"type": "XOR2", "connections": {"A": [2], "B": [3], "Y": [6]}},
              "c1": {"type": "NAND2", "connections": {"A": [2], "B": [3], "Y": [7]}},
              "c2": {"type": "NAND2", "connections": {"A": [6], "B": [4], "Y": [8]}},
              "c3": {"type": "XOR2", "connections": {"A": [6], "B": [4], "Y": [9]}},
              "c4": {"type": "NAND2", "connections": {"A": [7], "B": [8], "Y": [10]}},
              "f0": {"type": "DFF", "connections": {"CK": [5], "D": [9], "Q": [11]}},
              "f1": {"type": "DFF", "connections": {"CK": [5], "D": [10], "Q": [12]}}}}}}"#;

fn text() -> Arc<raypath_hdl::Module> {
    let m = Builder::new("adder");
    let [a, b, c] = ["a_i", "b_i", "c_i"].map(|name| m.input(name, 1));
    let [sum, carry] = ["s_q", "c_q"].map(|name| m.register(name, 1));
    sum.next(a ^ b ^ c);
    carry.next((a & b) | (c & (a | b)));
    m.output("s_o", sum.wire());
    m.output("c_o", carry.wire());
    m.finish().expect("an adder")
}

/// All streams count from 0 to 7 again and again: c is the lowest bit.
fn counting() -> Workload {
    let frame = |number: u64| [number >> 2, number >> 1, number].map(|value| [value & 1; STREAMS]).to_vec();
    let check = Box::new(|_, _, _: &[u64]| None);
    Workload { name: "counting".to_string(), jobs: 64 * 8, warm_up: 8, frames: (0..16).map(frame).collect(), check }
}

fn design(json: &str, module: &str) -> Netlist {
    let mut design: YosysDesign = serde_json::from_str(json).expect("JSON");
    design.take(module).expect("a module").0
}

/// The power and the activity of a netlist in a workload, and its gates.
fn measured(top: &Netlist, text: &Arc<raypath_hdl::Module>, workload: &Workload) -> (WorkloadPower, Activity, Gates) {
    let library = library();
    let gates = Gates::new(top, &BTreeMap::new(), &library).expect("gates");
    let never = AtomicBool::new(false);
    let activity = GateSimulator::new(&gates, text).expect("ports").run(workload, &never).expect("equal outputs");

    let folder = tempfile::tempdir().expect("a folder");
    let bench = Bench {
        library,
        yosys: Yosys::find(Some(YosysKind::Program)).expect("the package yosys"),
        sta: OpenSta::find().expect("the package opensta"),
        period: 10.0,
        unit_period: None,
        jobs: 1,
        cache: folder.path().to_path_buf(),
    };
    let verilog = structural::design(top, &BTreeMap::new(), |index| format!("x{index}"));
    let script = energy::script(&top.module, &bench.library);
    let said = bench.analyse(&top.module, &verilog, &script, MAX_STA_OUTPUT, &never).expect("a log");
    let energies = energy::energies(&String::from_utf8_lossy(&said), &gates).expect("energies");
    let share = Share { group: 0, kind: crate::attribution::Kind::SharedLogic };
    let parts = Parts {
        gates: &gates,
        energies: &energies,
        femtofarads: bench.library.femtofarads,
        shares: &vec![vec![share]; top.cells.len()],
        groups: vec![top.module.clone()],
        clock: gates.input("clk_i"),
        period_ns: 20.0,
    };
    let found = parts.power(workload, &activity);
    (found, activity, gates)
}

#[test]
fn an_adder_by_hand() {
    let workload = counting();
    let (found, activity, gates) = measured(&design(NETLIST, "adder"), &text(), &workload);

    // Transitions in eight cycles of counting: c 8, b 4, a 2, and of functions of them, from 0 to 7 and back to 0:
    // a ^ b     0 0 1 1 1 1 0 0   2      !(a b)        1 1 1 1 1 1 0 0   2
    // !(x c)    1 1 1 0 1 0 1 1   4      a ^ b ^ c     0 1 1 0 1 0 0 1   6
    // carry     0 0 0 1 0 1 1 1   4      registers as the functions, a cycle later
    let [xor, nand_ab, nand_xc, sum, carry] = [2.0, 2.0, 4.0, 6.0, 4.0];
    // In picojoules: the mean of both edges and of both inputs.
    let (in_nand, in_xor, in_q, in_d, in_clock) = (0.017, 0.040, 0.050, 0.002, 0.020);
    let internal = xor * in_xor + (nand_ab + nand_xc + carry) * in_nand + sum * in_xor + (sum + carry) * (in_d + in_q);
    // Half C V² at 2 V. Ports drive ten buffers of 2 fF.
    let charge = |picofarads: f64| 0.5 * picofarads * 2.0 * 2.0;
    let switching = xor * charge(0.004)
        + nand_ab * charge(0.002)
        + nand_xc * charge(0.002)
        + (sum + carry) * charge(0.004)
        + (sum + carry) * charge(0.020);
    let clock = 16.0 * 2.0 * (in_clock + charge(0.001));
    // 5 gates of 3 nW and 2 flip-flops of 5 nW for 20 ns.
    let leakage = (5.0 * 3.0 + 2.0 * 5.0) * 20.0 * 1e-6;
    let near = |found: f64, expected: f64| (found - expected).abs() <= 1e-4;
    assert!(near(found.internal, internal / 8.0), "{found:?} {internal}");
    assert!(near(found.switching, switching / 8.0), "{found:?} {switching}");
    assert!(near(found.clock, clock / 8.0), "{found:?} {clock}");
    assert!(near(found.leakage, leakage), "{found:?} {leakage}");
    let whole = (internal + switching + clock) / 8.0 + leakage;
    assert!(near(found.picojoules_per_cycle, whole) && found.picojoules_per_job == Some(found.picojoules_per_cycle));
    assert!(near(found.milliwatts, whole / 20.0));
    assert_eq!((found.cycles, activity.toggles[gates.ports[0].2[0] as usize]), (8 * 64, 2 * 64));
}

#[test]
fn a_wrong_gate_is_found() {
    let library = library();
    let top =
        design(&NETLIST.replace("\"A\": [6], \"B\": [4], \"Y\": [9]", "\"A\": [6], \"B\": [3], \"Y\": [9]"), "adder");
    let gates = Gates::new(&top, &BTreeMap::new(), &library).expect("gates");
    let mut simulator = GateSimulator::new(&gates, &text()).expect("ports");
    let error = simulator.run(&counting(), &AtomicBool::new(false)).expect_err("a difference").to_string();
    assert!(error.contains("s_o") && error.contains("as in the netlist before synthesis"), "{error}");
    let looping =
        design(&NETLIST.replace("\"A\": [2], \"B\": [3], \"Y\": [6]", "\"A\": [9], \"B\": [3], \"Y\": [6]"), "adder");
    let error = Gates::new(&looping, &BTreeMap::new(), &library).err().expect("a loop").to_string();
    assert!(error.contains("a combinational loop"), "{error}");
}

/// A register that loads d_i in every second cycle.
#[test]
fn a_clock_gate_by_hand() {
    let json = r#"{"modules": {"gated": {
        "ports": {"d_i": {"direction": "input", "bits": [2]}, "e_i": {"direction": "input", "bits": [3]},
                  "clk_i": {"direction": "input", "bits": [4]}, "q_o": {"direction": "output", "bits": [5]}},
        "cells": {"f": {"type": "DFF", "connections": {"CK": [6], "D": [2], "Q": [5]}},
                  "g": {"type": "ICG", "connections": {"CK": [4], "EN": [3], "GCK": [6]}}}}}}"#;
    let m = Builder::new("gated");
    let (data, enable) = (m.input("d_i", 1), m.input("e_i", 1));
    let register = m.register("q_q", 1);
    register.next_gated(enable, data);
    m.output("q_o", register.wire());
    let frame = |number: u64| [number >> 1, number].map(|value| [value & 1; STREAMS]).to_vec();
    let check = Box::new(|_, _, _: &[u64]| None);
    let frames = (0..16).map(frame).collect();
    let workload = Workload { name: "counting".to_string(), jobs: 0, warm_up: 8, frames, check };
    let (found, activity, gates) = measured(&design(json, "gated"), &m.finish().expect("a module"), &workload);

    // In eight cycles d is 0 0 1 1 0 0 1 1, and it is loaded in the second, fourth, sixth and eighth: q changes four
    // times. The gated clock has four pulses.
    let toggles = |port: &str| {
        let (_, _, nets) = gates.ports.iter().find(|(name, ..)| name == port).expect("a port");
        activity.toggles[nets[0] as usize] / 64
    };
    assert_eq!([toggles("clk_i"), toggles("d_i"), toggles("e_i"), toggles("q_o")], [16, 4, 8, 4]);
    let charge = |picofarads: f64| 0.5 * picofarads * 2.0 * 2.0;
    let (in_flip_flop, in_gate, in_gated) = (0.020, 0.008, 0.014);
    let clock = 16.0 * (in_gate + charge(0.003)) + 8.0 * (in_gated + charge(0.001) + in_flip_flop);
    let internal = 4.0 * (0.002 + 0.050) + 8.0 * 0.002;
    assert!((found.clock - clock / 8.0).abs() <= 1e-4, "{found:?} {clock}");
    assert!((found.internal - internal / 8.0).abs() <= 1e-4, "{found:?} {internal}");
    assert!((found.switching - 4.0 * charge(0.020) / 8.0).abs() <= 1e-4, "{found:?}");
}
