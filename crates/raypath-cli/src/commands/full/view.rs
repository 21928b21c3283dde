//! Options of `render` and `replay` for reports and timelines of a run.

use crate::commands::full::utilisation::{operations, table, utilisation};
use crate::{CliError, whole};
use clap::{ArgGroup, Args};
use raypath_rtl::{Config, DatapathNetlist, parameters};
use raypath_sim::files::write_all;
use raypath_timing::report::{Recorder, Recording, html, konata};
use std::io::Write;
use std::path::PathBuf;

/// Options for reports and timelines.
#[derive(Debug, Args)]
#[command(next_help_heading = "A picture of the pipeline")]
#[command(group = ArgGroup::new("timeline").multiple(true).args(["report", "konata"]))]
pub struct ViewArguments {
    /// Write a page about the run, for a browser: utilisation, and a timeline of the pipeline
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the timeline for the pipeline viewer Konata
    #[arg(long, value_name = "FILE")]
    konata: Option<PathBuf>,
    /// The number of jobs in the timeline
    #[arg(long, requires = "timeline", default_value_t = 2000, value_parser = whole(1..=20_000usize), value_name = "N")]
    window_jobs: usize,
    /// The first cycle of the timeline
    #[arg(long, requires = "timeline", default_value_t = 0, value_parser = whole(0..=u64::MAX), value_name = "CYCLE")]
    window_from: u64,
}

impl ViewArguments {
    /// Whether an output with a timeline is requested.
    pub fn is_wanted(&self) -> bool {
        self.report.is_some() || self.konata.is_some()
    }

    pub fn has_report(&self) -> bool {
        self.report.is_some()
    }

    /// The recorder of the timeline; `owner` is the name of a job's owner. It records no job if no output needs a
    /// timeline.
    pub fn recorder(&self, owner: &str, datapath: &DatapathNetlist) -> Recorder {
        let jobs = if self.is_wanted() { self.window_jobs } else { 0 };
        Recorder::new(owner, datapath.latency() as usize, self.window_from, jobs)
    }

    pub fn files(&self, recording: &Recording) -> Vec<(PathBuf, Vec<u8>)> {
        let page = self.report.iter().map(|path| (path.clone(), html(recording).into_bytes()));
        let log = self.konata.iter().map(|path| (path.clone(), konata(recording).into_bytes()));
        page.chain(log).collect()
    }
}

/// A recording with the configuration and the utilisation by these jobs, indexed by opcode, and nothing else.
pub fn recording(title: String, config: Config, datapath: &DatapathNetlist, cycles: u64, jobs: &[u64]) -> Recording {
    let pair = |name: &str, value: String| (name.to_string(), value);
    let flip_flops: u64 = (0..datapath.steps().count()).map(|step| datapath.registers(step).flip_flops()).sum();
    let parameters = parameters().map(|parameter| pair(&parameter.name.replace('-', " "), parameter.get(&config)));
    let latency = pair("latency", format!("{} cycles", datapath.latency()));
    let configuration = parameters.chain([latency, pair("flip-flops", flip_flops.to_string())]).collect();
    Recording {
        title,
        configuration,
        operations: operations(datapath),
        utilisation: utilisation(datapath, cycles, jobs),
        ..Recording::default()
    }
}

/// Prints the counts and the utilisation of each stage's units.
pub fn print(recording: &Recording, out: &mut dyn Write) -> Result<(), CliError> {
    print_rows(&recording.counts, out)?;
    writeln!(
        out,
        "\nUtilisation of the units of each stage:\n{}\n",
        table(&recording.utilisation, &recording.operations)
    )?;
    Ok(())
}

pub fn print_rows(rows: &[(String, String)], out: &mut dyn Write) -> Result<(), CliError> {
    let width = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
    rows.iter().try_for_each(|(label, value)| writeln!(out, "{label:<width$}  {value}"))?;
    Ok(())
}

/// Writes these files, each of them whole ([`write_all`]), and prints their paths.
pub fn write_and_name<T: AsRef<[u8]>>(files: &[(PathBuf, T)], out: &mut dyn Write) -> Result<(), CliError> {
    write_all(files)?;
    files.iter().try_for_each(|(path, _)| writeln!(out, "wrote {}", path.display()))?;
    Ok(())
}
