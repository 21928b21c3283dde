//! Simulated timing through the traversal unit.

use super::timing::Work;
use crate::commands::full::{TimingArguments, print_rows, watched};
use crate::commands::unit::UnitArguments;
use crate::{CliError, whole};
use clap::Args;
use rayon::prelude::*;
use raypath_render::{UnitSystem, time_picture_through_unit, time_rays_through_unit};
use raypath_rtl::Config;
use raypath_timing::{Panel, Plot, Progress, Sample, Series};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::system::{CacheParameters, MemoryParameters, SystemTiming};
use raypath_traversal::{UnitNetlist, UnitParameters};
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// The unit, and what lies between it and the memory.
#[derive(Debug, Args)]
#[command(next_help_heading = "Traversal unit (with --through unit)")]
pub struct UnitTimingArguments {
    #[command(flatten)]
    unit: UnitArguments,
    /// The bytes that arrive from the memory in a cycle [default: as many as the unit takes]
    #[arg(long, value_parser = whole(1..=65_536u32), value_name = "BYTES")]
    bandwidth: Option<u32>,
    /// A cache of this size before the memory [default: none]
    #[arg(long, value_parser = whole(1..=1u32 << 30), value_name = "BYTES")]
    cache: Option<u32>,
    /// The ways of the cache
    #[arg(long, default_value_t = 4, value_parser = whole(1..=1024u32), requires = "cache", value_name = "WAYS")]
    cache_ways: u32,
    /// The bytes of a line of the cache: a power of two from 32 to 4096
    #[arg(long, default_value_t = 128, value_parser = whole(32..=4096u32), requires = "cache", value_name = "BYTES")]
    cache_line: u32,
    /// Cycles of a hit in the cache
    #[arg(long, default_value_t = 8, value_parser = whole(1..=1_000_000u64), requires = "cache", value_name = "CYCLES")]
    cache_latency: u64,
}

/// The numbers of contexts, latencies and widths of a sweep.
const CONTEXTS: [u32; 5] = [8, 16, 64, 192, 256];
const LATENCIES: [u64; 3] = [20, 100, 200];
/// The widths for blocks of 1024 bits; half of them for those of quantised nodes.
const WIDTHS: [u32; 3] = [256, 512, 1024];
/// The pixels or rays at each point of a sweep, and those that are traced one after another.
const SWEPT: usize = 20_000;
const ALONE: usize = 1000;

impl UnitTimingArguments {
    /// An error if an option is given, but not the unit.
    pub fn expect_none(&self) -> Result<(), CliError> {
        let given = [("bandwidth", self.bandwidth), ("cache", self.cache)];
        if let Some((name, value)) = given.into_iter().find_map(|(name, value)| Some((name, value?))) {
            let problem = format!("--{name} {value} needs the traversal unit, expected --through unit");
            return Err(CliError::unusable(problem));
        }
        self.unit.expect_none("--through unit")
    }

    /// The nodes of the scene.
    pub fn nodes(&self) -> NodeKind {
        self.unit.parameters().step.node
    }

    /// Checks the options, and makes the system.
    pub fn system(&self, config: Config, memory_latency: u64) -> Result<UnitSystem, CliError> {
        let unit = self.unit.parameters();
        let shape = UnitNetlist::new(config, unit).map_err(CliError::unusable)?.shape();
        let cache = self.cache.map(|bytes| CacheParameters {
            bytes,
            ways: self.cache_ways,
            line: self.cache_line,
            hit_latency: self.cache_latency,
        });
        cache.map_or(Ok(()), CacheParameters::check).map_err(CliError::unusable)?;
        let memory = MemoryParameters { latency: memory_latency.max(1), bandwidth: self.bandwidth, cache };
        Ok(UnitSystem { shape, unit, memory, in_flight: in_work(unit) })
    }
}

/// Pixels or rays in work for a number of contexts: twice as many, so that a ray waits whenever a context is free.
fn in_work(unit: UnitParameters) -> usize {
    2 * unit.contexts as usize
}

/// Simulates the work, prints the results, and returns the files to write.
pub fn time(
    work: &Work<'_>,
    system: &UnitSystem,
    max: usize,
    timing: &TimingArguments,
    out: &mut dyn Write,
) -> Result<Vec<(PathBuf, Vec<u8>)>, CliError> {
    let count = work.count();
    let sample = Sample::spread(count, max);
    let timed = sample.numbers(count).len();
    let (plural, _) = work.names();
    let found =
        watched(work.label(["pixels timed", "rays timed"]), timed, |progress| run(work, sample, system, progress))?;
    let mut rows = vec![
        (format!("{plural} timed"), format!("{timed} of {count}")),
        ("contexts".to_string(), system.unit.contexts.to_string()),
        ("memory".to_string(), format!("{} cycles, {} bits a beat", system.memory.latency, system.unit.memory_width)),
    ];
    rows.extend(results(&found, timing.clock()));
    print_rows(&rows, out)?;
    let Some(path) = timing.sweep() else { return Ok(Vec::new()) };
    let points = sweep(work, system)?;
    writeln!(out, "\n  bits  latency  contexts  jobs/cycle  bound  ratio")?;
    for Swept { width, latency, contexts, reached, bound } in &points {
        let ratio = reached / bound;
        writeln!(out, "{width:>6} {latency:>8} {contexts:>9} {reached:>11.3} {bound:>6.3} {ratio:>6.3}")?;
    }
    Ok(vec![(path.clone(), plot(&points, widths(system)).svg().into_bytes())])
}

fn run(
    work: &Work<'_>,
    sample: Sample,
    system: &UnitSystem,
    progress: Progress<'_>,
) -> Result<SystemTiming, raypath_render::PictureError> {
    match work {
        Work::Picture { spec, .. } => time_picture_through_unit(spec, sample, system, progress).map(|(found, _)| found),
        Work::Rays(batch) => time_rays_through_unit(batch, sample, system, progress).map(|(found, _)| found),
    }
}

/// What a simulation measured, as labels and values.
fn results(found: &SystemTiming, clock_mhz: f64) -> Vec<(String, String)> {
    let row = |label: &str, value: String| (label.to_string(), value);
    let unit = found.unit;
    let rays = unit.rays.max(1) as f64;
    let rays_per_second = rays / unit.cycles.max(1) as f64 * clock_mhz * 1e6;
    let mut rows = vec![
        row("cycles", unit.cycles.to_string()),
        row("rays", unit.rays.to_string()),
        row("box jobs", unit.boxes.to_string()),
        row("triangle jobs", unit.triangles.to_string()),
        row("jobs per cycle", format!("{:.3}", found.jobs_per_cycle())),
        row("jobs per ray", format!("{:.2}", found.jobs() as f64 / rays)),
        row("fetches per ray", format!("{:.2}", unit.fetches as f64 / rays)),
        row("steps per ray", format!("{:.2}", unit.steps as f64 / rays)),
        row("beats of memory per cycle", format!("{:.3}", found.beats as f64 / unit.cycles.max(1) as f64)),
        row("rays in flight, mean", format!("{:.1}", found.ray_cycles as f64 / unit.cycles.max(1) as f64)),
        row("cycles per fetch and ray", format!("{:.1}", found.cycles_per_fetch())),
    ];
    if found.cache_hits + found.cache_misses > 0 {
        let share = found.cache_hits as f64 / (found.cache_hits + found.cache_misses) as f64;
        rows.push(row("hits of the cache", format!("{} ({:.1} %)", found.cache_hits, 100.0 * share)));
    }
    rows.push((format!("rays per second at {clock_mhz} MHz"), format!("{rays_per_second:.4e}")));
    rows
}

/// The widths of a sweep.
fn widths(system: &UnitSystem) -> [u32; 3] {
    let nodes = system.unit.step.node;
    WIDTHS.map(|width| width * nodes.block_bytes() / NodeKind::Wide4.block_bytes())
}

/// A point of a sweep.
struct Swept {
    width: u32,
    latency: u64,
    contexts: u32,
    /// Jobs per cycle.
    reached: f64,
    bound: f64,
}

/// The jobs per cycle over contexts, latencies and widths, with the bound of each point.
fn sweep(work: &Work<'_>, system: &UnitSystem) -> Result<Vec<Swept>, CliError> {
    let points: Vec<(u32, u64, u32)> = widths(system)
        .iter()
        .flat_map(|width| {
            LATENCIES.iter().flat_map(move |latency| CONTEXTS.map(|contexts| (*width, *latency, contexts)))
        })
        .collect();
    let count = work.count();
    let swept = Sample::spread(count, SWEPT);
    let alone = Sample::spread(count, ALONE);
    let total = points.len() * swept.numbers(count).len();
    let at = |(width, latency, contexts): (u32, u64, u32), in_flight: usize| {
        let unit = UnitParameters { contexts, memory_width: width, ..system.unit };
        let memory = MemoryParameters { latency, ..system.memory };
        UnitSystem { shape: system.shape.clone(), unit, memory, in_flight }
    };
    watched(work.label(["pixels swept", "rays swept"]), total, |progress| {
        let completed = AtomicU64::new(0);
        let point = |point: &(u32, u64, u32)| {
            let counted = AtomicU64::new(0);
            let count = |done: u64| {
                let more = done - counted.swap(done, Ordering::Relaxed);
                progress(completed.fetch_add(more, Ordering::Relaxed) + more)
            };
            let found = run(work, swept, &at(*point, 2 * point.2 as usize), &count)?;
            let lone = run(work, alone, &at(*point, 1), &|_| progress(completed.load(Ordering::Relaxed)))?;
            let (reached, bound) = (found.jobs_per_cycle(), bound(&found, &lone, point.2));
            Ok(Swept { width: point.0, latency: point.1, contexts: point.2, reached, bound })
        };
        points.par_iter().map(point).collect::<Result<Vec<_>, raypath_render::PictureError>>()
    })
}

fn plot(points: &[Swept], widths: [u32; 3]) -> Plot {
    let panel = |width: u32| {
        let line = |(colour, latency): (usize, &u64), is_limit: bool| {
            let here = points.iter().filter(|point| (point.width, point.latency) == (width, *latency));
            let value = |point: &Swept| if is_limit { point.bound } else { point.reached };
            let points = here.map(|point| (point.contexts as usize, value(point))).collect();
            Series { colour, is_limit, points }
        };
        let of = |is_limit: bool| LATENCIES.iter().enumerate().map(move |latency| line(latency, is_limit));
        Panel { axis: format!("jobs per cycle, {width} bits a beat"), lines: of(false).chain(of(true)).collect() }
    };
    Plot {
        title: "Throughput of the traversal unit; dashed: bound".to_string(),
        horizontal: "contexts".to_string(),
        panels: widths.map(panel).into(),
        legend: "memory latency".to_string(),
        colours: LATENCIES.map(|latency| format!("{latency} cycles")).into(),
    }
}

/// The greatest number of jobs per cycle: 1; what `contexts` rays ask for if each takes as long as it does alone; what
/// the beats of the memory allow, and one step a cycle.
fn bound(found: &SystemTiming, alone: &SystemTiming, contexts: u32) -> f64 {
    let by_contexts = f64::from(contexts) * alone.jobs() as f64 / alone.ray_cycles.max(1) as f64;
    let by_memory = found.jobs() as f64 / found.beats.max(1) as f64;
    let by_steps = found.jobs() as f64 / found.unit.steps.max(1) as f64;
    by_contexts.min(by_memory).min(by_steps).min(1.0)
}
