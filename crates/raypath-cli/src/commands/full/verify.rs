//! `raypath verify`: checks of the claims about hardware and models with their oracles.

mod results;

use crate::commands::full::division::{Division, DivisionArguments};
use crate::progress;
use crate::{CliError, DatapathArguments, whole};
use clap::Args;
use raypath_rtl::Config;
use raypath_verify::{Item, Level, Request, Shard, ShardError, Verdict};
use raypath_work::parts::Parts;
use results::Results;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

#[derive(Debug, Args)]
pub struct Arguments {
    /// The items to verify; `--list` shows all of them [default: all, or those that depend on the configuration if one
    /// is selected]
    #[arg(value_parser = item, value_name = "ITEM")]
    items: Vec<&'static str>,
    /// List the items with their claims and oracles, and do nothing
    #[arg(long)]
    list: bool,
    /// The effort: seconds for each item, minutes for each item, or hours. Level `regression` does a tenth of its work,
    /// which follows from the date, unless `--shard`, `--jobs`, `--merge`, an item or a configuration is chosen
    #[arg(long, default_value = "regression", value_name = "regression|full|long")]
    level: Level,
    /// The number of jobs, for items with jobs [default: by the level]
    #[arg(long, value_name = "N", value_parser = whole(1..=u64::MAX))]
    jobs: Option<u64>,
    /// Seed of all random choices
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Write commit, versions of programs, and the work, time and verdict of each item to this file, as JSON
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Show what has changed since the commit of results that `--out` wrote, and do nothing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["list", "out"])]
    since: Option<PathBuf>,
    #[command(flatten)]
    division: DivisionArguments,
    #[command(flatten)]
    datapath: DatapathArguments,
}

/// All items, in the order in which they run.
fn items() -> impl Iterator<Item = &'static Item> {
    let parts = [
        raypath_verify_arithmetic::ITEMS,
        raypath_verify_datapath::ITEMS,
        raypath_verify_traversal::ITEMS,
        raypath_verify_mutation::ITEMS,
    ];
    parts.into_iter().flatten()
}

fn item(name: &str) -> Result<&'static str, String> {
    let names: Vec<&str> = items().map(|item| item.name).collect();
    names.iter().find(|known| **known == name).copied().ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.datapath.config()?;
    let name = arguments.datapath.name(config);
    let chosen = chosen(arguments)?;
    if arguments.list {
        return chosen.into_iter().try_for_each(|item| describe(item, out)).map_err(CliError::from);
    }
    if let Some(path) = &arguments.since {
        return results::since(path, out);
    }
    let Arguments { level, seed, .. } = arguments;
    let shard = if is_divided_by_days(arguments) { shard_of_today()? } else { arguments.division.shard() };
    let jobs = arguments.jobs.map_or(String::new(), |jobs| format!(", {jobs} jobs"));
    let mut division =
        arguments.division.begin(format!("verify, level {}, seed {seed}{jobs}, {name}", level.name()))?;
    let part = format!("part {} of {}", shard.number() + 1, shard.count());
    writeln!(out, "Level {}, seed {seed}, {part}.", level.name())?;
    let (mut wrong, mut not_run, mut results) = (Vec::new(), Vec::new(), Results::new(*level, *seed, shard));
    for item in chosen {
        describe(item, out)?;
        out.flush()?;
        let begin = Instant::now();
        match verify(item, arguments, config, shard, &division) {
            Ok((verdict, parts)) => {
                let seconds = parts.seconds().unwrap_or(begin.elapsed().as_secs_f64());
                report(&verdict, seconds, out)?;
                if !verdict.failures.is_empty() {
                    wrong.push(item.name);
                }
                if verdict.is_stopped {
                    return Err(stopped(item.name, &wrong));
                }
                division.keep(item.name, parts, seconds);
                results.add(item, &verdict, seconds);
            }
            Err(problem) => {
                writeln!(out, "  not run  {problem}")?;
                results.add_missing(item, &problem);
                not_run.push(format!("{}: {problem}", item.name));
            }
        }
    }
    if let Some(message) = division.write()? {
        writeln!(out, "{message}")?;
    }
    if let Some(path) = &arguments.out {
        results.write(path)?;
        writeln!(out, "\nWrote the results to {}.", path.display())?;
    }
    match (wrong.is_empty(), not_run.is_empty()) {
        (false, _) => Err(CliError::Mismatch(format!("wrong: {}", wrong.join(", ")))),
        (true, false) => Err(CliError::unusable(format!("not run: {}", not_run.join("; ")))),
        (true, true) if shard == Shard::ALL => Ok(writeln!(out, "\nAll claims hold.")?),
        (true, true) => Ok(writeln!(out, "\n{part}; all claims of this part hold")?),
    }
}

/// The parts of level `regression`, one for each day.
const DAYS: u64 = 10;

/// Whether only the part of today runs: all items at level `regression`, without a choice of the work.
fn is_divided_by_days(arguments: &Arguments) -> bool {
    let Arguments { items, level, jobs, division, datapath, .. } = arguments;
    let is_chosen = !items.is_empty() || jobs.is_some() || division.is_chosen() || !datapath.is_default();
    *level == Level::Regression && !is_chosen
}

/// The part of today (UTC): in ten days in a row, each part runs once.
fn shard_of_today() -> Result<Shard, CliError> {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    let shard = format!("{}/{DAYS}", seconds / (24 * 60 * 60) % DAYS + 1);
    shard.parse().map_err(|problem: ShardError| CliError::unusable(problem))
}

/// The items that the user named, or all. With options of a configuration, only items that depend on it.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static Item>, CliError> {
    let named = &arguments.items;
    let is_named = |item: &&Item| named.is_empty() || named.contains(&item.name);
    if arguments.datapath.is_default() {
        return Ok(items().filter(is_named).collect());
    }
    let (dependent, others): (Vec<&Item>, Vec<&Item>) = items().partition(|item| item.has_configuration);
    if let Some(Item { name, .. }) = others.iter().find(|item| named.contains(&item.name)) {
        let dependent: Vec<&str> = dependent.iter().map(|item| item.name).collect();
        let dependent = dependent.join(", ");
        let problem =
            format!("{name} does not depend on the configuration, expected no options of one, or {dependent}");
        return Err(CliError::unusable(problem));
    }
    Ok(dependent.into_iter().filter(is_named).collect())
}

fn verify(
    item: &Item,
    arguments: &Arguments,
    config: Config,
    shard: Shard,
    division: &Division,
) -> Result<(Verdict, Parts), CliError> {
    let parts = division.parts(item.name)?;
    let mut progress: Option<progress::Progress> = None;
    let mut reached = 0;
    let mut watch = |step: raypath_verify::Progress| {
        reached = step.done as usize;
        let total = step.total as usize;
        progress.get_or_insert_with(|| progress::Progress::new(item.name, total)).of(total).at(reached)
    };
    let Arguments { level, jobs, seed, .. } = *arguments;
    let added = arguments.datapath.specs.iter().map(|spec| spec.name().to_string()).collect();
    let is_chosen = !arguments.datapath.is_default();
    let mut request = Request { config, added, is_chosen, level, jobs, seed, shard, parts, proceed: &mut watch };
    let verdict = (item.run)(&mut request);
    // The verdict reports a stop, with the coverage so far.
    let parts = request.parts;
    let _ = progress.map(|progress| progress.finish(reached));
    Ok((verdict.map_err(CliError::unusable)?, parts))
}

fn describe(item: &Item, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "\n{}\n  claim    {}\n  oracle   {}", item.name, item.claim, item.oracle)
}

fn report(verdict: &Verdict, seconds: f64, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "  covered  {}, in {seconds:.1} s", verdict.covered)?;
    verdict.remarks.iter().try_for_each(|remark| writeln!(out, "  remark   {remark}"))?;
    verdict.failures.iter().try_for_each(|failure| writeln!(out, "  wrong    {failure}"))?;
    let result = match (verdict.failures.is_empty(), verdict.is_stopped) {
        (false, _) => "WRONG",
        (true, true) => "stopped; nothing wrong so far",
        (true, false) => "as claimed",
    };
    writeln!(out, "  result   {result}")
}

fn stopped(item: &str, wrong: &[&str]) -> CliError {
    match wrong {
        [] => CliError::Stopped(format!("in {item}; nothing was wrong so far")),
        wrong => CliError::Mismatch(format!("stopped in {item}; wrong: {}", wrong.join(", "))),
    }
}
