//! `raypath bench`: how fast the models are, beside Verilator on the same hardware and obvhs on the same rays.

mod growth;
mod models;
mod netlist;
mod peers;
mod result;
mod stopwatch;
mod workload;

use crate::commands::output::write_all;
use crate::error::CliError;
use clap::Args;
use result::Results;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Print JSON, not a table
    #[arg(long)]
    json: bool,
    /// Write the JSON to a file too
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Leave Verilator out, whose C++ takes minutes to compile; otherwise it is measured where it is installed
    #[arg(long)]
    no_verilator: bool,
    /// A tenth of the repetitions: for a look, not for figures to quote
    #[arg(long)]
    quick: bool,
}

/// What takes a thousandth of a second is repeated so much more often: machines that others use are slow for a while.
const LONGER: usize = 8;

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let repetitions = if arguments.quick { 4 } else { 40 };
    let mut results = Results::default();
    let say = |what: &str| writeln!(std::io::stderr(), "measuring {what}");
    // A failed write of the progress does not stop the measurement.
    let _ = say("the functional model");
    models::functional(&mut results, LONGER * repetitions);
    models::batches(&mut results, LONGER * repetitions);
    models::rays(&mut results, LONGER * repetitions);
    let _ = say("the cycle-exact model");
    models::cycle_exact(&mut results, LONGER * repetitions);
    let _ = say("the netlist");
    netlist::run(&mut results, repetitions, !arguments.no_verilator)?;
    let _ = say("rays beside obvhs, and distances");
    peers::rays(&mut results, repetitions)?;
    peers::distances(&mut results, repetitions)?;
    let _ = say("how cost grows");
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
