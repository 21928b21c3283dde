//! When the source offers and the sink takes, and in which order jobs of different modes come.

use crate::transactions::Transaction;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_model::{Model, OnPorts};
use raypath_ops::JobKind;
use std::collections::VecDeque;

/// What source and sink do, cycle by cycle.
#[derive(Debug, Clone)]
pub struct Traffic {
    random: Option<Moods>,
}

/// Source and sink change their minds: for some cycles each is eager, hesitant, rare, or does nothing at all.
#[derive(Debug, Clone)]
struct Moods {
    rng: ChaCha8Rng,
    source: Mood,
    sink: Mood,
}

#[derive(Debug, Clone, Copy, Default)]
struct Mood {
    probability: f64,
    cycles_left: u32,
}

/// How likely source and sink are to act, by mood. Long stalls fill all places of the pipeline.
const PROBABILITIES: [f64; 6] = [1.0, 0.9, 0.5, 0.1, 0.01, 0.0];
const LONGEST_MOOD: u32 = 80;

impl Traffic {
    /// A source that always offers and a sink that always takes.
    pub fn always() -> Self {
        Self { random: None }
    }

    /// Bubbles and stalls, reproducible by `seed`.
    pub fn random(seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { random: Some(Moods { rng, source: Mood::default(), sink: Mood::default() }) }
    }

    /// Whether the source offers a job and the sink takes one, in the next cycle.
    pub fn next_cycle(&mut self) -> (bool, bool) {
        match &mut self.random {
            None => (true, true),
            Some(Moods { rng, source, sink }) => (source.acts(rng), sink.acts(rng)),
        }
    }
}

impl Mood {
    fn acts(&mut self, rng: &mut ChaCha8Rng) -> bool {
        if self.cycles_left == 0 {
            self.probability = PROBABILITIES[rng.random_range(0..PROBABILITIES.len())];
            self.cycles_left = rng.random_range(1..=LONGEST_MOOD);
        }
        self.cycles_left -= 1;
        rng.random_bool(self.probability)
    }
}

/// Mixes the modes freely while each keeps its own order, so that other jobs come between the beats of a distance.
pub fn interleave<M: Model>(stream: Vec<Transaction<M>>, seed: u64) -> Vec<Transaction<M>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let total = stream.len();
    let mut queues = JobKind::ALL.map(|_| VecDeque::new());
    for transaction in stream {
        queues[transaction.job.kind() as usize].push_back(transaction);
    }
    let mut mixed = Vec::with_capacity(total);
    let mut left = total;
    while left > 0 {
        // Weighted by what is left, so that all modes last to the end.
        let mut chosen = rng.random_range(0..left);
        for queue in &mut queues {
            if chosen < queue.len() {
                mixed.extend(queue.pop_front());
                break;
            }
            chosen -= queue.len();
        }
        left -= 1;
    }
    mixed
}
