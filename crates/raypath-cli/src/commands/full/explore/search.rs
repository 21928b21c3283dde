//! `raypath explore --goal`: the Pareto front of what meets the goals, by a search.

use super::Arguments;
use super::exact::{Elaborated, ExactCache};
use super::space::{Space, space};
use crate::commands::full::MemoryArguments;
use crate::commands::full::measuring::resumable;
use crate::commands::full::ppa::{self, design, picture};
use crate::{CliError, whole};
use clap::{ArgGroup, Args};
use raypath_ppa::explore::{Candidate, Goal, LinearPredictor, Metric, Search, SearchReport, Terms, Values};
use raypath_ppa::{Bench, Design, Power, Report};
use raypath_rtl::Config;
use raypath_sim::files::write_all;
use raypath_tools::{Cache, Key, digest};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
#[command(next_help_heading = "Search (with --goal or --objective, only what may be on the front is measured)")]
#[command(group = ArgGroup::new("wanted").multiple(true).args(["goal", "objective"]))]
pub struct SearchArguments {
    /// A limit: area<=0.6mm2, period<=12ns, energy<=900pJ (a job of a picture), throughput>=0.5 (jobs a cycle),
    /// visits<=2% (more than with rules paper), latency<=16 (cycles); may be given several times
    #[arg(long, value_name = "METRIC<=LIMIT")]
    goal: Vec<Goal>,
    /// The metrics of the front [default: area, period, throughput, visits where they are known, and energy if it has a
    /// goal]
    #[arg(long, value_delimiter = ',', value_name = "METRIC,...")]
    objective: Vec<Metric>,
    /// A scene for visits beside the built-in one: .obj, .gltf, .glb, .ply or .stl; may be given several times
    #[arg(long, requires = "wanted", value_name = "FILE")]
    scene: Vec<PathBuf>,
    /// End after this number of new measurements; the same command goes on from there
    #[arg(long, requires = "wanted", value_parser = whole(1..=1_000_000usize), value_name = "N")]
    budget: Option<usize>,
    /// Configurations that are measured before the first prediction; --shard divides them
    #[arg(long, requires = "wanted", default_value_t = 8, value_parser = whole(6..=10_000usize), value_name = "N")]
    first: usize,
    /// Configurations that are measured between two fits of the predictions
    #[arg(long, requires = "wanted", default_value_t = 4, value_parser = whole(1..=10_000usize), value_name = "N")]
    batch: usize,
    #[command(flatten)]
    memory: MemoryArguments,
}

impl SearchArguments {
    pub fn is_wanted(&self) -> bool {
        !self.goal.is_empty() || !self.objective.is_empty()
    }
}

/// The part of a divided search: the first set.
const TASK: &str = "explore";

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let options = &arguments.search;
    let bench = arguments.bench.bench()?;
    let mut space = space(arguments, &bench.library)?;
    let mut division = arguments.division.begin_whole(work(options, &space))?;
    let exact = ExactCache::new(&arguments.bench.cache)?;
    let elaborated = exact.elaborate(&mut space)?;
    let configs: Vec<Config> = space.members.iter().map(|(_, config)| *config).collect();
    let visits = match options.needs_visits() {
        true => exact.visits(&configs, &options.scene, options.memory.limit)?,
        false => vec![None; configs.len()],
    };
    let objectives = options.objectives(&space, &visits)?;
    let units = units(&bench, &configs, &elaborated)?;
    let candidates: Vec<Candidate> = space
        .members
        .iter()
        .zip(elaborated.iter().zip(visits))
        .map(|((name, config), (elaborated, visits))| candidate(&bench, name, *config, elaborated, visits, &units))
        .collect();
    let search = Search {
        candidates: &candidates,
        predictor: &LinearPredictor { candidates: &candidates },
        goals: &options.goal,
        objectives: &objectives,
        first: options.first,
        batch: options.batch,
    };
    let has_energy = search.measured_metrics().contains(&Metric::Energy);
    let mut measurer = Measurer {
        arguments,
        bench: &bench,
        configs: &configs,
        has_energy,
        left: options.budget,
        reports: BTreeMap::new(),
    };

    if arguments.division.is_divided() {
        let mut parts = division.parts(TASK)?;
        let begin = Instant::now();
        let shards = parts.phase(|| {
            let own: Vec<usize> = arguments.division.shard().of(search.first_set()).collect();
            measurer.measure(&own)?;
            Ok::<BTreeMap<usize, Report>, CliError>(measurer.reports.clone())
        })?;
        division.keep(TASK, parts, begin.elapsed().as_secs_f64());
        if let Some(message) = division.write()? {
            return Ok(writeln!(out, "{message}")?);
        }
        measurer.reports = shards.into_iter().flatten().collect();
    }
    let outcome = search.run(|wanted| measurer.measure(wanted))?;
    let report = SearchReport::new(&search, outcome, measurer.reports, bench.setting(), space.refused);
    write(arguments, &report, out)
}

/// What is divided, for the parts of several machines.
fn work(options: &SearchArguments, space: &Space) -> String {
    let names: Vec<&str> = space.members.iter().map(|(name, _)| name.as_str()).collect();
    let goals: Vec<String> = options.goal.iter().map(Goal::to_string).collect();
    let objectives: Vec<&str> = options.objective.iter().map(|metric| metric.name()).collect();
    format!(
        "explore, a search for [{}] on the front of [{}], first {}, in {} configurations of digest {}",
        goals.join("; "),
        objectives.join(", "),
        options.first,
        names.len(),
        &digest(names.join("\n").as_bytes())[..16]
    )
}

fn write(arguments: &Arguments, report: &SearchReport, out: &mut dyn Write) -> Result<(), CliError> {
    let folder = &arguments.out;
    let json = ppa::json(report)?;
    let mut files = Vec::new();
    for point in &report.points {
        if let Some(measured) = &point.report {
            files.extend(ppa::files(measured, &folder.join(&point.name))?);
        }
    }
    files.push((folder.join("explore.json"), format!("{json}\n")));
    files.push((folder.join("explore.html"), report.page()));
    write_all(&files)?;
    if arguments.json {
        return Ok(writeln!(out, "{json}")?);
    }
    writeln!(out, "{}\n\n{}\n", report.table(), report.summary())?;
    writeln!(out, "Wrote {0}/explore.html, {0}/explore.json, and each report to {0}/NAME.", folder.display())?;
    Ok(())
}

impl SearchArguments {
    fn needs_visits(&self) -> bool {
        let has_goal = self.goal.iter().any(|goal| goal.metric == Metric::Visits);
        has_goal || self.objective.is_empty() || self.objective.contains(&Metric::Visits)
    }

    /// The metrics of the front. An error if visits are asked for, and a configuration has none.
    fn objectives(&self, space: &Space, visits: &[Option<f64>]) -> Result<Vec<Metric>, CliError> {
        let wanted: BTreeSet<Metric> =
            self.goal.iter().map(|goal| goal.metric).chain(self.objective.iter().copied()).collect();
        let unknown = space.members.iter().zip(visits).find(|(_, visits)| visits.is_none());
        if let Some(((name, config), _)) = unknown.filter(|_| wanted.contains(&Metric::Visits)) {
            let expected = "format fp32, whose visits can be counted";
            return Err(CliError::unusable(format!("visits: {name} is {config}; expected {expected}")));
        }
        if !self.objective.is_empty() {
            return Ok(self.objective.clone());
        }
        let mut objectives = vec![Metric::Area, Metric::Period, Metric::Throughput];
        objectives.extend(unknown.is_none().then_some(Metric::Visits));
        objectives.extend(wanted.contains(&Metric::Energy).then_some(Metric::Energy));
        Ok(objectives)
    }
}

/// The areas of all units of the space, by the digests of their texts.
fn units(bench: &Bench, configs: &[Config], elaborated: &[Elaborated]) -> Result<BTreeMap<String, f64>, CliError> {
    let mut areas = BTreeMap::new();
    let mut unknown: BTreeSet<&String> = BTreeSet::new();
    let mut designs: Vec<Design> = Vec::new();
    for (config, Elaborated { structure, .. }) in configs.iter().zip(elaborated) {
        let mut is_new = false;
        for unit in structure.units.keys().filter(|unit| !areas.contains_key(*unit)).collect::<Vec<_>>() {
            match bench.unit_area(unit) {
                Some(area) => _ = areas.insert(unit.clone(), area),
                None => is_new |= unknown.insert(unit),
            }
        }
        if is_new {
            designs.push(design(*config)?);
        }
    }
    areas.extend(resumable(|watch| bench.unit_areas(&designs, watch))?);
    Ok(areas)
}

/// A configuration with the terms of its predictions, in mm², ns and pJ by a rough estimate.
fn candidate(
    bench: &Bench,
    name: &str,
    config: Config,
    elaborated: &Elaborated,
    visits: Option<f64>,
    units: &BTreeMap<String, f64>,
) -> Candidate {
    let Elaborated { structure, latency } = elaborated;
    let gate = bench.library.nand2_area() / 1e6;
    let area_of = |(unit, count): (&String, &u64)| units.get(unit).copied().unwrap_or(0.0) * *count as f64 / 1e6;
    let units: f64 = structure.units.iter().map(area_of).sum();
    let [registers, gated, muxes] =
        [structure.register_bits, structure.gated_bits, structure.mux_bits].map(|bits| bits as f64);
    let interval = f64::from(config.microarchitecture.interval.cycles());
    let area =
        Terms { known: units, terms: vec![5.0 * gate * registers, 2.0 * gate * muxes, gate * structure.gates, gate] };
    let period = Terms { known: 0.0, terms: vec![0.1 * structure.depth, 1.0] };
    // Energy of a job: of all cycles until the next one.
    let energy = [1000.0 * units, 0.03 * (registers - gated), 0.03 * gated, 0.01 * muxes];
    let energy = Terms { known: 0.0, terms: energy.map(|energy| interval * energy).to_vec() };
    let mut exact = Values::from([(Metric::Throughput, 1.0 / interval), (Metric::Latency, f64::from(*latency))]);
    exact.extend(visits.map(|visits| (Metric::Visits, visits)));
    let terms = [(Metric::Area, area), (Metric::Period, period), (Metric::Energy, energy)];
    Candidate { name: name.to_string(), options: config.options(), exact, terms: terms.into_iter().collect() }
}

/// Measures candidates with Yosys, OpenSTA and, if energy is wanted, a simulation of their gates.
struct Measurer<'a> {
    arguments: &'a Arguments,
    bench: &'a Bench,
    configs: &'a [Config],
    has_energy: bool,
    /// The measurements that the budget still allows.
    left: Option<usize>,
    reports: BTreeMap<usize, Report>,
}

impl Measurer<'_> {
    /// The metrics of candidates; none where the budget is used up.
    fn measure(&mut self, wanted: &[usize]) -> Result<Vec<Option<Values>>, CliError> {
        let mut chosen = Vec::new();
        for candidate in wanted.iter().filter(|candidate| !self.reports.contains_key(candidate)) {
            let design = design(self.configs[*candidate])?;
            let is_new = self.bench.known(&design)?.is_none();
            match &mut self.left {
                Some(0) if is_new => continue,
                Some(left) if is_new => *left -= 1,
                _ => {}
            }
            chosen.push((*candidate, design));
        }
        let designs: Vec<Design> = chosen.iter().map(|(_, design)| design.clone()).collect();
        let reports = self.arguments.bench.measure(&designs)?;
        for ((candidate, design), mut report) in chosen.into_iter().zip(reports) {
            if self.has_energy {
                report.power = Some(self.power(self.configs[candidate], &design, &report)?);
            }
            self.reports.insert(candidate, report);
        }
        Ok(wanted.iter().map(|candidate| self.reports.get(candidate).map(values)).collect())
    }

    /// The power of the jobs of the built-in picture.
    fn power(&self, config: Config, design: &Design, report: &Report) -> Result<Power, CliError> {
        let cache = Cache::new(&self.bench.cache);
        let program = digest(&raypath_tools::read(&std::env::current_exe()?)?);
        let setting = ppa::json(report)?;
        let key = Key::new("picture-power", &[&program, &self.bench.library.digest, &setting]);
        let measure = || -> Result<Power, CliError> {
            let picture = [picture(config)?];
            Ok(resumable(|watch| self.bench.power(design, report, &picture, false, watch))?.power)
        };
        cache.kept(&key, |_| true, measure)
    }
}

/// The measured metrics of a report.
fn values(report: &Report) -> Values {
    let mut values = Values::from([(Metric::Area, report.area.total / 1e6), (Metric::Period, report.slowest.ns)]);
    let power = report.power.iter().flat_map(|power| &power.workloads);
    values.extend(power.filter_map(|workload| workload.picojoules_per_job).map(|energy| (Metric::Energy, energy)));
    values
}
