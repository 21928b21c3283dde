//! The netlist that is printed: compiled by us, and compiled by Verilator.

use crate::commands::Failure;
use crate::commands::bench::result::Results;
use crate::commands::bench::stopwatch::seconds;
use crate::commands::bench::workload::Workload;
use raypath::hdl::{LANES, LaneSimulator, Module, Simulator};
use raypath::ops::Job;
use raypath::rtl::{Config, Datapath};
use raypath_cosim::{CosimError, Options, Verilated};
use std::hint::black_box;
use std::sync::Arc;

/// Cycles of one run: few, so that some of many runs are not interrupted.
const CYCLES: usize = 128;

/// Runs for each of other measurements.
const RUNS: usize = 8;

/// A mixed job in every cycle, none refused.
pub fn run(results: &mut Results, repetitions: usize, with_verilator: bool) -> Result<(), Failure> {
    let repetitions = RUNS * repetitions;
    let datapath = Datapath::new(Config::DEFAULT)?;
    let jobs = Workload::new().mixed(CYCLES);
    let mut simulator = Simulator::new(datapath.top())?;
    let ports = datapath.top().inputs().iter();
    let inputs = ports.map(|port| simulator.input(&port.name)).collect::<Result<Vec<_>, _>>()?;
    let ports = datapath.top().outputs().iter();
    let outputs = ports.map(|port| simulator.output(&port.name)).collect::<Result<Vec<_>, _>>()?;
    let frames: Vec<Vec<u64>> = jobs.iter().map(|job| frame(datapath.top(), job)).collect();
    let time = seconds(repetitions, || {
        for frame in &frames {
            // The first of a frame is the reset.
            for (input, value) in inputs.iter().zip(&frame[1..]) {
                simulator.set(*input, black_box(*value));
            }
            simulator.cycle();
            for output in &outputs {
                black_box(simulator.get(*output));
            }
        }
    });
    results.rate("netlist, compiled, a mixed job each cycle", "cycles", CYCLES as f64 / time, None);
    results.rate(
        format!("netlist in lanes, a mixed job each cycle in each of {LANES}"),
        "cycles",
        lanes(datapath.top(), repetitions / RUNS)?,
        None,
    );
    if with_verilator {
        match verilator(datapath.top(), &jobs, repetitions) {
            Ok(per_second) => results.beside("cycles", "Verilator", per_second),
            Err(problem) => results.missing(format!("Verilator: {problem}")),
        }
    }
    Ok(())
}

/// Cycles a second of all lanes together, each with jobs of its own; setting and reading all ports included.
fn lanes(top: &Arc<Module>, repetitions: usize) -> Result<f64, Failure> {
    // A few cycles, for there are many lanes.
    const CYCLES: usize = 8;
    let mut simulator = LaneSimulator::new(top)?;
    let inputs = top.inputs().iter().map(|port| simulator.input(&port.name)).collect::<Result<Vec<_>, _>>()?;
    let outputs = top.outputs().iter().map(|port| simulator.output(&port.name)).collect::<Result<Vec<_>, _>>()?;
    let jobs = Workload::new().mixed(CYCLES * LANES);
    let stimuli: Vec<Vec<[u64; LANES]>> = jobs
        .chunks(LANES)
        .map(|jobs| {
            let mut ports = vec![[0; LANES]; inputs.len()];
            for (lane, job) in jobs.iter().enumerate() {
                // The first of a frame is the reset.
                for (port, value) in ports.iter_mut().zip(&frame(top, job)[1..]) {
                    port[lane] = *value;
                }
            }
            ports
        })
        .collect();
    let time = seconds(repetitions, || {
        for ports in &stimuli {
            for (input, values) in inputs.iter().zip(ports) {
                simulator.set(*input, black_box(values));
            }
            simulator.cycle();
            for output in &outputs {
                black_box(simulator.get(*output));
            }
        }
    });
    Ok((CYCLES * LANES) as f64 / time)
}

/// Cycles a second of Verilator, one thread, all of its and the compiler's optimisation.
fn verilator(top: &Arc<Module>, jobs: &[Job], repetitions: usize) -> Result<f64, CosimError> {
    let folder = tempfile::tempdir().map_err(|problem| CosimError::File { path: std::env::temp_dir(), problem })?;
    let options = Options { c_optimisation: 3, native: true, ..Options::default() };
    let verilated = Verilated::build_with(top, folder.path(), &options)?;
    let frames = jobs.iter().map(|job| frame(top, job));
    let times = verilated.time(frames, repetitions)?;
    Ok(jobs.len() as f64 / times.into_iter().fold(f64::INFINITY, f64::min))
}

/// What the ports get in a cycle that offers a job: no reset, valid, and the sink is ready.
fn frame(top: &Module, job: &Job) -> Vec<u64> {
    let ports = job.ports();
    let value = |name: &str| match name {
        "input_valid_i" | "output_ready_i" => 1,
        "opcode_i" => job.kind().opcode(),
        _ => ports.iter().find(|port| name.strip_suffix("_i") == Some(&port.name)).map_or(0, |port| port.bits),
    };
    std::iter::once(1).chain(top.inputs().iter().map(|port| value(&port.name))).collect()
}
