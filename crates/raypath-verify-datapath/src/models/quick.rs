//! The paper's operations in the default configuration, in their own types, against the quick oracle: many jobs.

use super::failure::Failure;
use super::in_order::InOrder;
use crate::coverage::{Counted, Coverage, CoverageModel, JobPath};
use crate::layout::Layout;
use crate::oracle::{Oracle, quick};
use crate::stimuli::{Stimuli, splitmix64};
use crate::subjects::Subject;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Functional, OperationId, Shape, WordModel, Words};
use raypath_ops::{Binary32, Job, JobKind, Rules};
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_tools::pool;
use raypath_verify::{Error, Request, Verdict};
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
    let datapath = DefaultDatapath::new();
    let points = CoverageModel::new(CONFIG.semantics, &Shape::default(), &datapath.model);
    let cases = request.cases(jobs.div_ceil(JOBS_PER_CHUNK), 1);
    let seed = request.seed;
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut tally = Tally::new(&points);
            queue.run(|number, stop| {
                tally.jobs += JOBS_PER_CHUNK;
                if let Some(wrong) = Chunk::new(&datapath, seed, number).run(&points, &mut tally.coverage) {
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
        let jobs = Chunk::new(&datapath, seed, wrong.stream).jobs_up_to(wrong.job);
        verdict.failures.push(wrong.report(&Subject::from(CONFIG), &datapath.model, jobs, seed, folder)?);
    }
    Ok(verdict)
}

/// The default datapath: its model, the layout of its jobs, and its operations in the order of their opcodes.
struct DefaultDatapath {
    model: WordModel,
    layout: Layout,
    kinds: Vec<OperationId>,
}

impl DefaultDatapath {
    fn new() -> Self {
        let model = Datapath::paper(CONFIG).model();
        Self { layout: Layout::of(&model), kinds: model.kinds(), model }
    }
}

/// A sequence of jobs, reproducible by seed and number. Each job combines the fields of two jobs of a pool: generating
/// every job anew would take longer than running it.
struct Chunk<'s> {
    datapath: &'s DefaultDatapath,
    number: u64,
    stimuli: Stimuli<'s>,
    /// For each operation, in the order of the opcodes.
    pool: Vec<Vec<Vec<u64>>>,
    rng: ChaCha8Rng,
    count: u64,
}

impl<'s> Chunk<'s> {
    /// The chunk with this number.
    fn new(datapath: &'s DefaultDatapath, seed: u64, number: u64) -> Self {
        let own = splitmix64(splitmix64(seed).wrapping_add(1) ^ number);
        let mut stimuli = Stimuli::new(&datapath.layout, &datapath.model, own);
        let mut job = |kind| {
            let mut words = Vec::new();
            stimuli.next_of(kind, &mut words);
            words
        };
        let pool = datapath.kinds.iter().map(|&kind| (0..POOL).map(|_| job(kind)).collect()).collect();
        Self { datapath, number, stimuli, pool, rng: ChaCha8Rng::seed_from_u64(splitmix64(own)), count: 0 }
    }

    /// Runs the chunk up to the first wrong outcome.
    fn run(mut self, points: &CoverageModel, coverage: &mut Coverage) -> Option<Failure> {
        let model = &self.datapath.model;
        let (mut oracle, mut functional) = (quick::Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        let mut exact = Oracle::new(CONFIG.semantics, model);
        let mut cycles = InOrder::new(Functional::<16, 8>::new(Rules::Paper), &Shape::default());
        let mut words = Vec::new();
        let stream = self.number;
        let failure = |job, what| Some(Failure { stream, job, what });
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
    fn jobs_up_to(mut self, last: u64) -> Vec<Words> {
        let mut words = Vec::new();
        let job = |_| {
            let (kind, _) = self.next(&mut words);
            self.datapath.model.job_of_words(kind, &words)
        };
        (0..=last).map(job).collect()
    }

    fn next(&mut self, words: &mut Vec<u64>) -> (OperationId, Job) {
        let dice: u64 = self.rng.random();
        let index = dice as usize % self.pool.len();
        let kind = self.datapath.kinds[index];
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
