//! Searches by jobs of the unit, and their timing in its cycle-exact model.

use crate::commands::full::{TimingArguments, print_rows, watched};
use crate::{CliError, whole};
use clap::Args;
use rayon::prelude::*;
use raypath_model::Shape;
use raypath_rtl::Config;
use raypath_search::{SearchError, SearchMemory, UnitJobs, UnitSearch, UnitTiming};
use raypath_timing::{Panel, Plot, Series};
use raypath_traversal::search::{SearchParameters, Searches};
use raypath_traversal::{UnitNetlist, UnitParameters};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct UnitArguments {
    /// The searches of the unit [default: as many neighbours, candidates and dimensions as are needed]
    #[arg(long, requires = "through", conflicts_with = "no_timing", value_name = "k=K,m=M,...")]
    search: Option<Searches>,
    /// Bits of a beat of the unit's memory
    #[arg(long, requires = "through", conflicts_with = "no_timing", default_value_t = 512, value_parser = width, value_name = "128|256|512")]
    memory_width: u32,
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
}

/// A search by jobs, and what the functional model found.
pub struct Subject<'s> {
    pub jobs: &'s UnitJobs,
    pub found: &'s UnitSearch,
    /// The queries that are simulated, and the beats of one.
    pub timed: usize,
    pub needs: Needs,
}

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
        timing: &TimingArguments,
        config: Config,
        out: &mut dyn Write,
    ) -> Result<Vec<(PathBuf, Vec<u8>)>, CliError> {
        let Some(latency) = timing.memory_latency() else { return Ok(Vec::new()) };
        let searches = match self.search {
            Some(Searches(Some(searches))) => subject.needs.met_by(searches)?,
            Some(Searches(None)) => return Err(CliError::unusable("--search none: expected searches")),
            None => subject.needs.parameters(latency),
        };
        let unit = UnitParameters { search: Searches(Some(searches)), ..UnitParameters::default() };
        let unit = UnitNetlist::new(config, unit).map_err(CliError::unusable)?;
        let (shape, parameters) = (unit.shape(), unit.parameters);
        let memory = SearchMemory { width: self.memory_width, latency };
        let total = (subject.timed + ALONE) as u64;
        let (all, alone) = watched("queries timed", total as usize, |progress| {
            let all = subject.run((&shape, parameters), memory, [subject.timed, 0], &|done| progress(done))?;
            let alone =
                subject.run((&shape, parameters), memory, [ALONE, 1], &|done| progress(subject.timed as u64 + done))?;
            Ok::<_, SearchError>((all, alone))
        })
        .map_err(CliError::unusable)?;
        let row = |label: &str, value: String| (label.to_string(), value);
        let bound = all.bound(&alone, searches.contexts);
        let per_second = all.jobs as f64 / all.cycles.max(1) as f64 * timing.clock() * 1e6;
        let rows = [
            row("queries timed", format!("{} of {}", all.jobs, subject.found.results.rows.len())),
            row("searches at a time", searches.contexts.to_string()),
            row("memory", format!("{latency} cycles, {} bits a beat", self.memory_width)),
            row("cycles", all.cycles.to_string()),
            row("beats per cycle", format!("{:.3}", all.beats_per_cycle())),
            row("the bound of beats per cycle", format!("{bound:.3}")),
            row("beats of memory per cycle", format!("{:.3}", all.memory_beats as f64 / all.cycles.max(1) as f64)),
            row("cycles of a query alone", format!("{:.0}", alone.cycles as f64 / alone.jobs.max(1) as f64)),
            row(&format!("queries per second at {} MHz", timing.clock()), format!("{per_second:.4e}")),
        ];
        print_rows(&rows, out)?;
        let Some(path) = timing.sweep() else { return Ok(Vec::new()) };
        let points = subject.sweep(&shape, parameters, searches)?;
        writeln!(out, "\n  bits  latency  searches  beats/cycle  bound  ratio")?;
        for Swept { width, latency, contexts, reached, bound } in &points {
            let ratio = reached / bound;
            writeln!(out, "{width:>6} {latency:>8} {contexts:>9} {reached:>12.3} {bound:>6.3} {ratio:>6.3}")?;
        }
        Ok(vec![(path.clone(), plot(&points).svg().into_bytes())])
    }
}

impl Needs {
    /// These parameters, if they are as many as are needed.
    fn met_by(self, searches: SearchParameters) -> Result<SearchParameters, CliError> {
        let Self { neighbours, candidates, dimensions } = self;
        let all = [
            ("k", searches.neighbours, neighbours),
            ("m", searches.candidates, candidates),
            ("dimensions", searches.dimensions, dimensions),
        ];
        let problem = |(name, found, least)| format!("--search {name}={found}, expected at least {least}");
        let lacking = all.into_iter().find(|(_, found, least)| (*found as usize) < *least);
        lacking.map_or(Ok(searches), |lacking| Err(CliError::unusable(problem(lacking))))
    }

    /// The parameters of a unit that has them, and blocks for this latency.
    fn parameters(self, latency: u64) -> SearchParameters {
        let default = SearchParameters::default();
        let Self { neighbours, candidates, dimensions } = self;
        SearchParameters {
            neighbours: default.neighbours.max(neighbours as u32),
            candidates: default.candidates.max(candidates as u32),
            dimensions: default.dimensions.max(dimensions as u32),
            blocks: blocks(latency),
            ..default
        }
    }
}

/// Blocks that hide a latency.
fn blocks(latency: u64) -> u32 {
    (latency as u32).saturating_add(16).next_power_of_two().clamp(128, 512)
}

/// A point of a sweep.
struct Swept {
    width: u32,
    latency: u64,
    contexts: u32,
    /// Beats per cycle.
    reached: f64,
    bound: f64,
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

    /// The beats per cycle over searches, latencies and widths, with the bound of each point.
    fn sweep(&self, shape: &Shape, unit: UnitParameters, searches: SearchParameters) -> Result<Vec<Swept>, CliError> {
        let points: Vec<(u32, u64, u32)> = WIDTHS
            .iter()
            .flat_map(|width| LATENCIES.iter().flat_map(move |latency| CONTEXTS.map(|count| (*width, *latency, count))))
            .collect();
        let work = self.found.results.work;
        let of_query = work.beats / (self.found.results.rows.len().max(1) as u64);
        let few = (SWEPT_BEATS / of_query.max(1)).max(1) as usize;
        watched("points", points.len(), |progress| {
            let done = std::sync::atomic::AtomicU64::new(0);
            let point = |&(width, latency, contexts): &(u32, u64, u32)| {
                let searches = SearchParameters { contexts, blocks: blocks(latency), ..searches };
                let unit = (shape, UnitParameters { search: Searches(Some(searches)), ..unit });
                let memory = SearchMemory { width, latency };
                let jobs = few.max(4 * contexts as usize);
                let all = self.run(unit, memory, [jobs, 0], &|_| true)?;
                let alone = self.run(unit, memory, [ALONE, 1], &|_| true)?;
                progress(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1);
                let (reached, bound) = (all.beats_per_cycle(), all.bound(&alone, contexts));
                Ok(Swept { width, latency, contexts, reached, bound })
            };
            points.par_iter().map(point).collect::<Result<Vec<_>, SearchError>>()
        })
        .map_err(CliError::unusable)
    }
}

fn plot(points: &[Swept]) -> Plot {
    let panel = |width: u32| {
        let line = |(colour, latency): (usize, &u64), is_limit: bool| {
            let here = points.iter().filter(|point| (point.width, point.latency) == (width, *latency));
            let value = |point: &Swept| if is_limit { point.bound } else { point.reached };
            let points = here.map(|point| (point.contexts as usize, value(point))).collect();
            Series { colour, is_limit, points }
        };
        let of = |is_limit: bool| LATENCIES.iter().enumerate().map(move |latency| line(latency, is_limit));
        Panel { axis: format!("beats per cycle, {width} bits a beat"), lines: of(false).chain(of(true)).collect() }
    };
    Plot {
        title: "Throughput of searches; dashed: bound".to_string(),
        horizontal: "searches at a time".to_string(),
        panels: WIDTHS.map(panel).into(),
        legend: "memory latency".to_string(),
        colours: LATENCIES.map(|latency| format!("{latency} cycles")).into(),
    }
}
