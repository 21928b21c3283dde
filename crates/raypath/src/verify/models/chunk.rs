use crate::verify::campaign::mixed;
use crate::verify::coverage::{Atlas, Coverage, Way};
use crate::verify::layout::Layout;
use crate::verify::oracle::Oracle;
use crate::verify::stimuli::Stimuli;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_model::{CycleModel, Functional, Shape};
use raypath_ops::{Binary32, Job, JobKind, Outcome, Rules};
use raypath_rtl::Config;
use std::collections::VecDeque;

/// How many jobs a chunk has.
pub const JOBS_PER_CHUNK: u64 = 1 << 18;
/// Of so many jobs the coverage looks at one.
pub const COUNTED: u64 = 32;
/// Jobs of each kind that a chunk recombines, and after how many jobs one of them is replaced.
const POOL: usize = 512;
const REPLACED: u64 = 8;

/// Some jobs, reproducible by seed and number: each has some fields of one, some of another of a pool of jobs that are
/// worth running. Making each job anew would take longer than answering it.
pub struct Chunk<'l> {
    number: u64,
    stimuli: Stimuli<'l>,
    pool: [Vec<Vec<u64>>; JobKind::ALL.len()],
    rng: ChaCha8Rng,
    count: u64,
}

/// A job that was answered wrongly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Its chunk.
    pub chunk: u64,
    /// Its position in there.
    pub job: u64,
    /// What differs.
    pub what: String,
}

impl<'l> Chunk<'l> {
    /// The chunk with this number.
    pub fn new(layout: &'l Layout, config: Config, seed: u64, number: u64) -> Self {
        let own = mixed(mixed(seed).wrapping_add(1) ^ number);
        let mut stimuli = Stimuli::new(layout, config, own);
        let pool = JobKind::ALL.map(|kind| {
            let job = |_| {
                let mut words = Vec::new();
                stimuli.next_of(kind, &mut words);
                words
            };
            (0..POOL).map(job).collect()
        });
        Self { number, stimuli, pool, rng: ChaCha8Rng::seed_from_u64(mixed(own)), count: 0 }
    }

    /// Runs it up to the first wrong answer.
    pub fn run(mut self, atlas: &Atlas, coverage: &mut Coverage) -> Option<Wrong> {
        let (mut oracle, mut functional) = (Oracle::default(), Functional::<16, 8>::new(Rules::Paper));
        let mut cycles = InOrder::new();
        let mut words = Vec::new();
        let chunk = self.number;
        let wrong = |job, what| Some(Wrong { chunk, job, what });
        while self.count < JOBS_PER_CHUNK {
            let index = self.count;
            let job = self.next(&mut words);
            if index.is_multiple_of(COUNTED) {
                coverage.count(&atlas.features(job.kind(), &words), Way::STRAIGHT);
            }
            let (expected, found) = (oracle.run(&job), functional.run(&job));
            if found != expected {
                return wrong(index, format!("the functional model answers {found:?}, the oracle {expected:?}"));
            }
            if let Some(what) = cycles.next(&job, found) {
                return wrong(index, what);
            }
        }
        None
    }

    /// Its first jobs, up to one.
    pub fn jobs_up_to(mut self, last: u64) -> Vec<Job> {
        let mut words = Vec::new();
        (0..=last).map(|_| self.next(&mut words)).collect()
    }

    /// The next job, and its words.
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
        // Of the other none, few, or half of the fields.
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

/// The cycle-exact model, fed without a pause, with a sink that now and then refuses.
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

    /// Offers a job until it is accepted. Says what is wrong with the outcomes that leave meanwhile.
    fn next(&mut self, job: &Job, outcome: Outcome) -> Option<String> {
        loop {
            self.cycles += 1;
            let transfer = self.model.cycle(Some(job), self.cycles % 64 >= 8);
            if let Some(found) = transfer.output {
                let expected = self.expected.pop_front();
                if expected != Some(found) {
                    let what = format!("the cycle-exact model answers {found:?}, the functional one {expected:?}");
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
