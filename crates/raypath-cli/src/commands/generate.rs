//! `raypath generate`: SystemVerilog, tables, and a comparison of the netlist with the models.

mod unit;

use crate::commands::numbers::number;
use crate::commands::unit::{UnitArguments, not_with_unit};
use crate::{CliError, DatapathArguments, Progress, ask_oracles, whole};
use clap::Args;
use raypath_hdl::verilog;
use raypath_model::Shape;
use raypath_oracle::Checks;
use raypath_rtl::package::Prefix;
use raypath_rtl::report::tables;
use raypath_rtl::{DatapathNetlist, package};
use raypath_sim::OperationId;
use raypath_sim::files::{in_folder, write_design};
use raypath_sim::lockstep::{Comparison, Timing, lockstep, timing};
use raypath_sim::traffic::Traffic;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
#[command(after_help = not_with_unit())]
pub struct Arguments {
    /// The folder to write to [default: build, or build/unit with --unit]
    #[arg(long, default_value = "build", default_value_if("unit", "true", "build/unit"), hide_default_value = true)]
    out: PathBuf,
    /// What the names of all modules, packages and files begin with, for several datapaths in one design
    #[arg(long, value_name = "NAME", default_value = "raypath")]
    prefix: Prefix,
    /// The clock period of the constraints, in nanoseconds
    #[arg(long, default_value_t = package::PERIOD_NS, value_parser = number(0.001..=1e6, "nanoseconds, 0.001 to 1000000"), value_name = "NS")]
    period: f64,
    /// The number of random jobs for the check of the netlist
    #[arg(long, default_value_t = 10_000, value_parser = whole(1..=u32::MAX))]
    jobs: u32,
    /// Seed of the random jobs, stalls and bubbles
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Write the traversal unit around the datapath: a ray goes in, its hit comes out
    #[arg(long, conflicts_with_all = ["specs", "jobs"])]
    unit: bool,
    /// The number of random rays for the check of the unit
    #[arg(long, default_value_t = 1_000, requires = "unit", value_parser = whole(1..=1_000_000_u32))]
    rays: u32,
    #[command(flatten)]
    datapath: DatapathArguments,
    #[command(flatten)]
    unit_parameters: UnitArguments,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    if arguments.unit {
        return unit::run(arguments, out);
    }
    arguments.unit_parameters.expect_none("--unit")?;
    let (config, whole) = arguments.datapath.datapath()?;
    let datapath = whole.elaborate()?;
    let name = arguments.datapath.name(config);
    let specs = &arguments.datapath.specs;
    let jobs = arguments.jobs.min(MAX_CHECKED_JOBS) as usize;
    let checks = Checks { datapath: &whole, netlist: &datapath, specs, seed: arguments.seed, jobs };
    let prefix = &arguments.prefix;
    let mut files =
        in_folder(&arguments.out, prefix.rename(package::design(&datapath, config, &name, arguments.period)?));
    files.extend(checks.files(&arguments.out));
    write_design(&arguments.out, &files)?;

    writeln!(out, "raypath {VERSION}: {name}\n")?;
    writeln!(out, "Schedule (Table VII)\n\n{}\n", tables::schedule(&datapath))?;
    writeln!(out, "Units (Table VIII) and registers, counted in the netlist\n")?;
    writeln!(out, "{}\n", tables::units_and_registers(&datapath, config))?;
    let folder = arguments.out.display();
    let modules = verilog::sources(datapath.top(), &[])?.len();
    writeln!(out, "Wrote {modules} modules to {folder}/rtl, listed in {folder}/{prefix}.f, and all of them to")?;
    writeln!(out, "{folder}/{prefix}.sv, and without structures to {folder}/{prefix}_plain.sv; assertions for")?;
    writeln!(out, "simulators to {folder}/{prefix}_properties.sv; a wrapper whose ports are structures to")?;
    writeln!(out, "{folder}/rtl/{prefix}_wrapper.sv; {folder}/{prefix}.core (FuseSoC) and {folder}/Bender.yml;")?;
    writeln!(out, "constraints (.sdc, .xdc) and IP-XACT (.xml) to {folder}/{prefix}.*; a picture of the pipeline to")?;
    writeln!(out, "{folder}/pipeline.svg.\n")?;
    for spec in specs {
        writeln!(
            out,
            "Wrote jobs of {0} with their outcomes to {folder}/{0}.txt, for `replay --with {0}`.",
            spec.name()
        )?;
    }
    ask_oracles(&checks, out)?;
    check(&whole, &datapath, arguments, out)
}

/// The largest number of jobs of an operation that its oracle checks.
const MAX_CHECKED_JOBS: u32 = 10_000;

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Streams random jobs through the netlist and the models, and measures its timing.
fn check(
    whole: &raypath_sim::Datapath,
    datapath: &DatapathNetlist,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let begin = Instant::now();
    let (seed, total, model) = (arguments.seed, arguments.jobs as usize, whole.model());
    let stream = |kinds: &[OperationId]| raypath_oracle::jobs(whole, &arguments.datapath.specs, seed, kinds);
    let mut netlist = whole.netlist(datapath)?;
    let mut measured = Vec::new();
    for kind in model.kinds() {
        let timing = stream(&[kind]).next().and_then(|job| timing(&mut netlist, &job));
        measured.push((kind, timing));
    }

    netlist.restart_randomly(seed);
    let mut traffic = Traffic::random(seed);
    let mut progress = Progress::new("jobs", total);
    let jobs = stream(&model.kinds()).take(total);
    let found = lockstep(&mut netlist, model.clone(), jobs, &mut traffic, |done| progress.at(done));
    let stopped = progress.finish(found.jobs);
    report(&found, &model.kinds(), begin, out)?;
    if found.different > 0 {
        let problem = format!("netlist and models differ {} times in {} cycles", found.different, found.cycles);
        return Err(CliError::Mismatch(problem));
    }
    stopped?;
    report_timing(&measured, netlist.shape(), out)
}

/// Prints the timing of each kind of job; an error if the models have another timing.
fn report_timing(
    measured: &[(OperationId, Option<Timing>)],
    shape: &Shape,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    for &(kind, timing) in measured {
        let Some(timing) = timing else {
            return Err(CliError::Mismatch(format!(
                "the netlist returned no outcome of a {kind} job in an empty pipeline"
            )));
        };
        let expected =
            Timing { latency: shape.latency as u64, initiation_interval: shape.interval(kind.opcode()) as u64 };
        if timing != expected {
            return Err(CliError::Mismatch(format!("{kind} jobs have {timing}, expected {expected}")));
        }
    }
    let least = shape.interval;
    let slower = measured.iter().filter(|(kind, _)| shape.interval(kind.opcode()) > least);
    let slower: Vec<String> =
        slower.map(|(kind, _)| format!("{} between {kind} jobs", shape.interval(kind.opcode()))).collect();
    let exceptions = if slower.is_empty() { String::new() } else { format!("; {}", slower.join(", ")) };
    let usual = Timing { latency: shape.latency as u64, initiation_interval: least as u64 };
    writeln!(out, "Measured at the ports: {usual}{exceptions}.")?;
    Ok(())
}

fn report(found: &Comparison, kinds: &[OperationId], begin: Instant, out: &mut dyn Write) -> std::io::Result<()> {
    let by_kind: Vec<String> = kinds.iter().map(|kind| format!("{} {kind}", found.jobs_of(*kind))).collect();
    let (jobs, cycles, stalled, different) = (found.jobs, found.cycles, found.stalled, found.different);
    writeln!(out, "Checked {jobs} random jobs ({}) in {cycles} cycles with stalls and bubbles", by_kind.join(", "))?;
    writeln!(
        out,
        "({stalled} cycles held the source back): {different} mismatches between netlist, cycle-exact and functional \
         model. {:.2} s",
        begin.elapsed().as_secs_f64()
    )?;
    found.differences.iter().try_for_each(|difference| writeln!(out, "  {difference}"))
}
