//! `raypath bench`: the speed of the models, compared with Verilator on the same hardware and obvhs on the same rays.

mod growth;
mod models;
mod netlist;
mod peers;
mod result;
mod unit;
mod workload;

use crate::error::CliError;
use clap::Args;
use raypath_sim::files::write_all;
use result::Results;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Also write the JSON to a file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Skip Verilator, whose C++ takes minutes to compile; by default it is measured if it is installed
    #[arg(long)]
    no_verilator: bool,
    /// Run a tenth of the repetitions: faster, but less precise
    #[arg(long)]
    quick: bool,
}

/// The factor on the repetitions of measurements of a millisecond, so that some run while a shared machine is idle.
const SHORT_RUN_FACTOR: usize = 8;

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let repetitions = if arguments.quick { 4 } else { 40 };
    let mut results = Results::default();
    // A failed write of the progress does not stop the measurement.
    let say = |what: &str| drop(writeln!(std::io::stderr(), "measuring {what}"));
    say("the functional model");
    models::functional(&mut results, SHORT_RUN_FACTOR * repetitions);
    models::batches(&mut results, SHORT_RUN_FACTOR * repetitions);
    models::rays(&mut results, SHORT_RUN_FACTOR * repetitions);
    say("the cycle-exact model");
    models::cycle_exact(&mut results, SHORT_RUN_FACTOR * repetitions);
    say("the netlist");
    netlist::run(&mut results, repetitions, !arguments.no_verilator)?;
    say("the traversal unit");
    unit::run(&mut results, repetitions, !arguments.no_verilator)?;
    unit::searches(&mut results, repetitions, !arguments.no_verilator)?;
    say("rays, compared with obvhs, and distances");
    peers::rays(&mut results, repetitions)?;
    peers::distances(&mut results, repetitions)?;
    say("the growth of cost with the amount of work");
    growth::run(&mut results, repetitions)?;
    let json = results.json()?;
    if let Some(path) = &arguments.out {
        write_all(&[(path.clone(), &json)])?;
    }
    if arguments.json {
        writeln!(out, "{json}")?
    } else {
        writeln!(out, "{results}")?
    }
    Ok(())
}
