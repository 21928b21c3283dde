//! Random jobs, reproducible by seed.

use crate::semantics::answers::model;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath::float::Format;
use raypath::ops::{Job, JobKind, Rules};

pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Jobs of these operations.
pub fn jobs(kinds: &[JobKind], seed: u64) -> impl Iterator<Item = Job> {
    let words = raypath::sim::jobs::random(&model(Rules::Paper), Format::BINARY32, seed, kinds);
    words.map(|words| Job::from_ports(words.kind().paper().unwrap(), |name| words.port(name)))
}

pub fn mixed_jobs(count: usize, seed: u64) -> Vec<Job> {
    jobs(&JobKind::ALL, seed).take(count).collect()
}
