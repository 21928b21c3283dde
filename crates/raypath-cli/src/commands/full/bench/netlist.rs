//! The netlist: our simulator, and Verilator on the printed text.

use crate::commands::full::bench::result::{Results, seconds};
use crate::commands::full::bench::workload::Workload;
use crate::error::CliError;
use raypath_hdl::{Module, Simulator};
use raypath_ops::Job;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_tools::{Options, ToolError, Verilated, temporary_folder};
use std::hint::black_box;
use std::sync::Arc;

/// The cycles of a run: few, so that some of many runs are not interrupted.
const CYCLES: usize = 128;

/// The number of these runs for each repetition.
const RUNS: usize = 8;

/// Measures the netlist with a job in every cycle, of all operations in turn.
pub fn run(results: &mut Results, repetitions: usize, with_verilator: bool) -> Result<(), CliError> {
    let datapath = DatapathNetlist::new(Config::DEFAULT)?;
    let top = datapath.top();
    let jobs = Workload::new().mixed(CYCLES);
    let mut simulator = Simulator::new(top)?;
    let time = seconds(repetitions.div_ceil(8), || drop(black_box(Simulator::new(black_box(top)))));
    results.rate("netlist, compiling it", "netlists", 1.0 / time, None);
    let per_second = compiled(&mut simulator, &jobs, RUNS * repetitions);
    results.rate("netlist, compiled, a mixed job each cycle", "cycles", per_second, None);
    if with_verilator {
        match verilator(top, &jobs, RUNS * repetitions) {
            Ok(per_second) => results.beside("cycles", "Verilator", per_second),
            Err(problem) => results.missing(format!("Verilator: {problem}")),
        }
    }
    Ok(())
}

/// The cycles per second, including writes and reads of all ports.
fn compiled(simulator: &mut Simulator, jobs: &[Job], repetitions: usize) -> f64 {
    let top = simulator.module();
    let stimuli: Vec<Vec<u64>> = jobs.iter().map(|job| stimulus(top, job)).collect();
    let time = seconds(repetitions, || {
        for values in &stimuli {
            simulator.set_all(black_box(values).iter().copied());
            simulator.cycle();
            black_box(simulator.outputs());
        }
    });
    jobs.len() as f64 / time
}

/// The cycles per second of Verilator, with one thread and all optimisations of Verilator and the C++ compiler.
fn verilator(top: &Arc<Module>, jobs: &[Job], repetitions: usize) -> Result<f64, ToolError> {
    let folder = temporary_folder()?;
    let options = Options { c_optimisation: 3, native: true, ..Options::default() };
    let verilated = Verilated::build_with(top, folder.path(), &options)?;
    // The first value of a frame is the reset, which is active low.
    let frames = jobs.iter().map(|job| [vec![1], stimulus(top, job)].concat());
    let times = verilated.time(frames, repetitions)?;
    Ok(jobs.len() as f64 / times.into_iter().fold(f64::INFINITY, f64::min))
}

/// The values of the inputs in a cycle that offers a job to a ready sink.
fn stimulus(top: &Module, job: &Job) -> Vec<u64> {
    let ports = job.ports();
    let value = |name: &str| match name {
        "input_valid_i" | "output_ready_i" => 1,
        "opcode_i" => job.kind().opcode(),
        _ => ports.iter().find(|port| name.strip_suffix("_i") == Some(&port.name)).map_or(0, |port| port.bits),
    };
    top.inputs().iter().map(|port| value(&port.name)).collect()
}
