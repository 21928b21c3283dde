//! `raypath fpga`: the datapath on an FPGA.

use crate::commands::full::measuring::RESUMES;
use crate::commands::full::ppa::json;
use crate::{CliError, DatapathArguments, Progress, Stopped, number, whole};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use raypath_fpga::{Comparison, Device, Flow, Host, Implementation, Shell, StreamWidth, Target, tables};
use raypath_hdl::verilog;
use raypath_model::Model;
use raypath_rtl::Config;
use raypath_sim::files::write_all;
use raypath_sim::{Datapath, Words, jobs};
use raypath_tools::{Nextpnr, Options, Sources, ToolError, VerilatedStream, Yosys, temporary_folder};
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    datapath: DatapathArguments,
    /// The FPGA: ecp5-25k, ecp5-45k or ecp5-85k
    #[arg(long, default_value = "ecp5-85k")]
    device: Device,
    /// Its speed grade; 6 is the slowest
    #[arg(long, default_value_t = 6, value_parser = whole(6_u8..=8))]
    speed: u8,
    /// The clock that placement and routing aim at, in MHz; not a limit
    #[arg(long, default_value_t = 70.0, value_parser = number(1.0..=1000.0, "MHz, 1 to 1000"), value_name = "MHZ")]
    clock: f64,
    /// Seed of the placement
    #[arg(long, default_value_t = 1)]
    placement: u32,
    /// The bits of a word of the streams around the datapath
    #[arg(long, default_value = "8", value_parser = stream(), value_name = "BITS")]
    stream: StreamWidth,
    /// Instead of an implementation, run random jobs through the shell in Verilator, as a host does
    #[arg(long, conflicts_with = "connect")]
    loopback: bool,
    /// Instead of an implementation, send random jobs to a board: a serial device, for example, already set up
    #[arg(long, value_name = "FILE")]
    connect: Option<PathBuf>,
    /// The number of random jobs for --loopback and --connect, from 1 to 1000000
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    jobs: u32,
    /// Seed of the random jobs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The folder of cached results
    #[arg(long, default_value = "build/ppa-cache", value_name = "DIR")]
    cache: PathBuf,
    /// The folder to write the shell's text, fpga.json, shell.config and shell.bit to
    #[arg(long, default_value = "build/fpga", value_name = "DIR")]
    out: PathBuf,
    /// Print the report as JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// A parser of the widths of streams.
fn stream() -> impl TypedValueParser<Value = StreamWidth> {
    let width = |bits: String| if bits == "8" { StreamWidth::Eight } else { StreamWidth::ThirtyTwo };
    PossibleValuesParser::new(["8", "32"]).map(width)
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let (config, datapath) = arguments.datapath.datapath()?;
    let elaborated = datapath.elaborate()?;
    let shell = Shell::new(elaborated.top(), arguments.stream)?;
    match &arguments.connect {
        Some(path) if path.metadata().is_ok_and(|found| found.is_file() && found.len() > 0) => {
            let problem =
                format!("--connect {}: a file, which jobs would overwrite, expected a device", path.display());
            Err(CliError::unusable(problem))
        }
        Some(path) => {
            let board = |host: &Host<'_>, jobs: &[Words], outcomes: &[Words]| {
                let open = |options: &mut std::fs::OpenOptions, doing| {
                    options.open(path).map_err(|problem| ToolError::file(path, doing, problem))
                };
                let to = open(File::options().write(true), "write")?;
                let from = open(File::options().read(true), "read")?;
                let failed = |problem| ToolError::file(path, "exchange jobs with", problem);
                host.compare(jobs, outcomes, to, from).map_err(failed)
            };
            compare(arguments, config, &datapath, &shell, board, out)
        }
        None if arguments.loopback => compare(
            arguments,
            config,
            &datapath,
            &shell,
            |host, jobs, outcomes| {
                let folder = temporary_folder()?;
                let mut sources = Sources::write(&shell.top, folder.path())?;
                let properties = elaborated.properties().to_string();
                sources.add(folder.path().join("raypath_properties.sv"), &properties)?;
                let (files, options) = (&sources.files, Options::default());
                let stream = VerilatedStream::build(files, &shell.top, folder.path(), &options)?;
                stream.run(arguments.seed as u32, |to, from| host.compare(jobs, outcomes, to, from))
            },
            out,
        ),
        None => implement(arguments, config, &shell, out),
    }
}

fn implement(arguments: &Arguments, config: Config, shell: &Shell, out: &mut dyn Write) -> Result<(), CliError> {
    let Arguments { device, speed, clock, placement, cache, out: folder, .. } = arguments;
    let flow = Flow { yosys: Yosys::find(None)?, nextpnr: Nextpnr::find()?, cache: cache.clone() };
    let target = Target { device: *device, speed: *speed, clock_mhz: *clock, seed: *placement };
    let name = arguments.datapath.name(config);
    let mut reached = 0;
    let mut progress = Progress::new("steps", 3);
    let implemented = flow.implement(&name, shell, target, |steps| {
        reached = steps.done as usize;
        progress.at(reached)
    });
    match progress.finish(reached) {
        Ok(()) => {}
        Err(Stopped { .. }) if implemented.is_ok() => {}
        Err(stopped) => return Err(CliError::Stopped(format!("{stopped}; {RESUMES}"))),
    }
    let Implementation { report, configuration, bitstream } = implemented?;
    let mut text = String::new();
    verilog::sources(&shell.top, &[])?.into_iter().for_each(|source| text += &source.text);
    let file = |name: &str, bytes: Vec<u8>| (folder.join(name), bytes);
    write_all(&[
        file("raypath_shell.sv", text.into()),
        file("fpga.json", (json(&report)? + "\n").into()),
        file("shell.config", configuration.into()),
        file("shell.bit", bitstream),
    ])?;
    if arguments.json {
        writeln!(out, "{}", json(&report)?)?;
        return Ok(());
    }
    writeln!(out, "raypath {}: {name}\n", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "{}\n\n{}\n", tables::stages(&report), tables::path(&report))?;
    writeln!(out, "{}", tables::summary(&report))?;
    if report.cells.multipliers == 0 {
        writeln!(out, "Multipliers are gates; with --multiplier inferred they are those of the FPGA.")?;
    }
    let files = ["raypath_shell.sv", "fpga.json", "shell.config", "shell.bit"].join(", ");
    writeln!(out, "\nWrote {files} to {}.", folder.display())?;
    Ok(())
}

/// Runs random jobs through a shell at the other end of a stream.
fn compare(
    arguments: &Arguments,
    config: Config,
    datapath: &Datapath,
    shell: &Shell,
    exchange: impl FnOnce(&Host<'_>, &[Words], &[Words]) -> Result<Comparison, ToolError>,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let mut model = datapath.model();
    let jobs: Vec<Words> = jobs::any_jobs(datapath.model(), arguments.seed).take(arguments.jobs as usize).collect();
    let outcomes: Vec<Words> = jobs.iter().map(|job| model.run(job)).collect();
    let host = Host::new(shell, config);
    let Comparison { received, different, differences } = exchange(&host, &jobs, &outcomes)?;
    differences.iter().try_for_each(|difference| writeln!(out, "{difference}"))?;
    let sent = jobs.len();
    writeln!(
        out,
        "{sent} jobs of {} bytes, {received} outcomes of {} bytes, {different} different from the model.",
        shell.job.bytes(),
        shell.outcome.bytes()
    )?;
    match different + (sent - received) {
        0 => Ok(()),
        wrong => Err(CliError::Mismatch(format!("{wrong} of {sent} outcomes are wrong or missing"))),
    }
}
