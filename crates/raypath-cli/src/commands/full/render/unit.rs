//! Simulated timing through the traversal unit.

use super::timing::{TimingArguments, Work};
use crate::commands::full::unit_sweep::{Point, UnitSweep, grid};
use crate::commands::full::{print_rows, watched};
use crate::commands::unit::UnitArguments;
use crate::{CliError, whole};
use clap::{ArgGroup, Args};
use rayon::prelude::*;
use raypath_render::{UnitSystem, time_picture_through_unit, time_rays_through_unit};
use raypath_rtl::Config;
use raypath_timing::{Progress, Sample};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::system::{CacheCounts, CacheParameters, SystemParameters, SystemTiming};
use raypath_traversal::{UnitNetlist, UnitParameters};
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// The unit, and what lies between it and the memory.
#[derive(Debug, Args)]
#[command(next_help_heading = "Traversal unit (with --through unit)")]
#[command(group = ArgGroup::new("caches").args(["cache", "shared_cache"]).multiple(true))]
pub struct UnitTimingArguments {
    #[command(flatten)]
    unit: UnitArguments,
    /// The bytes that arrive from the memory in a cycle [default: as many as the unit takes]
    #[arg(long, value_parser = whole(1..=65_536u32), value_name = "BYTES")]
    bandwidth: Option<u32>,
    /// Units that share the cache and the memory
    #[arg(long, default_value_t = 1, value_parser = whole(1..=64u32), value_name = "UNITS")]
    units: u32,
    /// A cache of this size in each unit: ways × bytes of a line × a power of two [default: none]
    #[arg(long, value_parser = whole(1..=1u32 << 30), value_name = "BYTES")]
    cache: Option<u32>,
    /// A cache of this size that all units share, behind those of the units [default: none]
    #[arg(long, value_parser = whole(1..=1u32 << 30), value_name = "BYTES")]
    shared_cache: Option<u32>,
    /// The ways of the caches: 1, 2, 4 or 8
    #[arg(long, default_value_t = 4, requires = "caches", value_name = "WAYS")]
    cache_ways: u32,
    /// The bytes of a line of the caches: a block, or 2 or 4 [default: a block]
    #[arg(long, requires = "caches", value_name = "BYTES")]
    cache_line: Option<u32>,
    /// The lines that a cache fetches at a time: a power of two from 2 to 64
    #[arg(long, default_value_t = 32, requires = "caches", value_name = "LINES")]
    cache_misses: u32,
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
        let units = Some(self.units).filter(|units| *units != 1);
        let caches = [("cache", self.cache), ("shared-cache", self.shared_cache)];
        let given = caches.into_iter().chain([("units", units), ("bandwidth", self.bandwidth)]);
        if let Some((name, value)) = { given }.find_map(|(name, value)| Some((name, value?))) {
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
        let line = self.cache_line.unwrap_or(unit.step.node.block_bytes());
        let cache = |bytes: Option<u32>| {
            let cache = bytes.map(|bytes| CacheParameters::of_bytes(bytes, self.cache_ways, line, self.cache_misses));
            cache.transpose().map_err(CliError::unusable)
        };
        let (cache, shared) = (cache(self.cache)?, cache(self.shared_cache)?);
        let (units, latency, bandwidth) = (self.units, memory_latency.max(1), self.bandwidth);
        let around = SystemParameters { units, cache, shared, latency, bandwidth };
        around.check(unit).map_err(CliError::unusable)?;
        Ok(UnitSystem { shape, unit, around, in_flight: in_work(unit, self.units) })
    }
}

/// Pixels or rays in work: twice as many as there are contexts, so that a ray waits whenever one is free.
fn in_work(unit: UnitParameters, units: u32) -> usize {
    2 * (units * unit.contexts) as usize
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
        ("memory".to_string(), format!("{} cycles, {} bits a beat", system.around.latency, system.unit.memory_width)),
    ];
    rows.extend(results(&found, timing.clock()));
    print_rows(&rows, out)?;
    let Some(path) = timing.sweep() else { return Ok(Vec::new()) };
    let swept = sweep(work, system)?;
    swept.print(out)?;
    Ok(vec![(path.clone(), swept.svg().into_bytes())])
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
    for (cache, CacheCounts { hits, merges, misses }) in [("cache", found.cache), ("shared cache", found.shared)] {
        let requests = hits + merges + misses;
        if requests > 0 {
            let share = |count: u64| format!("{count} ({:.1} %)", 100.0 * count as f64 / requests as f64);
            rows.push((format!("hits of the {cache}"), share(hits)));
            rows.push((format!("requests of the {cache} that joined a miss"), share(merges)));
        }
    }
    rows.push((format!("rays per second at {clock_mhz} MHz"), format!("{rays_per_second:.4e}")));
    rows
}

/// The widths of a sweep.
fn widths(system: &UnitSystem) -> [u32; 3] {
    let nodes = system.unit.step.node;
    WIDTHS.map(|width| width * nodes.block_bytes() / NodeKind::Wide4.block_bytes())
}

/// The jobs per cycle over contexts, latencies and widths, with the bound of each point.
fn sweep(work: &Work<'_>, system: &UnitSystem) -> Result<UnitSweep, CliError> {
    let points = grid(widths(system), LATENCIES, CONTEXTS);
    let count = work.count();
    let swept = Sample::spread(count, SWEPT);
    let alone = Sample::spread(count, ALONE);
    let total = points.len() * swept.numbers(count).len();
    let at = |(width, latency, contexts): (u32, u64, u32), in_flight: usize| {
        let unit = UnitParameters { contexts, memory_width: width, ..system.unit };
        let around = SystemParameters { latency, ..system.around };
        UnitSystem { shape: system.shape.clone(), unit, around, in_flight }
    };
    let points = watched(work.label(["pixels swept", "rays swept"]), total, |progress| {
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
            Ok(Point { width: point.0, latency: point.1, contexts: point.2, reached, bound })
        };
        points.par_iter().map(point).collect::<Result<Vec<_>, raypath_render::PictureError>>()
    })?;
    Ok(UnitSweep { title: "the traversal unit", contexts: "contexts", work: "jobs", points })
}

/// The greatest number of jobs per cycle: 1; what `contexts` rays ask for if each takes as long as it does alone; what
/// the beats of the memory allow, and one step a cycle.
fn bound(found: &SystemTiming, alone: &SystemTiming, contexts: u32) -> f64 {
    let by_contexts = f64::from(contexts) * alone.jobs() as f64 / alone.ray_cycles.max(1) as f64;
    let by_memory = found.jobs() as f64 / found.beats.max(1) as f64;
    let by_steps = found.jobs() as f64 / found.unit.steps.max(1) as f64;
    by_contexts.min(by_memory).min(by_steps).min(1.0)
}
