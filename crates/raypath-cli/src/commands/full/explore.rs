//! `raypath explore`: area and timing of many configurations.

use crate::commands::full::measuring::BenchArguments;
use crate::commands::full::ppa::{self, design};
use crate::error::CliError;
use clap::Args;
use raypath_ppa::charts::scatter;
use raypath_ppa::tables::explored;
use raypath_ppa::{DesignPoint, Exploration};
use raypath_rtl::{Config, PRESETS, Preset};
use raypath_sim::configuration;
use raypath_sim::files::write_all;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// A configuration by name; may be given several times [default: all]
    #[arg(long)]
    preset: Vec<Preset>,
    /// Configurations as a TOML file: a list of values for each parameter, all combinations of which are measured
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    sweep: Option<PathBuf>,
    #[command(flatten)]
    bench: BenchArguments,
    /// The folder to write explore.json, explore.svg and each configuration's report to
    #[arg(long, default_value = "build/explore", value_name = "DIR")]
    out: PathBuf,
    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let configurations = configurations(arguments)?;
    let designs = configurations.iter().map(|(_, config)| design(*config)).collect::<Result<Vec<_>, _>>()?;
    let reports = arguments.bench.measure(&designs)?;
    let points = configurations.into_iter().zip(reports);
    let points = points
        .map(|((name, config), report)| {
            DesignPoint::new(name, config.options(), config.semantics.lanes.count(), report)
        })
        .collect();
    let exploration = Exploration { points };

    let mut files = Vec::new();
    for point in &exploration.points {
        files.extend(ppa::files(&point.report, &arguments.out.join(&point.name))?);
    }
    let folder = &arguments.out;
    files.push((folder.join("explore.json"), ppa::json(&exploration)? + "\n"));
    files.push((folder.join("explore.svg"), scatter(&exploration)));
    write_all(&files)?;
    if arguments.json {
        writeln!(out, "{}", ppa::json(&exploration)?)?;
        return Ok(());
    }
    writeln!(out, "{}\n", explored(&exploration))?;
    writeln!(out, "Wrote {0}/explore.json, {0}/explore.svg and each report to {0}/NAME.", folder.display())?;
    Ok(())
}

fn configurations(arguments: &Arguments) -> Result<Vec<(String, Config)>, CliError> {
    if let Some(path) = &arguments.sweep {
        return Ok(configuration::sweep(path)?);
    }
    let chosen = if arguments.preset.is_empty() { PRESETS } else { &arguments.preset };
    Ok(chosen.iter().map(|preset| (preset.name.to_string(), preset.config)).collect())
}
