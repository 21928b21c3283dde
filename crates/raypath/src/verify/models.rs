//! The functional model against the oracle, and the cycle-exact model against the functional, job by job.

mod chunk;

use crate::transactions::{Transaction, text};
use crate::verify::coverage::{Atlas, Coverage};
use crate::verify::layout::Layout;
use crate::verify::oracle::Oracle;
use crate::verify::{Error, Item, Request, Verdict, campaign, files};
use chunk::{Chunk, JOBS_PER_CHUNK, Wrong};
use raypath_model::{Functional, Shape};
use raypath_ops::{Job, Rules};
use raypath_rtl::Config;
use raypath_verify::pool::{self, Cases};
use std::path::Path;
use std::sync::atomic::Ordering;

/// The item of `raypath verify`.
pub const ITEM: Item = Item {
    name: "models",
    claim: "the functional model answers every job as Table VII and the rules `paper` say, and the cycle-exact model \
            answers the same, in order (16 lanes, binary32)",
    oracle: "the same operations written once more from the text, in binary64 arithmetic rounded once",
    subject: &[
        "crates/raypath-model/src",
        "crates/raypath-ops/src",
        "crates/raypath/src/verify/models.rs",
        "crates/raypath/src/verify/models",
        "crates/raypath/src/verify/oracle.rs",
        "crates/raypath/src/verify/stimuli",
    ],
    run: |request| verify(request, Path::new(campaign::FOLDER)),
};

/// The configuration that the oracle speaks of.
const CONFIG: Config = Config::DEFAULT;
/// Jobs by level: seconds, minutes, and those that were run once.
const EVERYDAY: u64 = 8_000_000;
const FULL: u64 = 200_000_000;
const LONG: u64 = 1_000_000_000;

/// What one worker found.
struct Tally {
    jobs: u64,
    coverage: Coverage,
    wrong: Option<Wrong>,
}

/// Runs the jobs; what fails goes to a folder in `folder`.
///
/// # Errors
/// Files that cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(EVERYDAY, FULL, LONG));
    let seed = request.seed;
    let layout = Layout::of(&Functional::<16, 8>::new(Rules::Paper));
    let atlas = Atlas::new(CONFIG, &Shape::default(), layout.clone());
    let chunks = jobs.div_ceil(JOBS_PER_CHUNK);
    let cases = Cases { total: chunks, shard: request.shard };
    let finished = pool::run(cases, request.proceed, |queue| {
        let mut tally = Tally { jobs: 0, coverage: Coverage::new(&atlas), wrong: None };
        queue.run(|number, stop| {
            tally.jobs += JOBS_PER_CHUNK;
            if let Some(wrong) = Chunk::new(&layout, CONFIG, seed, number).run(&atlas, &mut tally.coverage) {
                tally.wrong.get_or_insert(wrong);
                stop.store(true, Ordering::Relaxed);
            }
            Ok(())
        });
        Ok(tally)
    })?;
    let mut verdict = Verdict { is_stopped: finished.is_stopped, ..Verdict::default() };
    let (mut coverage, mut jobs, mut wrong) = (Coverage::new(&atlas), 0, None);
    for tally in finished.workers {
        coverage.add(&tally.coverage);
        jobs += tally.jobs;
        wrong = wrong.into_iter().chain(tally.wrong).min_by_key(|wrong: &Wrong| (wrong.chunk, wrong.job));
    }
    verdict.covered = format!("{jobs} jobs through oracle, functional model and cycle-exact model");
    verdict.remarks.push(format!("{}, looking at one job in {}", coverage.remark(&atlas, false), chunk::COUNTED));
    let is_other = (request.config.semantics.rules, request.config.semantics.format)
        != (CONFIG.semantics.rules, CONFIG.semantics.format);
    if is_other || request.config.semantics.lanes != CONFIG.semantics.lanes {
        verdict.remarks.push("the oracle is for rules paper, 16 lanes and binary32: that is what was run".to_string());
    }
    if let Some(wrong) = wrong {
        verdict.failures.push(report(&layout, seed, &wrong, folder)?);
    }
    Ok(verdict)
}

/// Writes the job that was answered wrongly, with the beats that its sum comes from, as a transaction file with what the
/// oracle answers.
fn report(layout: &Layout, seed: u64, wrong: &Wrong, folder: &Path) -> Result<String, Error> {
    let Wrong { chunk, job, what } = wrong;
    let mut jobs = Chunk::new(layout, CONFIG, seed, *chunk).jobs_up_to(*job);
    let kind = jobs.last().map_or(raypath_ops::JobKind::Triangle, Job::kind);
    jobs.retain(|job| job.kind() == kind);
    let differs = |jobs: &[Job]| {
        let (mut oracle, mut model) = (Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        jobs.iter().any(|job| oracle.run(job) != model.run(job))
    };
    // Jobs before it matter where a sum was left; the last few are enough if it fails with them.
    let fewest = (0..jobs.len()).rev().find(|&first| differs(&jobs[first..])).unwrap_or(0);
    let mut oracle = Oracle::default();
    let numbered = jobs[fewest..].iter().enumerate();
    let stream: Vec<Transaction> = numbered
        .map(|(seq, job)| Transaction { seq: seq as u64, category: 0, job: *job, expected: oracle.run(job) })
        .collect();
    let path = folder.join(format!("failure-models-{seed}-{chunk}")).join(format!("{kind}.txt"));
    files::write(&path, &text(&Functional::new(Rules::Paper), kind, &stream, CONFIG))?;
    let command = format!("raypath replay {} --engine model", path.display());
    Ok(format!("chunk {chunk}, job {job}: {what}\n           shrunk to {} jobs; to see it: {command}", stream.len()))
}
