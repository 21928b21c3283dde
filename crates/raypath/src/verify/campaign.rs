//! Random campaigns: netlist, cycle-exact model and functional model side by side in every cycle, whatever source, sink
//! and reset do.

mod episode;
mod failure;

pub(crate) use episode::mixed;
pub use episode::{Episode, Found, JOBS_PER_EPISODE};
pub use failure::{Failure, report};

use crate::engine::{NetlistEngine, shape};
use crate::models::{PaperModel, Visitor, with_model};
use crate::verify::coverage::{Atlas, Coverage};
use crate::verify::layout::Layout;
use crate::verify::parallel::{self, Queue};
use crate::verify::{Error, Item, Request, Verdict, files};
use raypath_hdl::Module;
use raypath_model::Shape;
use raypath_rtl::{Config, Datapath};
use std::path::Path;
use std::sync::Arc;

/// The item of `raypath verify`.
pub const ITEM: Item = Item {
    name: "campaign",
    claim: "netlist, cycle-exact model and functional model show the same at all ports in every cycle, whatever jobs \
            come and whatever source, sink and reset do",
    oracle: "the cycle-exact model, which shares no code with the netlist's control and units, and the functional model",
    run: |request| verify(request, Path::new(FOLDER)),
};

/// Where the item leaves its files.
pub const FOLDER: &str = "build/verify";

/// Runs the campaign on a configuration's netlist. The coverage goes to `coverage.txt` in `folder`, and what fails to
/// folders in it.
///
/// # Errors
/// A configuration that cannot be elaborated, files that cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let datapath = Datapath::new(request.config)?;
    verify_module(request, datapath.top(), &shape(request.config, &datapath), folder)
}

/// The same for any module with the ports of the request's configuration, which should behave as that does and whose
/// datapath has this shape.
///
/// # Errors
/// A module without those ports, files that cannot be written.
pub fn verify_module(
    request: &mut Request<'_>,
    top: &Arc<Module>,
    shape: &Shape,
    folder: &Path,
) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(EVERYDAY, FULL, LONG));
    let (config, seed) = (request.config, request.seed);
    let episodes = jobs.div_ceil(JOBS_PER_EPISODE as u64);
    let (answers, is_stopped) =
        parallel::run(request, episodes, |queue| with_model(config, Worker { config, seed, top, shape, queue }));
    let mut all = Tally::default();
    let mut coverage: Option<(Atlas, Coverage)> = None;
    for answer in answers {
        let (atlas, tally) = answer?;
        match &mut coverage {
            Some((_, coverage)) => coverage.add(&tally.coverage),
            None => coverage = Some((atlas, tally.coverage)),
        }
        all.cycles += tally.cycles;
        all.episodes += tally.episodes;
        all.failure = all.failure.into_iter().chain(tally.failure).min_by_key(|failure| failure.episode);
    }
    let mut verdict = Verdict { is_stopped, ..Verdict::default() };
    let presented = all.episodes * JOBS_PER_EPISODE as u64;
    verdict.covered = format!("{} netlist cycles, {presented} jobs, {} episodes", all.cycles, all.episodes);
    if let Some((atlas, coverage)) = coverage {
        let path = folder.join("coverage.txt");
        files::write(&path, &coverage.table(&atlas))?;
        verdict.remarks.push(format!("{} ({})", coverage.remark(&atlas, true), path.display()));
    }
    if let Some(failure) = all.failure {
        verdict.failures.push(with_model(config, Reporter { config, seed, top, shape, folder, failure })?);
    }
    Ok(verdict)
}

/// Jobs by level: seconds, a quarter of an hour, hours.
const EVERYDAY: u64 = 300_000;
const FULL: u64 = 45_000_000;
const LONG: u64 = 450_000_000;

/// What one worker found.
struct Tally<C = ()> {
    cycles: u64,
    episodes: u64,
    coverage: C,
    failure: Option<Failure>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { cycles: 0, episodes: 0, coverage: (), failure: None }
    }
}

struct Worker<'w> {
    config: Config,
    seed: u64,
    top: &'w Arc<Module>,
    shape: &'w Shape,
    queue: &'w Queue,
}

impl Visitor for Worker<'_> {
    type Answer = Result<(Atlas, Tally<Coverage>), Error>;

    fn visit<M: PaperModel>(self, model: M) -> Self::Answer {
        let Self { config, seed, top, shape, queue } = self;
        let layout = Layout::of(&model);
        let atlas = Atlas::new(config, shape, layout.clone());
        let mut netlist = NetlistEngine::of_module(model.clone(), config, top, shape.clone(), |_| false)?;
        let mut tally = Tally { cycles: 0, episodes: 0, coverage: Coverage::new(&atlas), failure: None };
        while let Some(number) = queue.next() {
            let episode = Episode::new(&model, &layout, config, seed, number);
            let found = episode.run(&mut netlist, &model, Some((&atlas, &mut tally.coverage)));
            tally.cycles += found.cycles;
            tally.episodes += 1;
            if let Some(what) = found.differences.into_iter().next() {
                tally.failure = Some(Failure { episode: number, what });
                queue.end();
            }
        }
        Ok((atlas, tally))
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
