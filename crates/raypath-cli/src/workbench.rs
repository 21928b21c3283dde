//! The command line of a crate that adds an operation.
//!
//! An operation is one function over [`Circuit`](raypath_ops::Circuit), with its pipeline stages marked (or left to
//! [`auto`](raypath_ops::Circuit::auto)). Ports, opcode, units, registers, SystemVerilog, models, checks and cost are
//! derived from this function. [`main`] prints them for one operation. The same, step by step:
//!
//! ```
//! use raypath_cli::prelude::*;
//! use raypath_cli::Cost;
//! use raypath_cli::oracle::{AnyOperationSpec, Checks};
//!
//! bundle! {
//!     /// A point and a plane: those p with normal · p = offset.
//!     pub struct Side<C> {
//!         /// The point.
//!         pub point: Vec3<C>,
//!         /// The plane's normal, of any length.
//!         pub normal: Vec3<C>,
//!         /// The plane's position along the normal.
//!         pub offset: Num<C>,
//!     }
//! }
//!
//! bundle! {
//!     /// The side of the point.
//!     pub struct Above<C> {
//!         /// normal · p - offset; divided by the normal's length it is the distance.
//!         pub height: Num<C>,
//!         /// Whether the height is above 0.
//!         pub is_above: Bit<C>,
//!     }
//! }
//!
//! /// The side of a plane on which a point lies.
//! struct PointPlane;
//!
//! impl Operation for PointPlane {
//!     const NAME: &'static str = "point_plane";
//!     type Input<C: Circuit> = Side<C>;
//!     type Output<C: Circuit> = Above<C>;
//!     type State<C: Circuit> = ();
//!
//!     fn run<C: Circuit>(&self, c: C, Side { point, normal, offset }: Side<C>, _: ()) -> (Above<C>, ()) {
//!         c.stage(3, "products");
//!         let (x, y, z) = (point.x * normal.x, point.y * normal.y, point.z * normal.z);
//!         c.stage(4, "x + y, z - offset");
//!         let (xy, z) = (x + y, z - offset);
//!         c.stage(6, "their sum");
//!         let height = xy + z;
//!         (Above { height, is_above: height.is_above_zero() }, ())
//!     }
//! }
//!
//! // Added to the paper's four operations, it needs no further unit.
//! let datapath = Datapath::paper(Default::default()).with(PointPlane);
//! let netlist = datapath.elaborate()?;
//! assert_eq!(netlist.latency(), 12);
//! assert_eq!(Cost::of(&datapath, "point_plane")?.added_units(), Default::default());
//!
//! // One job in the functional model: a point 2 above the plane z = 1.
//! let side = Side { point: [5.0, 5.0, 3.0].into(), normal: [0.0, 0.0, 1.0].into(), offset: 1.0.into() };
//! let (above, ()) = PointPlane.run(Binary32, side, ());
//! assert_eq!((f32::from(above.height), bool::from(above.is_above)), (2.0, true));
//!
//! // The same job in the cycle-exact model.
//! let mut cycles = datapath.cycle_model()?;
//! let job = datapath.model().job_of::<PointPlane>(&side).expect("one of its operations");
//! assert!(cycles.cycle(Some(&job), true).accepted);
//! assert_eq!(1 + cycles.idle(100), 12);
//! let outcome = cycles.output().expect("an answer");
//! assert_eq!(datapath.model().output_of::<PointPlane>(outcome).map(|above| f32::from(above.height)), Some(2.0));
//!
//! // Random jobs compared with an oracle, and the netlist compared with both models in every cycle.
//! let spec = OperationSpec::of(PointPlane).oracle("the sign alone", |_, answer| {
//!     let height = f32::from(answer.height);
//!     if bool::from(answer.is_above) == (height > 0.0) { Ok(()) } else { Err(format!("at {height}")) }
//! });
//! let specs = [AnyOperationSpec::from(spec)];
//! let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 1, jobs: 200 };
//! assert_eq!(checks.against_the_oracles()[0].wrong, 0);
//! assert_eq!(checks.against_the_models(|_| true)?.different, 0);
//! # Ok::<(), raypath_cli::CliError>(())
//! ```

use crate::commands::exit;
pub use crate::cost::{Cost, Figures};
pub use crate::error::CliError;
use crate::{Progress, Stopped, ask_oracles, is_stopped, require_right};
use clap::Parser;
use raypath_oracle::AnyOperationSpec;
use raypath_oracle::Checks;
use raypath_rtl::report::tables;
use raypath_rtl::{Config, Preset, package};
use raypath_sim::Datapath;
use raypath_sim::files::{FileError, in_folder, write_all};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Adds the operation to a datapath: writes SystemVerilog, checks it against its oracle, the models and Verilator, and
/// prints its cost.
#[derive(Debug, Clone, Parser)]
#[command(
    override_usage = "NAME [OPTIONS]\n       NAME <COMMAND of raypath> --with NAME [OPTIONS]",
    after_help = "Commands of raypath, such as `generate`, `replay`, `wave`, `ppa`, `fpga` and `verify`, take the \
                  operation with `--with NAME`; most need `cargo run --release --features full -- COMMAND`.\n\n\
                  Exit codes: 0 success, 1 a wrong result, 2 wrong input, 130 stopped by Ctrl-C."
)]
pub struct Arguments {
    /// The configuration to add it to; `raypath configs` lists them
    #[arg(long, value_name = "NAME", default_value = "paper")]
    pub preset: Preset,
    /// Build a datapath with this operation only
    #[arg(long)]
    pub alone: bool,
    /// The number of random jobs, from 1 to 100000; all are in memory at once
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub jobs: u32,
    /// Seed of jobs, bubbles and stalls
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to write to
    #[arg(long, default_value = "build", value_name = "DIR")]
    pub out: PathBuf,
    /// The folder of cached measurements
    #[arg(long, default_value = "build/ppa-cache", value_name = "DIR")]
    pub cache: PathBuf,
    /// Skip the steps that need other programs: lint, Verilator, area
    #[arg(long)]
    pub quick: bool,
    /// Fail if a required program is not installed, instead of skipping its step
    #[arg(long, conflicts_with = "quick")]
    pub strict: bool,
}

/// Runs the command line for an operation: the body of `main` in a crate that adds one. If the first argument is a
/// command of `raypath`, that command runs, in which `--with` and the name select the operation.
pub fn main(spec: impl Into<AnyOperationSpec>) -> ExitCode {
    let spec = spec.into();
    if std::env::args_os().nth(1).is_some_and(|first| !first.as_encoded_bytes().starts_with(b"-")) {
        return match raypath_oracle::add_operation(spec) {
            Ok(()) => crate::main(),
            Err(problem) => exit(|_| Err(CliError::unusable(problem))).into(),
        };
    }
    exit(|out| run(&spec, &Arguments::parse(), out)).into()
}

/// Schedules, writes, checks and measures the operation, and prints the results to `out`.
///
/// # Errors
/// The operation does not fit the datapath, a result is wrong, a file cannot be written, or a tool fails; with `strict`
/// also if a tool is not installed.
pub fn run(spec: &AnyOperationSpec, arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.preset.config;
    let base = if arguments.alone {
        Datapath::new().built_as(config.microarchitecture).format(config.semantics.format)
    } else {
        Datapath::paper(config)
    };
    let datapath = base.with_any(spec.operation());
    let netlist = datapath.elaborate()?;

    writeln!(out, "{}: {}\n", spec.name(), in_words(spec, arguments, config))?;
    writeln!(out, "Schedule\n\n{}\n", tables::schedule_of(&netlist, spec.name()))?;
    let mut cost = Cost::of(&datapath, spec.name())?;

    let specs = std::slice::from_ref(spec);
    let jobs = arguments.jobs as usize;
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs, seed: arguments.seed, jobs };
    write(&checks, spec, arguments, out)?;
    check(&checks, spec, arguments, out)?;
    if !arguments.quick {
        match cost.measured(&datapath, spec.name(), &arguments.cache) {
            Ok(measured) => cost = measured,
            Err(error) => tolerate(error, "no area", arguments, out)?,
        }
    }
    writeln!(out, "\nCost\n\n{}", cost.table())?;
    Ok(())
}

fn in_words(spec: &AnyOperationSpec, arguments: &Arguments, config: Config) -> String {
    let place = if arguments.alone { "alone".to_string() } else { format!("in the datapath '{}'", arguments.preset) };
    let purpose = spec.purpose();
    let what = if purpose.is_empty() { String::new() } else { format!("{purpose}; ") };
    format!("{what}{place} ({config})")
}

fn write(
    checks: &Checks<'_>,
    spec: &AnyOperationSpec,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let config = checks.datapath.config();
    let description = format!("{config}, with {}", spec.name());
    let mut files =
        in_folder(&arguments.out, package::design(checks.netlist, config, &description, package::PERIOD_NS)?);
    files.extend(checks.files(&arguments.out));
    write_all(&files)?;
    let (folder, name) = (arguments.out.display(), spec.name());
    writeln!(out, "Wrote {folder}/raypath.sv, its modules to {folder}/rtl, its schedule to {folder}/pipeline.svg;")?;
    writeln!(out, "jobs with their results, for other test benches, to {folder}/{name}.txt.")?;
    Ok(())
}

fn check(
    checks: &Checks<'_>,
    spec: &AnyOperationSpec,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    ask_oracles(checks, out)?;

    let mut progress = Progress::new("jobs", checks.jobs);
    let found = checks.against_the_models(|done| progress.at(done))?;
    let stopped = progress.finish(found.jobs);
    let (jobs, lost, cycles, different) = (found.jobs + found.lost, found.lost, found.cycles, found.different);
    writeln!(
        out,
        "Netlist: {jobs} jobs of all operations in {cycles} cycles, {lost} of them lost in resets, {different} \
         mismatches with the models."
    )?;
    same(different, &found.differences, "netlist and models", out)?;
    stopped?;

    if arguments.quick {
        return Ok(());
    }
    let folder = tempfile::tempdir().map_err(|problem| {
        let path = std::env::temp_dir();
        FileError { path, doing: "make a folder in it", problem }
    })?;
    let simulated = checks.in_verilator(folder.path());
    if is_stopped() {
        // Ctrl-C also ends the tool, which then reports a failure.
        return Err(Stopped { done: 0, total: 1, what: "simulations" }.into());
    }
    match simulated {
        Ok(found) => {
            let (cycles, different) = (found.cycles, found.different);
            writeln!(out, "Lint: Verilator, Yosys and slang report nothing.")?;
            write!(out, "Verilator: {cycles} cycles, {different} mismatches with the cycle-exact model")?;
            match found.reports.first() {
                Some(report) => {
                    writeln!(out, "; the oracle finds {1} of {0} results wrong.", report.jobs, report.wrong)?
                }
                None => writeln!(out, ".")?,
            }
            same(different, &found.faults, "Verilator and the cycle-exact model", out)?;
            found.reports.iter().try_for_each(|report| require_right(report, spec.name(), out))
        }
        Err(error) => tolerate(error.into(), "no simulation in Verilator", arguments, out),
    }
}

fn same(different: usize, faults: &[String], compared: &str, out: &mut dyn Write) -> Result<(), CliError> {
    faults.iter().try_for_each(|fault| writeln!(out, "  {fault}"))?;
    match different {
        0 => Ok(()),
        _ => Err(CliError::Mismatch(format!("{compared} differ {different} times"))),
    }
}

/// Reports a tool that is not installed and continues, except with `--strict`.
fn tolerate(error: CliError, without: &str, arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    if arguments.strict || !error.is_missing_tool() {
        return Err(error);
    }
    writeln!(out, "{error}; {without} without it.")?;
    Ok(())
}
