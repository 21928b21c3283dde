//! The functional model against the oracle, and the cycle-exact model against the functional one, job by job.

mod chunk;

use crate::campaign;
use crate::coverage::{Coverage, CoverageModel};
use crate::error::Error;
use crate::files;
use crate::layout::Layout;
use crate::oracle::Oracle;
use crate::request::Request;
use crate::verdict::{Item, Verdict};
use chunk::{Chunk, Failure, JOBS_PER_CHUNK};
use raypath_model::{Functional, Shape};
use raypath_ops::{Job, Rules};
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_sim::transactions::{Transaction, text};
use raypath_tools::pool::{self, Cases};
use std::path::Path;
use std::sync::atomic::Ordering;

/// The models against the oracle.
pub const ITEM: Item = Item {
    name: "models",
    claim: "the functional model's outcomes are those of Table VII and the rules `paper`, and the cycle-exact model \
            has the same outcomes, in order (16 lanes, binary32)",
    oracle: "the same operations written once more from the text, in binary64 arithmetic rounded once",
    subject: &[
        "crates/raypath-model/src",
        "crates/raypath-ops/src",
        "crates/raypath-verify/src/models.rs",
        "crates/raypath-verify/src/models",
        "crates/raypath-verify/src/oracle.rs",
        "crates/raypath-verify/src/stimuli",
    ],
    run: |request| verify(request, Path::new(campaign::FOLDER)),
};

/// The oracle's configuration.
const CONFIG: Config = Config::DEFAULT;
/// Jobs by level: seconds, minutes, an hour.
const REGRESSION: u64 = 8_000_000;
const FULL: u64 = 200_000_000;
const LONG: u64 = 1_000_000_000;

/// The counts of a worker.
struct Tally {
    jobs: u64,
    coverage: Coverage,
    wrong: Option<Failure>,
}

/// Runs the jobs. Writes a failure to a subfolder of `folder`.
///
/// # Errors
/// A file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(REGRESSION, FULL, LONG));
    let seed = request.seed;
    let layout = Layout::of(&Datapath::paper(CONFIG).model());
    let points = CoverageModel::new(CONFIG, &Shape::default(), layout.clone());
    let chunks = jobs.div_ceil(JOBS_PER_CHUNK);
    let cases = Cases { total: chunks, shard: request.shard };
    let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
        let mut tally = Tally { jobs: 0, coverage: Coverage::new(&points), wrong: None };
        queue.run(|number, stop| {
            tally.jobs += JOBS_PER_CHUNK;
            if let Some(wrong) = Chunk::new(&layout, CONFIG, seed, number).run(&points, &mut tally.coverage) {
                tally.wrong.get_or_insert(wrong);
                stop.store(true, Ordering::Relaxed);
            }
            Ok(())
        });
        Ok(tally)
    })?;
    let mut verdict = Verdict { is_stopped: finished.is_stopped, ..Verdict::default() };
    let (mut coverage, mut jobs, mut wrong) = (Coverage::new(&points), 0, None);
    for tally in finished.workers {
        coverage.add(&tally.coverage);
        jobs += tally.jobs;
        wrong = wrong.into_iter().chain(tally.wrong).min_by_key(|wrong: &Failure| (wrong.chunk, wrong.job));
    }
    verdict.covered = format!("{jobs} jobs through oracle, functional model and cycle-exact model");
    verdict.remarks.push(format!("{}, counted for one job in {}", coverage.remark(&points, false), chunk::COUNTED));
    let is_other = (request.config.semantics.rules, request.config.semantics.format)
        != (CONFIG.semantics.rules, CONFIG.semantics.format);
    if is_other || request.config.semantics.lanes != CONFIG.semantics.lanes {
        verdict
            .remarks
            .push("the oracle is for rules paper, 16 lanes and binary32: this configuration was run".to_string());
    }
    if let Some(wrong) = wrong {
        verdict.failures.push(report(&layout, seed, &wrong, folder)?);
    }
    Ok(verdict)
}

/// Writes the job with the wrong outcome, and the beats of its sum, as a transaction file with the oracle's outcomes.
fn report(layout: &Layout, seed: u64, wrong: &Failure, folder: &Path) -> Result<String, Error> {
    let Failure { chunk, job, what } = wrong;
    let mut jobs = Chunk::new(layout, CONFIG, seed, *chunk).jobs_up_to(*job);
    let kind = jobs.last().map_or(raypath_ops::JobKind::Triangle, Job::kind);
    jobs.retain(|job| job.kind() == kind);
    let differs = |jobs: &[Job]| {
        let (mut oracle, mut model) = (Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        jobs.iter().any(|job| oracle.run(job) != model.run(job))
    };
    // Earlier jobs matter for sums: the shortest sequence that still fails is enough.
    let fewest = (0..jobs.len()).rev().find(|&first| differs(&jobs[first..])).unwrap_or(0);
    let (mut oracle, model) = (Oracle::default(), Datapath::paper(CONFIG).model());
    let numbered = (0..).zip(&jobs[fewest..]);
    let transaction = |(seq, job): (u64, &Job)| {
        let expected = model.paper_outcome(&oracle.run(job))?;
        Some(Transaction { seq, category: 0, job: model.paper_job(job)?, expected })
    };
    let stream: Vec<Transaction> = numbered.filter_map(transaction).collect();
    let path = folder.join(format!("failure-models-{seed}-{chunk}")).join(format!("{kind}.txt"));
    let text = model.kind(kind.name()).map(|kind| text(&model, kind, &stream, CONFIG)).unwrap_or_default();
    files::write(&path, &text)?;
    let command = format!("raypath replay {} --engine model", path.display());
    Ok(format!("chunk {chunk}, job {job}: {what}\n           shrunk to {} jobs; to replay it: {command}", stream.len()))
}
