//! When the source offers and the sink takes, and in which order jobs of different modes come.

mod handshake;
mod recorded;

pub use recorded::{RecordedError, read_recorded, recorded_text};

use crate::random::CloneableRng;
use handshake::{ActivityPhase, HandshakePattern};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::{BTreeMap, VecDeque};

/// What happens around the datapath in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cycle {
    /// The source offers the job at the ports: `input_valid_i`.
    pub offers: bool,
    /// The sink takes what the output shows: `output_ready_i`.
    pub takes: bool,
    /// Before the cycle the source withdraws the job at the ports, offered or not, and shows the next.
    pub withdraws: bool,
    /// `rst_ni` is 0: source and sink go on as in the cycle before, and nothing passes.
    pub resets: bool,
}

/// What source and sink do, cycle by cycle.
#[derive(Debug, Clone)]
pub struct Traffic {
    pattern: Pattern,
}

#[derive(Debug, Clone)]
enum Pattern {
    Always,
    Phases(Phases),
    Eventful(Eventful),
    Recorded(VecDeque<Cycle>),
}

/// Source and sink change their minds: for some cycles each is eager, hesitant, rare, or does nothing at all.
#[derive(Debug, Clone)]
struct Phases {
    rng: CloneableRng,
    source: ActivityPhase,
    sink: ActivityPhase,
}

/// A handshake pattern of the source and one of the sink, with resets and withdrawn jobs; for so many cycles.
#[derive(Debug, Clone)]
struct Eventful {
    rng: CloneableRng,
    source: HandshakePattern,
    sink: HandshakePattern,
    resets: f64,
    withdraws: f64,
    cycles_left: u32,
}

impl Cycle {
    /// The source offers and the sink takes.
    pub const BOTH: Self = Self { offers: true, takes: true, withdraws: false, resets: false };
}

impl Traffic {
    /// A source that always offers and a sink that always takes.
    pub fn always() -> Self {
        Self { pattern: Pattern::Always }
    }

    /// Bubbles and stalls, reproducible by `seed`.
    pub fn random(seed: u64) -> Self {
        let rng = CloneableRng(ChaCha8Rng::seed_from_u64(seed));
        Self {
            pattern: Pattern::Phases(Phases { rng, source: ActivityPhase::default(), sink: ActivityPhase::default() }),
        }
    }

    /// Random handshake patterns of source and sink (always, seldom, bursts, long stalls, phases) for this many cycles,
    /// in most seeds with resets at any cycle, in many with withdrawn jobs; then always.
    pub fn eventful(seed: u64, cycles: u32) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (source, sink) = (HandshakePattern::random(&mut rng), HandshakePattern::random(&mut rng));
        let mut one_of = |chances: [f64; 4]| chances[rng.random_range(0..chances.len())];
        let (resets, withdraws) = (one_of([0.0, 0.003, 0.01, 0.03]), one_of([0.0, 0.0, 0.02, 0.2]));
        Self {
            pattern: Pattern::Eventful(Eventful {
                rng: CloneableRng(rng),
                source,
                sink,
                resets,
                withdraws,
                cycles_left: cycles,
            }),
        }
    }

    /// These cycles, then always.
    pub fn recorded(cycles: Vec<Cycle>) -> Self {
        Self { pattern: Pattern::Recorded(cycles.into()) }
    }

    /// What happens in the next cycle.
    pub fn next_cycle(&mut self) -> Cycle {
        match &mut self.pattern {
            Pattern::Always => Cycle::BOTH,
            Pattern::Phases(Phases { rng, source, sink }) => {
                Cycle { offers: source.acts(&mut rng.0), takes: sink.acts(&mut rng.0), ..Cycle::default() }
            }
            Pattern::Recorded(cycles) => cycles.pop_front().unwrap_or(Cycle::BOTH),
            Pattern::Eventful(Eventful { cycles_left: 0, .. }) => Cycle::BOTH,
            Pattern::Eventful(eventful) => eventful.next_cycle(),
        }
    }
}

impl Eventful {
    fn next_cycle(&mut self) -> Cycle {
        self.cycles_left -= 1;
        let rng = &mut self.rng.0;
        Cycle {
            offers: self.source.acts(rng),
            takes: self.sink.acts(rng),
            withdraws: self.withdraws > 0.0 && rng.random_bool(self.withdraws),
            resets: self.resets > 0.0 && rng.random_bool(self.resets),
        }
    }
}

/// Mixes the modes freely while each keeps its own order, so that other jobs come between the beats of a distance.
/// `opcode` tells modes apart.
pub fn interleave<T>(stream: Vec<T>, opcode: impl Fn(&T) -> u64, seed: u64) -> Vec<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let total = stream.len();
    let mut queues: BTreeMap<u64, VecDeque<T>> = BTreeMap::new();
    for item in stream {
        queues.entry(opcode(&item)).or_default().push_back(item);
    }
    let mut mixed = Vec::with_capacity(total);
    let mut left = total;
    while left > 0 {
        // Weighted by what is left, so that all modes last to the end.
        let mut chosen = rng.random_range(0..left);
        for queue in queues.values_mut() {
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
