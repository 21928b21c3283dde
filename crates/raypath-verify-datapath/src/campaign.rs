//! Random campaigns: netlist, cycle-exact model and functional model in lockstep, under random jobs, handshakes and
//! resets. Every coverage point that can be reached must be hit.

pub(crate) mod failure;

use crate::coverage::{CoverageModel, Tracker};
use crate::datapaths::{self, TestedDatapath};
use failure::{Trace, report};
use rand::RngExt;
use raypath_hdl::Module;
use raypath_model::{Shape, WordModel, Words};
use raypath_oracle::stimuli::Stimuli;
use raypath_sim::engine::{NetlistEngine, observe, shape};
use raypath_sim::lockstep::{Difference, SideBySide};
use raypath_sim::traffic::Traffic;
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Level, Request, Verdict, files};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// The folder of the item's files, relative to the working directory.
pub const FOLDER: &str = "build/verify";

/// The stream of the campaign's random numbers.
const STREAM: u64 = 21;
/// The jobs that a pipeline holds at most, whose episodes are the shortest.
const SHALLOW: usize = 64;
/// The number of jobs in the shortest episode.
const JOBS_PER_EPISODE: u64 = 256;
/// Its cycles with random handshakes; afterwards source and sink are always ready, and the remaining jobs pass.
const EVENTFUL_CYCLES: u32 = 1200;
/// The number of jobs for each operation from which on a coverage point without a hit is a failure.
const ENOUGH: u64 = 20_000;

/// Runs the campaign on the request's datapath; at level full also on every one of [`datapaths::all`], unless the user
/// chose one. Writes the coverage to files in `folder`, and failures to subfolders.
///
/// # Errors
/// A configuration cannot be elaborated, or a file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let one = run(request, &[Entry::new(TestedDatapath::of(request))?], jobs(request), folder)?;
    if request.is_chosen || request.level == Level::Regression || one.is_stopped {
        return Ok(one);
    }
    let entries = datapaths::all().into_iter().map(Entry::new).collect::<Result<Vec<_>, _>>()?;
    let each = run(request, &entries, request.level.pick(0, 100_000, 1_000_000), folder)?;
    Ok(one.and(each))
}

/// The number of jobs of a single datapath.
fn jobs(request: &Request<'_>) -> u64 {
    request.jobs.unwrap_or(request.level.pick(1_000_000, 4_000_000, 400_000_000))
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
    let entry = Entry { top: top.clone(), shape: shape.clone(), ..Entry::new(TestedDatapath::of(request))? };
    run(request, &[entry], jobs(request), folder)
}

/// A datapath, and the module that is compared with its models.
struct Entry {
    subject: TestedDatapath,
    top: Arc<Module>,
    shape: Shape,
    model: WordModel,
    coverage: CoverageModel,
}

impl Entry {
    fn new(subject: TestedDatapath) -> Result<Self, Error> {
        let datapath = subject.datapath();
        let (netlist, model) = (datapath.elaborate()?, datapath.model());
        let shape = shape(subject.config, &netlist);
        Ok(Self { top: netlist.top().clone(), coverage: CoverageModel::new(&model, &shape), subject, shape, model })
    }

    fn netlist(&self) -> Result<NetlistEngine, Error> {
        let (model, shape) = (self.model.clone(), self.shape.clone());
        Ok(NetlistEngine::of_module(model, self.subject.config, &self.top, shape, |_| false)?)
    }

    /// The episode with this number in the campaign of this seed: the deeper the pipeline, the longer.
    fn episode(&self, seed: u64, number: u64) -> Episode {
        Episode::new(&self.model, self.shape.capacity().div_ceil(SHALLOW) as u32, seed, number)
    }

    /// Runs an episode up to the first difference.
    fn run(&self, netlist: &mut NetlistEngine, episode: Episode) -> Found {
        let mut tracker = Tracker::new(&self.coverage, &episode.jobs);
        netlist.restart_randomly(episode.initial);
        let is_different = Cell::new(false);
        let mut engines = SideBySide::new(netlist, self.model.clone(), |_: Difference| is_different.set(true));
        let mut traffic = episode.traffic;
        let cycles = observe(&mut engines, episode.jobs.iter(), &mut traffic, |seen| {
            tracker.observe(seen);
            !is_different.get()
        });
        let difference = engines.differences.into_iter().next();
        Found { cycles: cycles.cycles, points: tracker.finish(), difference }
    }
}

/// A sequence of jobs and handshakes that starts from a new netlist's state. An episode therefore fails alone as it
/// fails in the campaign.
pub struct Episode {
    jobs: Vec<Words>,
    traffic: Traffic,
    /// The cycles with random handshakes.
    eventful_cycles: u32,
    /// The seed of the state that the netlist begins in.
    initial: u64,
}

/// The result of an episode.
struct Found {
    cycles: u64,
    points: BTreeSet<String>,
    /// The difference that ended the episode.
    difference: Option<String>,
}

impl Episode {
    /// The episode with this number in the campaign of this seed, so many times as long as the shortest.
    pub fn new(model: &WordModel, length: u32, seed: u64, number: u64) -> Self {
        let rng = &mut Campaign::of_episodes(STREAM, 0).rng(seed, number);
        let (mut stimuli, mut words) = (Stimuli::new(model, rng.random()), Vec::new());
        let jobs = (0..JOBS_PER_EPISODE * u64::from(length)).map(|_| {
            let kind = stimuli.next(&mut words);
            model.job_of_words(kind, &words)
        });
        let jobs = jobs.collect();
        let eventful_cycles = EVENTFUL_CYCLES * length;
        let traffic = Traffic::eventful(rng.random(), eventful_cycles, length);
        Self { jobs, traffic, eventful_cycles, initial: rng.random() }
    }

    /// The episode as a trace of jobs and cycles.
    pub fn trace(self) -> Trace {
        let mut traffic = self.traffic;
        Trace { jobs: self.jobs, cycles: (0..self.eventful_cycles).map(|_| traffic.next_cycle()).collect() }
    }
}

/// Runs so many jobs of each datapath, and more of a deep one.
fn run(request: &mut Request<'_>, entries: &[Entry], jobs: u64, folder: &Path) -> Result<Verdict, Error> {
    let episodes = jobs.div_ceil(JOBS_PER_EPISODE);
    let campaign = Campaign::of_episodes(STREAM, episodes * entries.len() as u64);
    let (seed, entry) = (request.seed, |number: u64| (number / episodes) as usize);
    let netlist = || Ok(None::<(usize, NetlistEngine)>);
    let (tally, is_stopped) = campaign.run(request, netlist, |compiled, number, _, tally| {
        let (index, entry) = (entry(number), &entries[entry(number)]);
        let (_, netlist) = match compiled.take_if(|(of, _)| *of == index) {
            Some(same) => compiled.insert(same),
            None => compiled.insert((index, entry.netlist()?)),
        };
        let episode = entry.episode(seed, number);
        tally.add("jobs", episode.jobs.len() as u64);
        let found = entry.run(netlist, episode);
        tally.add("cycles", found.cycles);
        tally.add(format!("{index}"), 1_u64);
        found.points.into_iter().for_each(|point| tally.add(format!("{index} {point}"), 1_u64));
        found.difference.into_iter().for_each(|difference| tally.fail(|| difference));
        Ok(())
    })?;
    let mut verdict = verdict(entries, &tally, folder)?;
    verdict.is_stopped = is_stopped;
    if let Some((number, what)) = tally.first_failure() {
        let entry = &entries[entry(number)];
        let episode = entry.episode(seed, number);
        let folder = folder.join(format!("failure-{seed}-{number}"));
        let mut netlist = entry.netlist()?;
        netlist.restart_randomly(episode.initial);
        let message = report(&mut netlist, &entry.model, &entry.subject, episode.trace(), &folder)?;
        let of = if entries.len() == 1 { String::new() } else { format!("{}, ", entry.subject) };
        verdict.failures.push(format!("{of}episode {number}: {what}\n           {message}"));
    }
    Ok(verdict)
}

/// What the episodes covered. The file has the number of episodes that hit each point.
fn verdict(entries: &[Entry], tally: &Tally, folder: &Path) -> Result<Verdict, Error> {
    const SHOWN: usize = 12;
    let (mut text, mut all, mut episodes, mut verdict) = (String::new(), 0, 0, Verdict::default());
    let mut is_covered = true;
    for (index, Entry { subject, coverage, model, .. }) in entries.iter().enumerate() {
        let (points, run) = (coverage.points(), tally.count(&index.to_string()));
        let count = |point: &String| tally.count(&format!("{index} {point}"));
        // Writing to a String always succeeds.
        let _ = writeln!(text, "# {subject}: {run} episodes");
        points.iter().for_each(|point| _ = writeln!(text, "{:>10} {point}", count(point)));
        let missing: Vec<&str> = points.iter().filter(|point| count(point) == 0).map(String::as_str).collect();
        if !missing.is_empty() {
            is_covered = false;
            let more = if missing.len() > SHOWN { "; …" } else { "" };
            let shown = missing[..missing.len().min(SHOWN)].join("; ");
            let remark = format!("{subject}: not covered: {} of {} points: {shown}{more}", missing.len(), points.len());
            let is_enough = run * JOBS_PER_EPISODE >= ENOUGH * model.kinds().len() as u64 && tally.failures() == 0;
            if is_enough { &mut verdict.failures } else { &mut verdict.remarks }.push(remark);
        }
        (all, episodes) = (all + points.len(), episodes + run);
    }
    let path = folder.join(if entries.len() == 1 { "coverage.txt" } else { "coverage-of-all.txt" });
    files::write(&path, &text)?;
    let (cycles, jobs) = (tally.count("cycles"), tally.count("jobs"));
    let of = if entries.len() == 1 { String::new() } else { format!(" of {} datapaths", entries.len()) };
    verdict.covered = format!("{cycles} netlist cycles, {jobs} jobs, {episodes} episodes{of}");
    let is_covered = if is_covered { "all are covered" } else { "some are not covered" };
    verdict.remarks.push(format!("{all} coverage points, {is_covered} ({})", path.display()));
    Ok(verdict)
}
