//! Random campaigns: netlist, cycle-exact model and functional model in lockstep, under random jobs, handshakes and
//! resets. Every coverage point that can be reached must be hit.

mod episode;
mod failure;

use crate::coverage::{Counted, Coverage, CoverageModel};
use crate::layout::Layout;
use crate::subjects::{self, Subject};
pub use episode::Episode;
use episode::JOBS_PER_EPISODE;
use failure::{Failure, report};
use raypath_hdl::Module;
use raypath_model::{Shape, WordModel};
use raypath_sim::engine::{NetlistEngine, shape};
use raypath_tools::pool::{self, Queue};
use raypath_verify::files;
use raypath_verify::{Error, Level, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// The folder of the item's files, relative to the working directory.
pub const FOLDER: &str = "build/verify";

/// The number of jobs for each operation from which on a coverage point without a hit is a failure.
const ENOUGH: u64 = 75_000;
/// The number of jobs for each operation from which on a point must have a hit on each path.
const ENOUGH_FOR_PATHS: u64 = 250_000;
/// The number of jobs for each operation of a datapath at level full.
const JOBS_AT_FULL: u64 = 100_000;

/// Runs the campaign on the request's datapath; at level full also on every datapath of [`subjects`], unless the user
/// chose one. Writes the coverage to files in `folder`, and failures to subfolders.
///
/// # Errors
/// A configuration cannot be elaborated, or a file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = jobs(request);
    let one = Campaign::new(request, vec![Entry::new(Subject::of(request))?], jobs).run(request, folder)?;
    if request.is_chosen || request.level == Level::Regression || one.is_stopped {
        return Ok(one);
    }
    let entries = subjects::all().into_iter().map(Entry::new).collect::<Result<Vec<_>, _>>()?;
    let most = entries.iter().map(|entry| entry.model.kinds().len() as u64).max().unwrap_or(0);
    let jobs = request.level.pick(0, JOBS_AT_FULL, 3 * JOBS_AT_FULL) * most;
    let each = Campaign::new(request, entries, jobs).run(request, folder)?;
    Ok(Verdict {
        covered: format!("{}; {}", one.covered, each.covered),
        failures: [one.failures, each.failures].concat(),
        remarks: [one.remarks, each.remarks].concat(),
        is_stopped: each.is_stopped,
    })
}

/// The number of jobs of a single datapath.
fn jobs(request: &Request<'_>) -> u64 {
    request.jobs.unwrap_or(request.level.pick(1_000_000, 45_000_000, 450_000_000))
}

/// Runs the campaign on a module with the ports of the request's datapath and this pipeline shape. The module is
/// compared with the datapath's models.
///
/// # Errors
/// The module has other ports, or a file cannot be written.
pub fn verify_module(
    request: &mut Request<'_>,
    top: &Arc<Module>,
    shape: &Shape,
    folder: &Path,
) -> Result<Verdict, Error> {
    let entry = Entry { top: top.clone(), shape: shape.clone(), ..Entry::new(Subject::of(request))? };
    let jobs = jobs(request);
    Campaign::new(request, vec![entry], jobs).run(request, folder)
}

/// A datapath, and the module that is compared with its models.
struct Entry {
    subject: Subject,
    top: Arc<Module>,
    shape: Shape,
    model: WordModel,
    layout: Layout,
    points: CoverageModel,
}

impl Entry {
    fn new(subject: Subject) -> Result<Self, Error> {
        let datapath = subject.datapath();
        let (netlist, model) = (datapath.elaborate()?, datapath.model());
        let shape = shape(subject.config, &netlist);
        let points = CoverageModel::new(subject.config.semantics, &shape, &model);
        Ok(Self { top: netlist.top().clone(), layout: Layout::of(&model), subject, shape, model, points })
    }

    fn netlist(&self) -> Result<NetlistEngine, Error> {
        let (model, shape) = (self.model.clone(), self.shape.clone());
        Ok(NetlistEngine::of_module(model, self.subject.config, &self.top, shape, |_| false)?)
    }

    fn episode(&self, seed: u64, number: u64) -> Episode {
        Episode::new(&self.model, &self.layout, seed, number)
    }
}

/// The counts of a worker, or of all.
#[derive(Serialize, Deserialize)]
struct Tally {
    cycles: u64,
    episodes: u64,
    /// Of each datapath.
    coverage: Vec<Coverage>,
    /// The failure with the smallest episode number.
    failure: Option<Failure>,
}

impl Tally {
    fn and(mut self, other: Self) -> Self {
        self.cycles += other.cycles;
        self.episodes += other.episodes;
        self.coverage.iter_mut().zip(&other.coverage).for_each(|(coverage, more)| coverage.add(more));
        self.failure = self.failure.into_iter().chain(other.failure).min_by_key(|failure| failure.episode);
        self
    }
}

/// Datapaths, each with the same number of episodes.
struct Campaign {
    seed: u64,
    entries: Vec<Entry>,
    episodes: u64,
}

impl Campaign {
    fn new(request: &Request<'_>, entries: Vec<Entry>, jobs: u64) -> Self {
        Self { seed: request.seed, entries, episodes: jobs.div_ceil(JOBS_PER_EPISODE as u64) }
    }

    fn run(&self, request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
        let cases = request.cases(self.episodes * self.entries.len() as u64, 1);
        let mut is_stopped = false;
        let shards = request.parts.phase(|| {
            let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| self.work(queue))?;
            is_stopped = finished.is_stopped;
            Ok::<_, Error>(finished.workers.into_iter().fold(self.tally(), Tally::and))
        })?;
        let tally = shards.into_iter().fold(self.tally(), Tally::and);
        self.verdict(tally, is_stopped, folder)
    }

    fn tally(&self) -> Tally {
        let coverage = self.entries.iter().map(|entry| Coverage::new(&entry.points)).collect();
        Tally { cycles: 0, episodes: 0, coverage, failure: None }
    }

    /// Runs episodes of the queue.
    fn work(&self, queue: &Queue<Error>) -> Result<Tally, Error> {
        let mut tally = self.tally();
        let mut compiled: Option<(usize, NetlistEngine)> = None;
        queue.run(|number, stop| {
            let index = (number / self.episodes) as usize;
            let entry = &self.entries[index];
            let (_, netlist) = match compiled.take_if(|(of, _)| *of == index) {
                Some(same) => compiled.insert(same),
                None => compiled.insert((index, entry.netlist()?)),
            };
            let coverage = Some((&entry.points, &mut tally.coverage[index]));
            let found = entry.episode(self.seed, number).run(netlist, &entry.model, coverage);
            tally.cycles += found.cycles;
            tally.episodes += 1;
            if let Some(what) = found.differences.into_iter().next() {
                stop.store(true, Ordering::Relaxed);
                tally.failure.get_or_insert(Failure { episode: number, what });
            }
            Ok(())
        });
        Ok(tally)
    }

    fn verdict(&self, tally: Tally, is_stopped: bool, folder: &Path) -> Result<Verdict, Error> {
        let Tally { cycles, episodes, coverage, failure } = tally;
        let (presented, count) = (episodes * JOBS_PER_EPISODE as u64, self.entries.len());
        let of = if count == 1 { String::new() } else { format!(" of {count} datapaths") };
        let mut verdict = Verdict { is_stopped, ..Verdict::default() };
        verdict.covered = format!("{cycles} netlist cycles, {presented} jobs, {episodes} episodes{of}");
        let is_whole = episodes == self.episodes * count as u64 && failure.is_none();
        let (mut text, mut points, mut is_covered) = (String::new(), 0, true);
        for (entry, coverage) in self.entries.iter().zip(&coverage) {
            if count > 1 {
                text += &format!("# {}\n", entry.subject);
            }
            text += &coverage.table(&entry.points);
            let jobs = self.episodes * JOBS_PER_EPISODE as u64 / entry.model.kinds().len().max(1) as u64;
            let counted = if jobs >= ENOUGH_FOR_PATHS { Counted::ByPath } else { Counted::OnAnyPath };
            let (total, uncovered) = coverage.uncovered(&entry.points, counted);
            points += total;
            if !uncovered.is_empty() {
                is_covered = false;
                let remark = coverage.remark(&entry.points, counted);
                let to = if is_whole && jobs >= ENOUGH { &mut verdict.failures } else { &mut verdict.remarks };
                to.push(if count == 1 { remark } else { format!("{}: {remark}", entry.subject) });
            }
        }
        let path = folder.join(if count == 1 { "coverage.txt" } else { "coverage-of-all.txt" });
        files::write(&path, &text)?;
        let all = if is_covered { "all are covered" } else { "some are not covered" };
        verdict.remarks.push(format!("{points} coverage points, {all} ({})", path.display()));
        if let Some(failure) = failure {
            verdict.failures.push(self.report(&failure, folder)?);
        }
        Ok(verdict)
    }

    /// Shrinks a failure and writes it to files.
    fn report(&self, failure: &Failure, folder: &Path) -> Result<String, Error> {
        let entry = &self.entries[(failure.episode / self.episodes) as usize];
        let episode = entry.episode(self.seed, failure.episode);
        let folder = folder.join(format!("failure-{}-{}", self.seed, failure.episode));
        let mut netlist = entry.netlist()?;
        netlist.restart_randomly(episode.initial);
        let message = report(&mut netlist, &entry.model, &entry.subject, episode.trace(), failure, &folder)?;
        Ok(if self.entries.len() == 1 { message } else { format!("{}, {message}", entry.subject) })
    }
}
