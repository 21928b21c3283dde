//! `raypath ppa`: area, timing and power of the datapath in a cell library.

mod jobs;
mod power;

use crate::commands::full::BenchArguments;
use crate::commands::full::measuring::resumable;
use crate::commands::unit::{UnitArguments, not_with_unit};
use crate::{CliError, DatapathArguments};
use clap::Args;
use jobs::JobArguments;
pub use power::picture;
use raypath_ppa::{Baseline, Design, PowerResults, Report, charts, tables};
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::files::write_all;
use raypath_traversal::UnitNetlist;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = not_with_unit())]
pub struct Arguments {
    #[command(flatten)]
    subject: Subject,
    /// Compare with the report in this folder (its ppa.json)
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// The folder to write ppa.json and ppa.svg to
    #[arg(long, default_value = "build/ppa", value_name = "DIR")]
    out: PathBuf,
    /// Write the activity of every net in each workload too, as SAIF of about 13 MB
    #[arg(long, requires = "power")]
    saif: bool,
    /// Print the report as JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// A design, and what of it is measured.
#[derive(Debug, Args)]
pub struct Subject {
    #[command(flatten)]
    pub datapath: DatapathArguments,
    /// Measure the traversal unit with this datapath inside; its parts are the stages
    #[arg(long)]
    pub unit: bool,
    #[command(flatten)]
    pub parameters: UnitArguments,
    #[command(flatten)]
    pub bench: BenchArguments,
    /// Measure power too: simulate the gates with real and random jobs
    #[arg(long, conflicts_with = "unit")]
    pub power: bool,
    #[command(flatten)]
    jobs: JobArguments,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    // Read first, so that an error is reported before minutes of work.
    let baseline = arguments.against.as_deref().map(Baseline::read).transpose()?;
    let (report, power) = arguments.subject.measure(arguments.saif)?;
    let mut written = power.map(|measured| power_files(&measured, &arguments.out)).unwrap_or_default();
    written.extend(files(&report, &arguments.out)?);
    write_all(&written)?;
    if arguments.json {
        Ok(writeln!(out, "{}", json(&report)?)?)
    } else {
        show(&report, baseline.as_ref(), arguments, out)
    }
}

impl Subject {
    /// The report, and what belongs to it if power is measured.
    pub fn measure(&self, with_saif: bool) -> Result<(Report, Option<PowerResults>), CliError> {
        let workloads = match self.power {
            true => {
                let (config, datapath) = self.datapath.datapath()?;
                Some(power::workloads(&self.jobs, config, &datapath)?)
            }
            false => None,
        };
        let (design, bench) = (self.design()?, self.bench.bench()?);
        let mut reports = resumable(|watch| bench.measure(std::slice::from_ref(&design), watch))?;
        let mut report = reports.pop().ok_or_else(|| CliError::unusable("no report, expected one"))?;
        let power = |workloads| resumable(|watch| bench.power(&design, &report, workloads, with_saif, watch));
        let measured = workloads.as_deref().map(power).transpose()?;
        report.power = measured.as_ref().map(|measured| measured.power.clone());
        Ok((report, measured))
    }

    fn design(&self) -> Result<Design, CliError> {
        let (config, datapath) = self.datapath.datapath()?;
        let name = self.datapath.name(config);
        if !self.unit {
            self.parameters.expect_none("--unit")?;
            return Ok(Design::new(name, datapath.elaborate()?.top()));
        }
        let parameters = self.parameters.parameters();
        let unit = UnitNetlist::new(config, parameters).map_err(CliError::unusable)?;
        Ok(Design::new(format!("traversal unit, {parameters}, around {name}"), &unit.top))
    }
}

fn show(
    report: &Report,
    baseline: Option<&Baseline>,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    writeln!(out, "raypath {}: {}\n", env!("CARGO_PKG_VERSION"), report.design)?;
    writeln!(out, "Area by stage and kind, µm²\n\n{}\n", tables::areas(report))?;
    writeln!(out, "Units, µm²\n\n{}\n", tables::units(report))?;
    writeln!(out, "The slowest path to each stage\n\n{}\n", tables::paths(report))?;
    writeln!(out, "{}", tables::summary(report))?;
    if let Some(baseline) = baseline {
        writeln!(out, "\nThis divided by {}\n\n{}", baseline.design, tables::comparison(report, baseline))?;
    }
    if let Some(power) = &report.power {
        writeln!(out, "\nEnergy by workload\n\n{}\n", tables::workloads(power))?;
        writeln!(out, "Energy by kind, pJ per cycle\n\n{}\n", tables::energy_by_kind(power))?;
        writeln!(out, "Energy by stage, pJ per cycle\n\n{}\n", tables::energy_by_stage(power))?;
        writeln!(out, "{}", tables::power_summary(power))?;
    }
    writeln!(out, "\nWrote {0}/ppa.json and {0}/ppa.svg.", arguments.out.display())?;
    if report.power.is_some() {
        let saif = if arguments.saif { ", and a .saif file for each workload" } else { "" };
        writeln!(out, "Wrote {0}/power.svg and {0}/gates.v{saif}.", arguments.out.display())?;
    }
    Ok(())
}

/// The gates, and their activity in each workload.
fn power_files(measured: &PowerResults, folder: &std::path::Path) -> Vec<(PathBuf, String)> {
    let plain = |name: &str| name.replace(|c: char| !c.is_ascii_alphanumeric() && c != '.', "_");
    let mut files = vec![(folder.join("gates.v"), measured.netlist.clone())];
    for (name, text) in &measured.activities {
        files.push((folder.join(format!("{}.saif", plain(name))), text.clone()));
    }
    files
}

pub fn design(config: Config) -> Result<Design, CliError> {
    Ok(Design::new(config.to_string(), DatapathNetlist::new(config)?.top()))
}

/// The files of a report.
pub fn files(report: &Report, folder: &std::path::Path) -> Result<Vec<(PathBuf, String)>, CliError> {
    let mut files =
        vec![(folder.join("ppa.json"), json(report)? + "\n"), (folder.join("ppa.svg"), charts::stages(report))];
    files.extend(report.power.as_ref().map(|power| (folder.join("power.svg"), charts::power(report, power))));
    Ok(files)
}

pub fn json(report: &impl serde::Serialize) -> Result<String, CliError> {
    serde_json::to_string_pretty(report).map_err(|problem| CliError::unusable(format!("JSON: {problem}")))
}
