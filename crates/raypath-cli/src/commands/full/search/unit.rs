//! Searches by jobs of the unit, and their timing in its cycle-exact model.

use crate::commands::full::unit_sweep::{Point, UnitSweep, grid};
use crate::commands::full::{print_rows, recording, watched};
use crate::{CliError, number, whole};
use clap::Args;
use rayon::prelude::*;
use raypath_model::Shape;
use raypath_ops::JobKind;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_search::{Metric, SearchError, SearchMemory, UnitJobs, UnitSearch, UnitTiming};
use raypath_timing::report::{Table, html};
use raypath_traversal::search::{SearchParameters, Searches};
use raypath_traversal::{UnitNetlist, UnitParameters};
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

#[derive(Debug, Args)]
#[command(next_help_heading = "Timing in the unit's cycle-exact model (with --through unit)")]
pub struct UnitArguments {
    /// The searches of the unit [default: as many neighbours, candidates and dimensions as are needed]
    #[arg(long, requires = "through", value_name = "k=K,m=M,...")]
    search: Option<Searches>,
    /// Bits of a beat of the memory
    #[arg(long, requires = "through", default_value_t = 512, value_parser = width, value_name = "128|256|512")]
    memory_width: u32,
    /// Cycles from a request to its first beat
    #[arg(long, requires = "through", default_value_t = 100, value_parser = whole(0..=1_000_000u64), value_name = "M")]
    memory_latency: u64,
    /// Assumed clock frequency for rates, in MHz
    #[arg(long, requires = "through", default_value_t = 1000.0, value_parser = number(0.001..=1e6, "MHz, 0.001 to 1000000"), value_name = "MHZ")]
    clock: f64,
    /// Time the first N queries [default: as many as take five million beats]
    #[arg(long, requires = "through", value_parser = whole(1..=usize::MAX), value_name = "N")]
    timed: Option<usize>,
    /// Plot throughput over searches at a time, for several latencies and widths of the memory
    #[arg(long, requires = "through", value_name = "FILE.svg")]
    sweep: Option<PathBuf>,
    /// Write a page about the run, for a browser
    #[arg(long, requires = "through", value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Do not time the jobs
    #[arg(long, requires = "through", conflicts_with_all = ["search", "memory_width", "memory_latency", "clock", "timed", "sweep", "report"])]
    no_timing: bool,
}

fn width(text: &str) -> Result<u32, String> {
    match text {
        "128" | "256" | "512" => whole(128..=512u32)(text),
        _ => Err("expected 128, 256 or 512".to_string()),
    }
}

/// What the jobs of a search need of a unit.
#[derive(Debug, Clone, Copy)]
pub struct Needs {
    pub neighbours: usize,
    pub candidates: usize,
    pub dimensions: usize,
    pub has_tree: bool,
}

/// A search by jobs, and what the functional model found.
pub struct Subject<'s> {
    pub title: String,
    pub metric: Metric,
    pub jobs: &'s UnitJobs,
    pub found: &'s UnitSearch,
    pub needs: Needs,
    /// What was printed about the search.
    pub rows: &'s [(String, String)],
}

/// The simulated beats without a number of queries.
const BEATS: u64 = 5_000_000;
/// The beats that a point of a sweep simulates, at most.
const SWEPT_BEATS: u64 = 100_000;
/// Jobs that are simulated one by one.
const ALONE: usize = 3;
const CONTEXTS: [u32; 4] = [2, 4, 8, 16];
const LATENCIES: [u64; 3] = [20, 100, 300];
const WIDTHS: [u32; 3] = [128, 256, 512];

impl UnitArguments {
    /// Simulates the first queries, prints the results, and returns the files to write. None with `--no-timing`.
    pub fn time(
        &self,
        subject: &Subject<'_>,
        config: Config,
        out: &mut dyn Write,
    ) -> Result<Vec<(PathBuf, Vec<u8>)>, CliError> {
        if self.no_timing {
            return Ok(Vec::new());
        }
        let searches = match self.search {
            Some(Searches(Some(searches))) => subject.needs.met_by(searches)?,
            Some(Searches(None)) => return Err(CliError::unusable("--search none: expected searches")),
            None => subject.needs.parameters(self.memory_latency),
        };
        let unit = UnitParameters { search: Searches(Some(searches)), ..UnitParameters::default() };
        let unit = UnitNetlist::new(config, unit).map_err(CliError::unusable)?;
        let (shape, parameters) = (unit.shape(), unit.parameters);
        let memory = SearchMemory { width: self.memory_width, latency: self.memory_latency };
        let timed = self.timed.unwrap_or(subject.queries_with(BEATS)).min(subject.found.rows.len());
        let (all, alone) = watched("queries timed", timed + ALONE, |progress| {
            let all = subject.run((&shape, parameters), memory, [timed, 0], &|done| progress(done))?;
            let alone = subject.run((&shape, parameters), memory, [ALONE, 1], &|done| progress(timed as u64 + done))?;
            Ok::<_, SearchError>((all, alone))
        })
        .map_err(CliError::unusable)?;
        let row = |label: &str, value: String| (label.to_string(), value);
        let bound = all.bound(&alone, searches.contexts);
        let per_second = all.jobs as f64 / all.cycles.max(1) as f64 * self.clock * 1e6;
        let rows = vec![
            row("queries timed", format!("{} of {}", all.jobs, subject.found.rows.len())),
            row("searches at a time", searches.contexts.to_string()),
            row("memory", format!("{} cycles, {} bits a beat", memory.latency, memory.width)),
            row("cycles", all.cycles.to_string()),
            row("beats per cycle", format!("{:.3}", all.beats_per_cycle())),
            row("the bound of beats per cycle", format!("{bound:.3}")),
            row("beats of memory per cycle", format!("{:.3}", all.memory_beats as f64 / all.cycles.max(1) as f64)),
            row("cycles of a query alone", format!("{:.0}", alone.cycles as f64 / alone.jobs.max(1) as f64)),
            row(&format!("queries per second at {} MHz", self.clock), format!("{per_second:.4e}")),
        ];
        print_rows(&rows, out)?;
        if self.sweep.is_none() && self.report.is_none() {
            return Ok(Vec::new());
        }
        let swept = subject.sweep(&shape, parameters, searches)?;
        swept.print(out)?;
        let mut files = Vec::new();
        files.extend(self.sweep.iter().map(|path| (path.clone(), swept.svg().into_bytes())));
        if let Some(path) = &self.report {
            let mut jobs = [0; JobKind::ALL.len()];
            jobs[subject.metric.kind().opcode() as usize] = all.beats;
            let mut page = recording(subject.title.clone(), config, &DatapathNetlist::new(config)?, all.cycles, &jobs);
            let search = subject.rows.iter().map(|(label, value)| vec![label.clone(), value.clone()]).collect();
            let head = ["what", "value"].map(str::to_string).to_vec();
            page.tables.push(Table { title: "The search".to_string(), head, rows: search });
            (page.counts, page.sweep) = (rows, Some(swept.svg()));
            files.push((path.clone(), html(&page).into_bytes()));
        }
        Ok(files)
    }
}

impl Needs {
    /// These parameters, if they are as many as are needed.
    fn met_by(self, searches: SearchParameters) -> Result<SearchParameters, CliError> {
        let Self { neighbours, candidates, dimensions, has_tree } = self;
        let all = [
            ("k", searches.neighbours, neighbours),
            ("m", searches.candidates, candidates),
            ("dimensions", searches.dimensions, dimensions),
            ("trees", searches.trees, has_tree.into()),
        ];
        let problem = |(name, found, least)| format!("--search {name}={found}, expected at least {least}");
        let lacking = all.into_iter().find(|(_, found, least)| (*found as usize) < *least);
        lacking.map_or(Ok(searches), |lacking| Err(CliError::unusable(problem(lacking))))
    }

    /// The parameters of a unit that has them, and blocks for this latency.
    fn parameters(self, latency: u64) -> SearchParameters {
        let default = SearchParameters::default();
        let Self { neighbours, candidates, dimensions, has_tree } = self;
        SearchParameters {
            neighbours: default.neighbours.max(neighbours as u32),
            candidates: default.candidates.max(candidates as u32),
            dimensions: default.dimensions.max(dimensions as u32),
            blocks: blocks(latency),
            trees: has_tree.into(),
            ..default
        }
    }
}

/// Blocks that hide a latency.
fn blocks(latency: u64) -> u32 {
    (latency as u32).saturating_add(16).next_power_of_two().clamp(128, 512)
}

impl Subject<'_> {
    fn run(
        &self,
        unit: (&Shape, UnitParameters),
        memory: SearchMemory,
        jobs: [usize; 2],
        progress: raypath_timing::Progress<'_>,
    ) -> Result<UnitTiming, SearchError> {
        self.jobs.time(self.found, unit, memory, jobs, progress)
    }

    /// The queries that take so many beats, at least 1.
    fn queries_with(&self, beats: u64) -> usize {
        let UnitSearch { work, rows, .. } = self.found;
        (beats / (work.beats / rows.len().max(1) as u64).max(1)).max(1) as usize
    }

    /// The beats per cycle over searches, latencies and widths, with the bound of each point.
    fn sweep(&self, shape: &Shape, unit: UnitParameters, searches: SearchParameters) -> Result<UnitSweep, CliError> {
        let points = grid(WIDTHS, LATENCIES, CONTEXTS);
        let few = self.queries_with(SWEPT_BEATS);
        let points = watched("points", points.len(), |progress| {
            let done = AtomicU64::new(0);
            let point = |&(width, latency, contexts): &(u32, u64, u32)| {
                let searches = SearchParameters { contexts, blocks: blocks(latency), ..searches };
                let unit = (shape, UnitParameters { search: Searches(Some(searches)), ..unit });
                let memory = SearchMemory { width, latency };
                let jobs = few.max(4 * contexts as usize);
                let all = self.run(unit, memory, [jobs, 0], &|_| true)?;
                let alone = self.run(unit, memory, [ALONE, 1], &|_| true)?;
                progress(done.fetch_add(1, Ordering::Relaxed) + 1);
                let (reached, bound) = (all.beats_per_cycle(), all.bound(&alone, contexts));
                Ok(Point { width, latency, contexts, reached, bound })
            };
            points.par_iter().map(point).collect::<Result<Vec<_>, SearchError>>()
        })
        .map_err(CliError::unusable)?;
        Ok(UnitSweep { title: "searches", contexts: "searches", work: "beats", points })
    }
}
