//! The activity of every net of a small design, compared with Verilator's values of the same nets. The models of the
//! cells for Verilator are Yosys's reading of the library.

use crate::common::{WIDTH, bench, chain, stage};
use raypath_hdl::{Builder, Module};
use raypath_ppa::{DEFAULT_LIBRARY, Design, Error, PowerResults, STREAMS, Workload};
use raypath_tools::{Options, Verilated};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::Arc;

const CYCLES: usize = 24;
const WARM_UP: usize = 3;

/// A "floating-point unit": a product.
fn unit() -> Arc<Module> {
    let m = Builder::new("raypath_fp_mul_tiny");
    let (a, b) = (m.input("a_i", WIDTH), m.input("b_i", WIDTH));
    let shifted = |bit: u32| if bit == 0 { a } else { m.concat(&[a.lower(WIDTH - bit), m.constant(bit, 0)]) };
    let rows = (0..WIDTH).map(|bit| b.bit(bit).mux(shifted(bit), m.constant(WIDTH, 0)));
    m.output("product_o", rows.reduce(|sum, row| sum + row).expect("rows"));
    m.finish().expect("a unit")
}

fn top() -> Arc<Module> {
    let input = stage("raypath_tiny_input", false, |_, number| number);
    let square = stage("raypath_tiny_square", false, |m, number| {
        let chosen = number.bit(0).mux(!number, number);
        m.instance("u_mul_0", &unit(), &[("a_i", chosen), ("b_i", number)])[0]
    });
    chain(&[("u_input", input), ("u_stage_1", square)])
}

/// The number and the valid bit at the ports.
fn inputs(cycle: usize, stream: usize) -> [u64; 2] {
    let mixed = (cycle as u64 * 64 + stream as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    [mixed >> 40 & 63, u64::from(mixed >> 20 & 3 != 0)]
}

fn workload(name: &str, inputs: impl Fn(usize, usize) -> [u64; 2]) -> Workload {
    let frame = |cycle| (0..2).map(|port| std::array::from_fn(|stream| inputs(cycle, stream)[port])).collect();
    let jobs = (STREAMS * (CYCLES - WARM_UP)) as u64;
    let frames = (0..CYCLES).map(frame).collect();
    Workload { name: name.to_string(), jobs, warm_up: WARM_UP, frames, check: Box::new(|_, _, _| None) }
}

fn measured(workloads: &[Workload]) -> Result<PowerResults, Error> {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = bench(&folder.path().join("cache"));
    let design = Design::new("tiny", &top());
    let reports = bench.measure(std::slice::from_ref(&design), |_| true)?;
    bench.power(&design, &reports[0], workloads, true, |_| true)
}

/// The transitions of each net, by instance and name, as a SAIF file has them.
fn transitions(saif: &str) -> BTreeMap<(String, String), u64> {
    let (mut found, mut scope) = (BTreeMap::new(), String::new());
    for line in saif.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["(INSTANCE", name] => scope = name.to_string(),
            [name, .., "(TC", count, "(IG", "0))"] => {
                let name = name.trim_start_matches('(').replace('\\', "");
                found.insert((scope.clone(), name), count.trim_end_matches(')').parse().expect("a number"));
            }
            _ => {}
        }
    }
    found
}

#[test]
fn every_net_has_the_transitions_of_verilator() {
    let results = measured(&[workload("random", inputs)]).expect("equal outputs");
    let ours = transitions(&results.activities[0].1);
    assert!(ours.len() > 60, "{} nets", ours.len());

    // The netlist with all nets in words at the outputs, and Yosys's models of the cells.
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let nets: Vec<&(String, String)> = ours.keys().filter(|(_, name)| name != "clk_i").collect();
    let mut shown = String::new();
    let m = Builder::new("raypath");
    let (number, valid) = (m.input("num_0_i", WIDTH), m.input("valid_i", 1));
    let state = m.register("unread_q", 1).reset_to(0);
    state.next(valid);
    for (word, nets) in nets.chunks(64).enumerate() {
        m.output(&format!("nets_{word}_o"), number.bit(0).replicate(nets.len() as u32));
        let names = nets.iter().rev().map(|(scope, name)| match scope.as_str() {
            "raypath" => name.clone(),
            unit => format!("{unit}.{name}"),
        });
        let names: Vec<String> = names.collect();
        shown += &format!("  output [{}:0] nets_{word}_o;\n", nets.len() - 1);
        shown += &format!("  assign nets_{word}_o = {{{}}};\n", names.join(", "));
    }
    let ports = m.finish().expect("ports");
    let words: Vec<String> = (0..nets.chunks(64).len()).map(|word| format!("nets_{word}_o")).collect();
    let (units, top) = results.netlist.split_once("module raypath (").expect("the top module");
    let top = top.replacen("clk_i", &format!("{}, clk_i", words.join(", ")), 1);
    let top = top.replacen("endmodule", &format!("{shown}endmodule"), 1);
    std::fs::write(path("gates.v"), format!("{units}module raypath ({top}")).expect("written");
    let commands = format!("read_liberty -ignore_miss_func {DEFAULT_LIBRARY}; write_verilog -noattr cells.v");
    let status = Command::new("yosys").args(["-q", "-p", &commands]).current_dir(folder.path()).status();
    assert!(status.expect("yosys").success());

    let files = [path("gates.v"), path("cells.v")];
    let verilated = Verilated::build_sources(&files, &ports, folder.path(), &Options::default()).expect("a program");
    let mut theirs = vec![0; nets.len()];
    for stream in 0..STREAMS {
        // A cycle of reset comes first, as in ours.
        let frames = (0..CYCLES).map(|cycle| inputs(cycle, stream)).map(|[number, valid]| vec![1, number, valid]);
        let mut before: Vec<u64> = Vec::new();
        let count = |cycle: usize, values: &[u64]| {
            if cycle > WARM_UP {
                for (net, count) in theirs.iter_mut().enumerate() {
                    *count += (values[net / 64] ^ before[net / 64]) >> (net % 64) & 1;
                }
            }
            before = values.to_vec();
        };
        verilated.run([vec![0, 0, 0]].into_iter().chain(frames), count).expect("a run");
    }
    for (net, theirs) in nets.into_iter().zip(theirs) {
        assert_eq!(ours[net], theirs, "{net:?}");
    }
    assert_eq!(ours[&("raypath".to_string(), "clk_i".to_string())], 2 * (STREAMS * (CYCLES - WARM_UP)) as u64);
}

#[test]
fn figures_of_workloads() {
    let still = |_: usize, _: usize| [0, 0];
    let results = measured(&[workload("idle", still), workload("random", inputs)]).expect("equal outputs");
    let [idle, busy] = &results.power.workloads[..] else { panic!("two workloads") };
    // Without transitions only the clock takes energy, and leakage.
    assert_eq!((idle.internal, idle.switching), (0.0, 0.0));
    assert!(idle.clock > 0.0 && busy.switching > 0.0 && busy.internal > 0.0);
    assert_eq!((idle.clock, idle.leakage), (busy.clock, busy.leakage));
    for workload in [idle, busy] {
        let parts = workload.clock + workload.internal + workload.switching + workload.leakage;
        let stages: f64 = workload.stages.iter().map(|stage| stage.picojoules).sum();
        let kinds: f64 = workload.kinds().values().sum();
        for sum in [parts, stages, kinds] {
            assert!((sum - workload.picojoules_per_cycle).abs() < 0.01, "{workload:?}");
        }
        assert!((workload.milliwatts * results.power.period_ns - workload.picojoules_per_cycle).abs() < 0.01);
    }
    let names: Vec<&str> = busy.stages.iter().map(|stage| stage.name.as_str()).collect();
    assert_eq!(names, ["input", "stage 1"]);
    assert!(busy.stages[1].kinds["mul"] > 0.0 && !busy.stages[0].kinds.contains_key("mul"));
    assert_eq!(results.power.compared_cycles, (2 * STREAMS * CYCLES) as u64);
}

#[test]
fn a_check_of_the_outputs_is_asked_in_every_cycle() {
    let mut wrong = workload("checked", inputs);
    wrong.check = Box::new(|stream, cycle, outputs| {
        assert_eq!(outputs.len(), 2);
        (stream == 5 && cycle == 7).then(|| "is wrong".to_string())
    });
    let error = measured(&[wrong]).expect_err("a wrong output").to_string();
    assert!(error.contains("in cycle 7 of checked, stream 5 is wrong"), "{error}");
}
