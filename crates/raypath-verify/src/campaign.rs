//! Random campaigns: netlist, cycle-exact model and functional model in lockstep, under random jobs, handshakes and
//! resets.

mod episode;
mod failure;
pub mod shrink;

pub use episode::{Episode, Found, JOBS_PER_EPISODE};
pub use failure::{Failure, report};

use crate::coverage::{Coverage, CoverageModel};
use crate::error::Error;
use crate::files;
use crate::layout::Layout;
use crate::pool::{self, Cases, Queue};
use crate::request::Request;
use crate::verdict::{Item, Verdict};
use raypath_hdl::Module;
use raypath_model::Shape;
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::{NetlistEngine, shape};
use raypath_sim::models::{PaperModel, Visitor, with_model};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// The campaign on a configuration's netlist.
pub const ITEM: Item = Item {
    name: "campaign",
    claim: "netlist, cycle-exact model and functional model agree at all ports in every cycle, for random jobs and any \
            behaviour of source, sink and reset",
    oracle: "the cycle-exact and the functional model, which share the operations' functions with the netlist, but \
             neither units nor control",
    subject: &[
        "crates/raypath-float/src",
        "crates/raypath-hdl/src",
        "crates/raypath-sim/src",
        "crates/raypath-model/src",
        "crates/raypath-ops/src",
        "crates/raypath-rtl/src",
        "crates/raypath-verify/src/campaign.rs",
        "crates/raypath-verify/src/campaign",
        "crates/raypath-verify/src/stimuli",
    ],
    run: |request| verify(request, Path::new(FOLDER)),
};

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
    let jobs = request.jobs.unwrap_or(request.level.pick(REGRESSION, FULL, LONG));
    let (config, seed) = (request.config, request.seed);
    let episodes = jobs.div_ceil(JOBS_PER_EPISODE as u64);
    let cases = Cases { total: episodes, shard: request.shard };
    let finished =
        pool::run(cases, request.proceed, |queue| with_model(config, Worker { config, seed, top, shape, queue }))?;
    let (points, mut coverage) = with_model(config, NoCoverage { config, shape });
    let mut tally = Tally::default();
    for (covered, counted) in finished.workers {
        coverage.add(&covered);
        tally.add(counted);
    }
    let presented = tally.episodes * JOBS_PER_EPISODE as u64;
    let mut verdict = Verdict { is_stopped: finished.is_stopped, ..Verdict::default() };
    verdict.covered = format!("{} netlist cycles, {presented} jobs, {} episodes", tally.cycles, tally.episodes);
    let path = folder.join("coverage.txt");
    files::write(&path, &coverage.table(&points))?;
    verdict.remarks.push(format!("{} ({})", coverage.remark(&points, true), path.display()));
    if let Some(failure) = tally.failure {
        verdict.failures.push(with_model(config, Reporter { config, seed, top, shape, folder, failure })?);
    }
    Ok(verdict)
}

/// Jobs by level: seconds, a quarter of an hour, hours.
const REGRESSION: u64 = 300_000;
const FULL: u64 = 45_000_000;
const LONG: u64 = 450_000_000;

/// The counts of a worker, or of all.
#[derive(Default)]
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

/// Runs episodes of the queue.
struct Worker<'w> {
    config: Config,
    seed: u64,
    top: &'w Arc<Module>,
    shape: &'w Shape,
    queue: &'w Queue,
}

impl Visitor for Worker<'_> {
    type Answer = Result<(Coverage, Tally), Error>;

    fn visit<M: PaperModel>(self, model: M) -> Self::Answer {
        let Self { config, seed, top, shape, queue } = self;
        let layout = Layout::of(&model);
        let points = CoverageModel::new(config, shape, layout.clone());
        let mut netlist = NetlistEngine::of_module(model.clone(), config, top, shape.clone(), |_| false)?;
        let (mut coverage, mut tally) = (Coverage::new(&points), Tally::default());
        queue.run(|number, stop| {
            let episode = Episode::new(&model, &layout, config, seed, number);
            let found = episode.run(&mut netlist, &model, Some((&points, &mut coverage)));
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
}

/// The coverage of a campaign that has not begun.
struct NoCoverage<'n> {
    config: Config,
    shape: &'n Shape,
}

impl Visitor for NoCoverage<'_> {
    type Answer = (CoverageModel, Coverage);

    fn visit<M: PaperModel>(self, model: M) -> Self::Answer {
        let points = CoverageModel::new(self.config, self.shape, Layout::of(&model));
        let coverage = Coverage::new(&points);
        (points, coverage)
    }
}

struct Reporter<'r> {
    config: Config,
    seed: u64,
    top: &'r Arc<Module>,
    shape: &'r Shape,
    folder: &'r Path,
    failure: Failure,
}

impl Visitor for Reporter<'_> {
    type Answer = Result<String, Error>;

    fn visit<M: PaperModel>(self, model: M) -> Self::Answer {
        let Self { config, seed, top, shape, folder, failure } = self;
        let mut netlist = NetlistEngine::of_module(model.clone(), config, top, shape.clone(), |_| false)?;
        let layout = Layout::of(&model);
        let episode = Episode::new(&model, &layout, config, seed, failure.episode);
        let name = format!("failure-{seed}-{}", failure.episode);
        report(&mut netlist, &model, config, episode.trace(), &failure, &folder.join(name))
    }
}
