//! `raypath explore`: area and timing of many configurations, all of them or those that a search needs.

mod against;
mod exact;
mod search;
mod space;

use crate::commands::full::division::DivisionArguments;
use crate::commands::full::measuring::BenchArguments;
use crate::commands::full::ppa::{self, design};
use crate::error::CliError;
use clap::Args;
use raypath_ppa::charts::scatter;
use raypath_ppa::tables::explored;
use raypath_ppa::{Baseline, Design, DesignPoint, Exploration, Report};
use raypath_rtl::{Config, PRESETS, Preset};
use raypath_sim::configuration;
use raypath_sim::files::write_all;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    /// A configuration by name; may be given several times [default: all; with a search paper, and it searches around
    /// each]
    #[arg(long)]
    preset: Vec<Preset>,
    /// Configurations as a TOML file: a list of values for each parameter, all combinations of which are measured, or
    /// searched
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    sweep: Option<PathBuf>,
    #[command(flatten)]
    bench: BenchArguments,
    #[command(flatten)]
    division: DivisionArguments,
    #[command(flatten)]
    search: search::SearchArguments,
    /// Print a table in Markdown with area and slowest stage as multiples of another design's, whose reports are
    /// DIR/lanes-none/ppa.json, DIR/lanes-16/ppa.json and so on; without a report a row has no multiples
    #[arg(long, value_name = "DIR", conflicts_with_all = ["json", "goal", "objective"])]
    against: Option<PathBuf>,
    /// The folder to write explore.json, explore.svg or explore.html, and each configuration's report to
    #[arg(long, default_value = "build/explore", value_name = "DIR")]
    out: PathBuf,
    /// Print the results as JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    if arguments.search.is_wanted() {
        return search::run(arguments, out);
    }
    let configurations = configurations(arguments)?;
    // Read first, so that an error is reported before minutes of work.
    let baselines: Vec<Option<Baseline>> = match &arguments.against {
        Some(folder) => {
            configurations.iter().map(|(_, config)| against::baseline(folder, *config)).collect::<Result<_, _>>()?
        }
        None => Vec::new(),
    };
    let reports = match measured(arguments, &configurations)? {
        Measured::All(reports) => reports,
        Measured::Shard(message) => return Ok(writeln!(out, "{message}")?),
    };
    let points = configurations.iter().zip(reports);
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
    if arguments.against.is_some() {
        let configs = configurations.iter().map(|(_, config)| *config);
        let rows: Vec<_> = exploration.points.iter().zip(configs).zip(&baselines).collect();
        writeln!(out, "{}", against::table(&rows)?)?;
    } else {
        writeln!(out, "{}\n", explored(&exploration))?;
    }
    writeln!(out, "Wrote {0}/explore.json, {0}/explore.svg and each report to {0}/NAME.", folder.display())?;
    Ok(())
}

enum Measured {
    /// The reports of all configurations.
    All(Vec<Report>),
    /// The message that those of a shard are written.
    Shard(String),
}

/// Measures the configurations of the shard, or takes the results of all shards.
fn measured(arguments: &Arguments, configurations: &[(String, Config)]) -> Result<Measured, CliError> {
    const TASK: &str = "explore";
    let names: Vec<&str> = configurations.iter().map(|(name, _)| name.as_str()).collect();
    let mut division = arguments.division.begin_whole(format!("explore {}", names.join(", ")))?;
    let mut parts = division.parts(TASK)?;
    let begin = Instant::now();
    let shards = parts.phase(|| {
        let shard = arguments.division.shard();
        let (numbers, designs): (Vec<u64>, Vec<Design>) = (0..)
            .zip(configurations)
            .filter(|(number, _)| shard.takes(*number))
            .map(|(number, (_, config))| Ok((number, design(*config)?)))
            .collect::<Result<_, CliError>>()?;
        let reports = arguments.bench.measure(&designs)?;
        Ok::<Vec<(u64, Report)>, CliError>(numbers.into_iter().zip(reports).collect())
    })?;
    division.keep(TASK, parts, begin.elapsed().as_secs_f64());
    if let Some(message) = division.write()? {
        return Ok(Measured::Shard(message));
    }
    let reports: BTreeMap<u64, Report> = shards.into_iter().flatten().collect();
    Ok(Measured::All(reports.into_values().collect()))
}

fn configurations(arguments: &Arguments) -> Result<Vec<(String, Config)>, CliError> {
    if let Some(path) = &arguments.sweep {
        return Ok(configuration::sweep(path)?);
    }
    let chosen = if arguments.preset.is_empty() { PRESETS } else { &arguments.preset };
    Ok(chosen.iter().map(|preset| (preset.name.to_string(), preset.config)).collect())
}
