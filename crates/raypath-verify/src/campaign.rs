//! Random campaigns: netlist, cycle-exact model and functional model in lockstep, under random jobs, handshakes and
//! resets.

mod episode;
mod failure;

use crate::coverage::{Coverage, CoverageModel};
use crate::files;
use crate::layout::Layout;
use crate::{Error, Request, Verdict};
use episode::{Episode, JOBS_PER_EPISODE};
use failure::{Failure, report};
use raypath_hdl::Module;
use raypath_model::{Shape, WordModel};
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::{NetlistEngine, shape};
use raypath_tools::pool::{self, Queue};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// The folder of the item's files, relative to the working directory.
pub const FOLDER: &str = "build/verify";

/// Runs the campaign on a configuration's netlist. Writes the coverage to `coverage.txt` in `folder`, and failures to
/// subfolders.
///
/// # Errors
/// The configuration cannot be elaborated, or a file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let datapath = Datapath::new(request.config)?;
    verify_module(request, datapath.top(), &shape(request.config, &datapath), folder)
}

/// Runs the campaign on a module with the ports of the request's configuration and this pipeline shape. The module is
/// compared with the configuration's models.
///
/// # Errors
/// The module has other ports, or a file cannot be written.
pub fn verify_module(
    request: &mut Request<'_>,
    top: &Arc<Module>,
    shape: &Shape,
    folder: &Path,
) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(300_000, 45_000_000, 450_000_000));
    let (config, seed) = (request.config, request.seed);
    let episodes = jobs.div_ceil(JOBS_PER_EPISODE as u64);
    let cases = request.cases(episodes, 1);
    let campaign = Campaign { config, seed, top, shape, model: raypath_sim::Datapath::paper(config).model() };
    let points = campaign.coverage_model();
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| campaign.work(queue))?;
        is_stopped = finished.is_stopped;
        Ok::<_, Error>(joined(&points, finished.workers))
    })?;
    let (coverage, tally) = joined(&points, shards);
    let presented = tally.episodes * JOBS_PER_EPISODE as u64;
    let mut verdict = Verdict { is_stopped, ..Verdict::default() };
    verdict.covered = format!("{} netlist cycles, {presented} jobs, {} episodes", tally.cycles, tally.episodes);
    let path = folder.join("coverage.txt");
    files::write(&path, &coverage.table(&points))?;
    verdict.remarks.push(format!("{} ({})", coverage.remark(&points, true), path.display()));
    if let Some(failure) = tally.failure {
        verdict.failures.push(campaign.report(&failure, folder)?);
    }
    Ok(verdict)
}

/// The sum of the counts of workers or shards.
fn joined(points: &CoverageModel, counts: Vec<(Coverage, Tally)>) -> (Coverage, Tally) {
    let mut all = (Coverage::new(points), Tally::default());
    for (covered, counted) in counts {
        all.0.add(&covered);
        all.1.add(counted);
    }
    all
}

/// The counts of a worker, or of all.
#[derive(Default, Serialize, Deserialize)]
struct Tally {
    cycles: u64,
    episodes: u64,
    /// The failure with the smallest episode number.
    failure: Option<Failure>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.episodes += other.episodes;
        self.failure = self.failure.take().into_iter().chain(other.failure).min_by_key(|failure| failure.episode);
    }
}

/// The subject of a campaign.
struct Campaign<'c> {
    config: Config,
    seed: u64,
    top: &'c Arc<Module>,
    shape: &'c Shape,
    model: WordModel,
}

impl Campaign<'_> {
    /// Runs episodes of the queue.
    fn work(&self, queue: &Queue<Error>) -> Result<(Coverage, Tally), Error> {
        let points = self.coverage_model();
        let layout = Layout::of(&self.model);
        let mut netlist = self.netlist()?;
        let (mut coverage, mut tally) = (Coverage::new(&points), Tally::default());
        queue.run(|number, stop| {
            let episode = Episode::new(&self.model, &layout, self.config, self.seed, number);
            let found = episode.run(&mut netlist, &self.model, Some((&points, &mut coverage)));
            let what = found.differences.into_iter().next();
            if what.is_some() {
                stop.store(true, Ordering::Relaxed);
            }
            let failure = what.map(|what| Failure { episode: number, what });
            tally.add(Tally { cycles: found.cycles, episodes: 1, failure });
            Ok(())
        });
        Ok((coverage, tally))
    }

    fn coverage_model(&self) -> CoverageModel {
        CoverageModel::new(self.config, self.shape, Layout::of(&self.model))
    }

    fn netlist(&self) -> Result<NetlistEngine, Error> {
        Ok(NetlistEngine::of_module(self.model.clone(), self.config, self.top, self.shape.clone(), |_| false)?)
    }

    /// Shrinks a failure and writes it to files.
    fn report(&self, failure: &Failure, folder: &Path) -> Result<String, Error> {
        let layout = Layout::of(&self.model);
        let episode = Episode::new(&self.model, &layout, self.config, self.seed, failure.episode);
        let folder = folder.join(format!("failure-{}-{}", self.seed, failure.episode));
        let mut netlist = self.netlist()?;
        netlist.restart_randomly(episode.initial);
        report(&mut netlist, &self.model, self.config, episode.trace(), failure, &folder)
    }
}
