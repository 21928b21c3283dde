//! A job whose opcode is not configured passes through like any other, and all its outputs are zero.

use crate::random::{jobs, rng};
use rand::RngExt;
use raypath::hdl::Simulator;
use raypath::ops::{Job, JobKind};
use raypath::rtl::{Config, Datapath, Lanes};

const LATENCY: usize = 12;

fn without_distances() -> Simulator {
    let config = Config::DEFAULT.lanes(Lanes::None);
    let mut simulator = Simulator::new(Datapath::new(config).unwrap().top()).unwrap();
    simulator.set_reset(true);
    simulator.cycle();
    simulator.set_reset(false);
    simulator
}

fn set(simulator: &mut Simulator, port: &str, value: u64) {
    let input = simulator.input(port).unwrap();
    simulator.set(input, value);
}

fn get(simulator: &Simulator, port: &str) -> u64 {
    simulator.get(simulator.output(port).unwrap())
}

fn present(simulator: &mut Simulator, job: &Job) {
    for port in job.ports() {
        set(simulator, &format!("{}_i", port.name), port.bits);
    }
}

/// All output ports except those of the handshake, by name.
fn results(simulator: &Simulator) -> Vec<(String, u64)> {
    let names = simulator.module().outputs().iter().map(|port| port.name.clone());
    let results = names.filter(|name| !["input_ready_o", "output_valid_o", "opcode_o"].contains(&name.as_str()));
    results.map(|name| (name.clone(), get(simulator, &name))).collect()
}

#[test]
fn ports_of_modes_that_are_off_do_not_exist() {
    let simulator = without_distances();
    let module = simulator.module();
    let mut ports = module.inputs().iter().chain(module.outputs());
    assert!(!ports.any(|port| port.name.starts_with("euclidean") || port.name.starts_with("angular")));
}

/// All opcodes in random order, with ports that belong to jobs with hits.
#[test]
fn unsupported_opcodes_yield_zeros_after_twelve_cycles() {
    let mut simulator = without_distances();
    let mut rng = rng(16);
    set(&mut simulator, "input_valid_i", 1);
    set(&mut simulator, "output_ready_i", 1);
    let mut sent: Vec<u64> = Vec::new();
    let (mut unsupported, mut not_zero) = (0, 0);
    for (cycle, job) in jobs(&[JobKind::Triangle, JobKind::Quadbox], 17).take(500).enumerate() {
        // The ports have both jobs at once, so that an output without gating would be visible.
        present(&mut simulator, &job);
        let opcode = rng.random_range(0..4);
        set(&mut simulator, "opcode_i", opcode);
        sent.push(opcode);
        simulator.cycle();
        assert_eq!(get(&simulator, "input_ready_o"), 1);
        assert_eq!(get(&simulator, "output_valid_o"), u64::from(cycle >= LATENCY), "cycle {cycle}");
        let Some(left) = cycle.checked_sub(LATENCY) else { continue };
        assert_eq!(get(&simulator, "opcode_o"), sent[left], "the opcode is passed along, cycle {cycle}");
        let strays: Vec<_> = results(&simulator).into_iter().filter(|(_, bits)| *bits != 0).collect();
        if sent[left] >= 2 {
            assert_eq!(strays, [], "cycle {cycle}, opcode {}", sent[left]);
            unsupported += 1;
        } else {
            not_zero += usize::from(!strays.is_empty());
        }
    }
    assert!(unsupported > 100 && not_zero > 80, "{unsupported} {not_zero}");
}
