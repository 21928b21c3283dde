//! The netlist that is printed: compiled by us, and compiled by Verilator.

use crate::commands::Failure;
use crate::commands::bench::result::Results;
use crate::commands::bench::stopwatch::seconds;
use crate::commands::bench::workload::Workload;
use raypath::engine::{Engine, NetlistEngine};
use raypath::hdl::Module;
use raypath::model::Functional;
use raypath::ops::{Job, Rules};
use raypath::rtl::{Config, Datapath};
use raypath_cosim::{CosimError, Options, Verilated};
use std::hint::black_box;

/// Cycles of one measurement.
const CYCLES: usize = 512;

/// A mixed job in every cycle, none refused.
pub fn run(results: &mut Results, repetitions: usize, with_verilator: bool) -> Result<(), Failure> {
    let datapath = Datapath::new(Config::DEFAULT)?;
    let jobs = Workload::new().mixed(CYCLES);
    let mut engine = NetlistEngine::of(Functional::<16, 8>::new(Rules::Paper), Config::DEFAULT, &datapath, |_| false)?;
    let time = seconds(repetitions, || {
        for job in &jobs {
            engine.present(black_box(job));
            black_box(engine.clock(true, true));
        }
    });
    results.rate("netlist, compiled, a mixed job each cycle", "cycles", CYCLES as f64 / time, None);
    if with_verilator {
        match verilator(datapath.top(), &jobs, repetitions) {
            Ok(per_second) => results.beside("cycles", "Verilator", per_second),
            Err(problem) => results.missing(format!("Verilator: {problem}")),
        }
    }
    Ok(())
}

/// Cycles a second of Verilator, one thread, all of its and the compiler's optimisation.
fn verilator(top: &std::sync::Arc<Module>, jobs: &[Job], repetitions: usize) -> Result<f64, CosimError> {
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
