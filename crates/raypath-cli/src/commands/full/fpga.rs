//! `raypath fpga`: the datapath, or the traversal unit, on an FPGA.

use crate::commands::full::measuring::resumable;
use crate::commands::full::ppa::json;
use crate::commands::unit::{UnitArguments, not_with_unit};
use crate::{CliError, DatapathArguments, number, whole};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use raypath_fpga::{
    Comparison, Device, Flow, Host, Implementation, Project, Report, Shell, StreamWidth, Target, reduced, tables,
};
use raypath_hdl::{Module, verilog};
use raypath_model::Model;
use raypath_rtl::Config;
use raypath_sim::files::write_all;
use raypath_sim::{Datapath, Words, jobs};
use raypath_tools::{Options, Sources, ToolError, VerilatedStream, Yosys, temporary_folder};
use raypath_traversal::UnitNetlist;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Args)]
#[command(after_help = not_with_unit())]
pub struct Arguments {
    #[command(flatten)]
    datapath: DatapathArguments,
    /// Place and route the traversal unit with this datapath inside, between two shift registers
    #[arg(long, conflicts_with_all = ["loopback", "connect", "stream"])]
    unit: bool,
    #[command(flatten)]
    parameters: UnitArguments,
    /// The FPGA: ecp5-25k, ecp5-45k or ecp5-85k; or xilinx-7 or xilinx-ultrascale-plus, for the cells without a clock
    #[arg(long, default_value = "ecp5-85k")]
    device: Device,
    /// Its speed grade; 6 is the slowest. Other grades after the first are placed and routed for their clocks only
    #[arg(long, default_value = "6", value_parser = whole(6_u8..=8), value_delimiter = ',', value_name = "GRADE,...")]
    speed: Vec<u8>,
    /// The clock that placement and routing aim at, in MHz; not a limit
    #[arg(long, default_value_t = 70.0, value_parser = number(1.0..=1000.0, "MHz, 1 to 1000"), value_name = "MHZ")]
    clock: f64,
    /// Seed of the placement
    #[arg(long, default_value_t = 1)]
    placement: u32,
    /// Place and route with this number of seeds, from --placement on, and keep the fastest; from 1 to 1000
    #[arg(long, default_value_t = 1, value_parser = whole(1_u32..=1000))]
    seeds: u32,
    /// Instead of an implementation, write a project for Vivado or Quartus: vivado or quartus
    #[arg(long, conflicts_with_all = ["loopback", "connect"])]
    project: Option<Project>,
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
    if arguments.unit {
        let parameters = arguments.parameters.parameters();
        let unit = UnitNetlist::new(config, parameters).map_err(CliError::unusable)?;
        let name = format!("traversal unit, {parameters}, around {}", arguments.datapath.name(config));
        return report(arguments, &name, &unit.top, || Ok(reduced(&unit.top)?), out);
    }
    arguments.parameters.expect_none("--unit")?;
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
        None => {
            let name = arguments.datapath.name(config);
            report(arguments, &name, elaborated.top(), || Ok(shell.top.clone()), out)
        }
    }
}

/// Writes a project, or the report of a design with its files: in its shell, with a bitstream, or on Xilinx's alone.
fn report(
    arguments: &Arguments,
    name: &str,
    design: &Arc<Module>,
    shell: impl FnOnce() -> Result<Arc<Module>, CliError>,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let Arguments { device, clock, out: folder, placement, .. } = arguments;
    let text = |module| -> Result<String, CliError> {
        Ok(verilog::sources(module, &[])?.into_iter().map(|source| source.text).collect())
    };
    let write = |files: Vec<(String, Vec<u8>)>| -> Result<String, CliError> {
        let names = files.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        write_all(&files.into_iter().map(|(name, bytes)| (folder.join(name), bytes)).collect::<Vec<_>>())?;
        Ok(format!("Wrote {names} to {}.", folder.display()))
    };
    if let Some(project) = arguments.project {
        let files = project.files(design, &text(design)?, *clock).map(|(name, text)| (name, text.into()));
        return Ok(writeln!(out, "{} Not run here; project.tcl says how.", write(files.into())?)?);
    }
    let top = if device.is_xilinx() { design.clone() } else { shell()? };
    let seeds = *placement..placement.saturating_add(arguments.seeds);
    let target = |speed: &u8, seed| Target { device: *device, speed: *speed, clock_mhz: *clock, seed };
    let targets = arguments.speed.iter().flat_map(|speed| seeds.clone().map(move |seed| target(speed, seed)));
    let targets: Vec<Target> = targets.collect();
    let flow = Flow { yosys: Yosys::find(None)?, cache: arguments.cache.clone() };
    let Implementation { report, configuration, bitstream } =
        resumable(|watch| Ok(flow.implement(name, &top, &targets, watch)?))?;
    let mut files = vec![
        (format!("{}.sv", top.name()), text(&top)?.into()),
        ("fpga.json".to_string(), (json(&report)? + "\n").into()),
        ("shell.config".to_string(), configuration.into()),
        ("shell.bit".to_string(), bitstream),
    ];
    files.retain(|(_, bytes): &(_, Vec<u8>)| !bytes.is_empty());
    let written = write(files)?;
    if arguments.json {
        return Ok(writeln!(out, "{}", json(&report)?)?);
    }
    show(&report, out)?;
    Ok(writeln!(out, "\n{written}")?)
}

fn show(report: &Report, out: &mut dyn Write) -> Result<(), CliError> {
    writeln!(out, "raypath {}: {}\n", env!("CARGO_PKG_VERSION"), report.design)?;
    writeln!(out, "{}\n", tables::stages(report))?;
    if let Some(routed) = &report.routed {
        writeln!(out, "{}\n", tables::path(routed))?;
        writeln!(out, "{}\n", tables::runs(routed))?;
    }
    writeln!(out, "{}", tables::summary(report))?;
    if report.cells.multipliers == 0 {
        writeln!(out, "Multipliers are gates; with --multiplier inferred they are those of the FPGA.")?;
    }
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
