//! `raypath ppa`: area and timing of the datapath in a cell library.

use crate::commands::full::BenchArguments;
use crate::commands::unit::UnitArguments;
use crate::{CliError, DatapathArguments};
use clap::Args;
use raypath_ppa::{Baseline, Design, Report, charts, tables};
use raypath_rtl::{Config, Datapath};
use raypath_sim::files::write_all;
use raypath_unit::UnitNetlist;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    datapath: DatapathArguments,
    /// Measure the traversal unit with this datapath inside; its parts are the stages
    #[arg(long)]
    unit: bool,
    #[command(flatten)]
    parameters: UnitArguments,
    #[command(flatten)]
    bench: BenchArguments,
    /// Compare with the report in this folder (its ppa.json)
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// The folder to write ppa.json and ppa.svg to
    #[arg(long, default_value = "build/ppa", value_name = "DIR")]
    out: PathBuf,
    /// Print the report as JSON instead of tables
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    // Read first, so that an error is reported before minutes of work.
    let baseline = arguments.against.as_deref().map(Baseline::read).transpose()?;
    let reports = arguments.bench.measure(&[arguments.design()?])?;
    for report in reports {
        write_all(&files(&report, &arguments.out)?)?;
        if arguments.json {
            writeln!(out, "{}", json(&report)?)?;
        } else {
            show(&report, baseline.as_ref(), arguments, out)?;
        }
    }
    Ok(())
}

impl Arguments {
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
    writeln!(out, "\nWrote {0}/ppa.json and {0}/ppa.svg.", arguments.out.display())?;
    Ok(())
}

pub fn design(config: Config) -> Result<Design, CliError> {
    Ok(Design::new(config.to_string(), Datapath::new(config)?.top()))
}

/// The files of a report.
pub fn files(report: &Report, folder: &std::path::Path) -> Result<Vec<(PathBuf, String)>, CliError> {
    Ok(vec![(folder.join("ppa.json"), json(report)? + "\n"), (folder.join("ppa.svg"), charts::stages(report))])
}

pub fn json(report: &impl serde::Serialize) -> Result<String, CliError> {
    serde_json::to_string_pretty(report).map_err(|problem| CliError::unusable(format!("JSON: {problem}")))
}
