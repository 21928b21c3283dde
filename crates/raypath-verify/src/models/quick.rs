//! The paper's operations in the default configuration, in their own types, against the quick oracle: many jobs.

use super::Failure;
use super::in_order::InOrder;
use crate::coverage::{Counted, Coverage, CoverageModel, JobPath};
use crate::files;
use crate::layout::Layout;
use crate::oracle::{Oracle, quick};
use crate::stimuli::{Stimuli, splitmix64};
use crate::{Error, Request, Verdict};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Functional, OperationId, Shape, WordModel};
use raypath_ops::{Binary32, Job, JobKind, Rules};
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_sim::transactions::{Transaction, text};
use raypath_tools::pool;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::Ordering;

/// The quick oracle's configuration.
const CONFIG: Config = Config::DEFAULT;

/// The number of jobs in a chunk.
const JOBS_PER_CHUNK: u64 = 1 << 18;
/// The coverage counts one job of this many.
const COUNTED: u64 = 32;
/// The first jobs of a chunk, which the exact oracle runs too.
const EXACT: u64 = 256;
/// The number of jobs of each operation that a chunk recombines.
const POOL: usize = 512;
/// After this many jobs, one job of the pool is replaced.
const REPLACED: u64 = 8;

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
        self.wrong = Failure::first(self.wrong, other.wrong);
        self
    }
}

/// Runs the jobs.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(8_000_000, 200_000_000, 1_000_000_000));
    let subject = Subject::new();
    let points = CoverageModel::new(CONFIG.semantics, &Shape::default(), &subject.model);
    let cases = request.cases(jobs.div_ceil(JOBS_PER_CHUNK), 1);
    let seed = request.seed;
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut tally = Tally::new(&points);
            queue.run(|number, stop| {
                tally.jobs += JOBS_PER_CHUNK;
                if let Some(wrong) = Chunk::new(&subject, seed, number).run(&points, &mut tally.coverage) {
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
    verdict.covered = format!("{jobs} jobs of {CONFIG} through quick oracle, functional and cycle-exact model");
    verdict.remarks.push(format!("{}, counted for one job in {COUNTED}", coverage.remark(&points, Counted::AtEntry)));
    if let Some(wrong) = wrong {
        verdict.failures.push(report(&subject, seed, &wrong, folder)?);
    }
    Ok(verdict)
}

/// The default datapath: its model, the layout of its jobs, and its operations in the order of their opcodes.
struct Subject {
    model: WordModel,
    layout: Layout,
    kinds: Vec<OperationId>,
}

impl Subject {
    fn new() -> Self {
        let model = Datapath::paper(CONFIG).model();
        Self { layout: Layout::of(&model), kinds: model.kinds(), model }
    }
}

/// Writes the job with the wrong outcome, and the beats of its sum, as a transaction file with the oracle's outcomes.
fn report(subject: &Subject, seed: u64, wrong: &Failure, folder: &Path) -> Result<String, Error> {
    let Failure { chunk, job, what } = wrong;
    let mut jobs = Chunk::new(subject, seed, *chunk).jobs_up_to(*job);
    let kind = jobs.last().map_or(JobKind::Triangle, Job::kind);
    jobs.retain(|job| job.kind() == kind);
    let differs = |jobs: &[Job]| {
        let (mut oracle, mut model) = (quick::Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        jobs.iter().any(|job| oracle.run(job) != model.run(job))
    };
    // Earlier jobs matter for sums: the shortest sequence that still fails is enough.
    let fewest = (0..jobs.len()).rev().find(|&first| differs(&jobs[first..])).unwrap_or(0);
    let (mut oracle, model) = (quick::Oracle::default(), &subject.model);
    let numbered = (0..).zip(&jobs[fewest..]);
    let transaction = |(seq, job): (u64, &Job)| {
        let expected = model.paper_outcome(&oracle.run(job))?;
        Some(Transaction { seq, category: 0, job: model.paper_job(job)?, expected })
    };
    let stream: Vec<Transaction> = numbered.filter_map(transaction).collect();
    let path = folder.join(format!("failure-models-{seed}-{chunk}")).join(format!("{kind}.txt"));
    let text = model.kind(kind.name()).map(|kind| text(model, kind, &stream, CONFIG)).unwrap_or_default();
    files::write(&path, &text)?;
    let command = format!("raypath replay {} --engine model", path.display());
    Ok(format!("chunk {chunk}, job {job}: {what}\n           shrunk to {} jobs; to replay it: {command}", stream.len()))
}

/// A sequence of jobs, reproducible by seed and number. Each job combines the fields of two jobs of a pool: generating
/// every job anew would take longer than running it.
struct Chunk<'s> {
    subject: &'s Subject,
    number: u64,
    stimuli: Stimuli<'s>,
    /// For each operation, in the order of the opcodes.
    pool: Vec<Vec<Vec<u64>>>,
    rng: ChaCha8Rng,
    count: u64,
}

impl<'s> Chunk<'s> {
    /// The chunk with this number.
    fn new(subject: &'s Subject, seed: u64, number: u64) -> Self {
        let own = splitmix64(splitmix64(seed).wrapping_add(1) ^ number);
        let mut stimuli = Stimuli::new(&subject.layout, &subject.model, own);
        let mut job = |kind| {
            let mut words = Vec::new();
            stimuli.next_of(kind, &mut words);
            words
        };
        let pool = subject.kinds.iter().map(|&kind| (0..POOL).map(|_| job(kind)).collect()).collect();
        Self { subject, number, stimuli, pool, rng: ChaCha8Rng::seed_from_u64(splitmix64(own)), count: 0 }
    }

    /// Runs the chunk up to the first wrong outcome.
    fn run(mut self, points: &CoverageModel, coverage: &mut Coverage) -> Option<Failure> {
        let model = &self.subject.model;
        let (mut oracle, mut functional) = (quick::Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        let mut exact = Oracle::new(CONFIG.semantics, model);
        let mut cycles = InOrder::new(Functional::<16, 8>::new(Rules::Paper), &Shape::default());
        let mut words = Vec::new();
        let chunk = self.number;
        let failure = |job, what| Some(Failure { chunk, job, what });
        while self.count < JOBS_PER_CHUNK {
            let index = self.count;
            let (kind, job) = self.next(&mut words);
            if index.is_multiple_of(COUNTED) {
                coverage.count(&points.job_points(kind, &words), JobPath::STRAIGHT);
            }
            let (expected, found) = (oracle.run(&job), functional.run(&job));
            if found != expected {
                let what = format!("the functional model's outcome is {found:?}, the quick oracle's {expected:?}");
                return failure(index, what);
            }
            if index < EXACT {
                let (quick, exact) =
                    (model.paper_outcome(&expected), exact.run(&model.job_of_words(kind, &words)).ok());
                if quick != exact {
                    let what = format!("the quick oracle's outcome is {quick:?}, the exact oracle's {exact:?}");
                    return failure(index, what);
                }
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
        (0..=last).map(|_| self.next(&mut words).1).collect()
    }

    fn next(&mut self, words: &mut Vec<u64>) -> (OperationId, Job) {
        let dice: u64 = self.rng.random();
        let index = dice as usize % self.pool.len();
        let kind = self.subject.kinds[index];
        if self.count.is_multiple_of(REPLACED) {
            let place = (dice >> 2) as usize % POOL;
            self.stimuli.next_of(kind, &mut self.pool[index][place]);
        }
        self.count += 1;
        let pool = &self.pool[index];
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
        (kind, Job::from_words_in(Binary32, JobKind::ALL[index], words))
    }
}
