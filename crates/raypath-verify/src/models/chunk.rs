//! Chunks: the independent parts of the models' campaign.

use crate::coverage::{Coverage, CoverageModel, JobPath};
use crate::layout::Layout;
use crate::oracle::Oracle;
use crate::random::splitmix64;
use crate::stimuli::Stimuli;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{CycleModel, Functional, Shape};
use raypath_ops::{Binary32, Job, JobKind, Outcome, Rules};
use raypath_rtl::Config;
use std::collections::VecDeque;

/// The number of jobs in a chunk.
pub const JOBS_PER_CHUNK: u64 = 1 << 18;
/// The coverage counts one job of this many.
pub const COUNTED: u64 = 32;
/// The number of jobs of each operation that a chunk recombines.
const POOL: usize = 512;
/// After this many jobs, one job of the pool is replaced.
const REPLACED: u64 = 8;

/// A sequence of jobs, reproducible by seed and number. Each job combines the fields of two jobs of a pool: generating
/// every job anew would take longer than running it.
pub struct Chunk<'l> {
    number: u64,
    stimuli: Stimuli<'l>,
    pool: [Vec<Vec<u64>>; JobKind::ALL.len()],
    rng: ChaCha8Rng,
    count: u64,
}

/// A job with a wrong outcome.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The job's chunk.
    pub chunk: u64,
    /// The job's position in the chunk.
    pub job: u64,
    /// The difference.
    pub what: String,
}

impl<'l> Chunk<'l> {
    /// The chunk with this number.
    pub fn new(layout: &'l Layout, config: Config, seed: u64, number: u64) -> Self {
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
    pub fn run(mut self, points: &CoverageModel, coverage: &mut Coverage) -> Option<Failure> {
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
    pub fn jobs_up_to(mut self, last: u64) -> Vec<Job> {
        let mut words = Vec::new();
        (0..=last).map(|_| self.next(&mut words)).collect()
    }

    /// Generates the next job, and writes its words to `words`.
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
