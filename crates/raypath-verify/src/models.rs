//! The functional model against the oracle, and the cycle-exact model against the functional one, job by job.

use crate::coverage::{Coverage, CoverageModel, JobPath};
use crate::files;
use crate::layout::Layout;
use crate::oracle::Oracle;
use crate::stimuli::{Stimuli, splitmix64};
use crate::{Error, Request, Verdict};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{CycleModel, Functional, Shape};
use raypath_ops::{Binary32, Job, JobKind, Outcome, Rules};
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_sim::transactions::{Transaction, text};
use raypath_tools::pool;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::Ordering;

/// The oracle's configuration.
const CONFIG: Config = Config::DEFAULT;

/// The counts of a worker, or of all.
#[derive(Serialize, Deserialize)]
struct Tally {
    jobs: u64,
    coverage: Coverage,
    wrong: Option<Failure>,
}

impl Tally {
    fn new(points: &CoverageModel) -> Self {
        Self { jobs: 0, coverage: Coverage::new(points), wrong: None }
    }

    /// The sum of counts; the first wrong outcome.
    fn and(mut self, other: Self) -> Self {
        self.coverage.add(&other.coverage);
        self.jobs += other.jobs;
        self.wrong = self.wrong.into_iter().chain(other.wrong).min_by_key(|wrong| (wrong.chunk, wrong.job));
        self
    }
}

/// Runs the jobs. Writes a failure to a subfolder of `folder`.
///
/// # Errors
/// A file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(8_000_000, 200_000_000, 1_000_000_000));
    let seed = request.seed;
    let layout = Layout::of(&Datapath::paper(CONFIG).model());
    let points = CoverageModel::new(CONFIG, &Shape::default(), layout.clone());
    let chunks = jobs.div_ceil(JOBS_PER_CHUNK);
    let cases = request.cases(chunks, 1);
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut tally = Tally::new(&points);
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
        is_stopped = finished.is_stopped;
        Ok::<_, Error>(finished.workers.into_iter().fold(Tally::new(&points), Tally::and))
    })?;
    let Tally { jobs, coverage, wrong } = shards.into_iter().fold(Tally::new(&points), Tally::and);
    let mut verdict = Verdict { is_stopped, ..Verdict::default() };
    verdict.covered = format!("{jobs} jobs through oracle, functional model and cycle-exact model");
    verdict.remarks.push(format!("{}, counted for one job in {}", coverage.remark(&points, false), COUNTED));
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
    let kind = jobs.last().map_or(JobKind::Triangle, Job::kind);
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

/// The number of jobs in a chunk.
const JOBS_PER_CHUNK: u64 = 1 << 18;
/// The coverage counts one job of this many.
const COUNTED: u64 = 32;
/// The number of jobs of each operation that a chunk recombines.
const POOL: usize = 512;
/// After this many jobs, one job of the pool is replaced.
const REPLACED: u64 = 8;

/// A sequence of jobs, reproducible by seed and number. Each job combines the fields of two jobs of a pool: generating
/// every job anew would take longer than running it.
struct Chunk<'l> {
    number: u64,
    stimuli: Stimuli<'l>,
    pool: [Vec<Vec<u64>>; JobKind::ALL.len()],
    rng: ChaCha8Rng,
    count: u64,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Failure {
    chunk: u64,
    /// The job's position in the chunk.
    job: u64,
    what: String,
}

impl<'l> Chunk<'l> {
    /// The chunk with this number.
    fn new(layout: &'l Layout, config: Config, seed: u64, number: u64) -> Self {
        let own = splitmix64(splitmix64(seed).wrapping_add(1) ^ number);
        let mut stimuli = Stimuli::new(layout, config, own);
        let pool = JobKind::ALL.map(|kind| {
            let job = |_| {
                let mut words = Vec::new();
                stimuli.next_of(kind, &mut words);
                words
            };
            (0..POOL).map(job).collect()
        });
        Self { number, stimuli, pool, rng: ChaCha8Rng::seed_from_u64(splitmix64(own)), count: 0 }
    }

    /// Runs the chunk up to the first wrong outcome.
    fn run(mut self, points: &CoverageModel, coverage: &mut Coverage) -> Option<Failure> {
        let (mut oracle, mut functional) = (Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        let mut cycles = InOrder::new();
        let mut words = Vec::new();
        let chunk = self.number;
        let failure = |job, what| Some(Failure { chunk, job, what });
        while self.count < JOBS_PER_CHUNK {
            let index = self.count;
            let job = self.next(&mut words);
            if index.is_multiple_of(COUNTED) {
                coverage.count(&points.job_points(job.kind(), &words), JobPath::STRAIGHT);
            }
            let (expected, found) = (oracle.run(&job), functional.run(&job));
            if found != expected {
                return failure(
                    index,
                    format!("the functional model's outcome is {found:?}, the oracle's {expected:?}"),
                );
            }
            if let Some(what) = cycles.next(&job, found) {
                return failure(index, what);
            }
        }
        None
    }

    /// The chunk's jobs up to this position, inclusive.
    fn jobs_up_to(mut self, last: u64) -> Vec<Job> {
        let mut words = Vec::new();
        (0..=last).map(|_| self.next(&mut words)).collect()
    }

    fn next(&mut self, words: &mut Vec<u64>) -> Job {
        let dice: u64 = self.rng.random();
        let kind = JobKind::ALL[dice as usize % JobKind::ALL.len()];
        if self.count.is_multiple_of(REPLACED) {
            let place = (dice >> 2) as usize % POOL;
            self.stimuli.next_of(kind, &mut self.pool[kind as usize][place]);
        }
        self.count += 1;
        let pool = &self.pool[kind as usize];
        let (one, other) = (&pool[(dice >> 12) as usize % POOL], &pool[(dice >> 24) as usize % POOL]);
        // None, a few, or half of the second job's fields are taken.
        let taken = match dice >> 62 {
            0 => 0,
            1 => self.rng.random::<u64>(),
            _ => self.rng.random::<u64>() & self.rng.random::<u64>() & self.rng.random::<u64>(),
        };
        words.clear();
        let pairs = one.iter().zip(other).enumerate();
        words.extend(pairs.map(|(i, (one, other))| if taken >> (i % 64) & 1 == 1 { *other } else { *one }));
        Job::from_words_in(Binary32, kind, words)
    }
}

/// The cycle-exact model with a source without bubbles and a sink that stalls 8 cycles of 64.
struct InOrder {
    model: CycleModel,
    expected: VecDeque<Outcome>,
    cycles: u64,
}

impl InOrder {
    fn new() -> Self {
        let model = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
        Self { model, expected: VecDeque::new(), cycles: 0 }
    }

    /// Offers a job until it is accepted. Returns the first difference of the outcomes that leave meanwhile.
    fn next(&mut self, job: &Job, outcome: Outcome) -> Option<String> {
        loop {
            self.cycles += 1;
            let transfer = self.model.cycle(Some(job), self.cycles % 64 >= 8);
            if let Some(found) = transfer.output {
                let expected = self.expected.pop_front();
                if expected != Some(found) {
                    let what =
                        format!("the cycle-exact model's outcome is {found:?}, the functional model's {expected:?}");
                    return Some(what);
                }
            }
            if transfer.accepted {
                self.expected.push_back(outcome);
                return None;
            }
        }
    }
}
