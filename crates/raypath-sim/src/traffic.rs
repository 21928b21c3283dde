//! The handshakes of the source and the sink of a datapath, and the order of jobs.

mod recorded;

use crate::random::CloneableRng;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
pub use recorded::{parse_recorded, read_recorded, recorded_text};
use std::collections::{BTreeMap, VecDeque};

/// The events at the ports of the datapath in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cycle {
    /// The source offers the job at the input ports: `input_valid_i` is 1.
    pub offers: bool,
    /// The sink is ready: `output_ready_i` is 1.
    pub takes: bool,
    /// Before the cycle, the source replaces the job at the input ports by the next one, whether it was offered or not.
    pub withdraws: bool,
    /// `rst_ni` is 0, and no job is transferred.
    pub resets: bool,
}

/// A generator of the events of one cycle after another.
#[derive(Debug, Clone)]
pub struct Traffic(Pattern);

#[derive(Debug, Clone)]
enum Pattern {
    Random(Box<RandomTraffic>),
    Recorded(VecDeque<Cycle>),
}

#[derive(Debug, Clone)]
struct RandomTraffic {
    rng: CloneableRng,
    source: HandshakePattern,
    sink: HandshakePattern,
    /// The probability of a reset in a cycle.
    resets: f64,
    /// The probability that the source withdraws its job before a cycle.
    withdraws: f64,
    /// The number of cycles, after which the source always offers and the sink is always ready; `None` for no end.
    cycles_left: Option<u32>,
}

impl Cycle {
    /// The source offers and the sink is ready.
    pub const BOTH: Self = Self { offers: true, takes: true, withdraws: false, resets: false };
}

impl Traffic {
    /// A source that always offers and a sink that is always ready.
    pub fn always() -> Self {
        Self::recorded(Vec::new())
    }

    /// Random bubbles and stalls, reproducible by `seed`.
    pub fn random(seed: u64) -> Self {
        let rng = CloneableRng(ChaCha8Rng::seed_from_u64(seed));
        let [source, sink] = [(); 2].map(|()| HandshakePattern::phases(1));
        let random = RandomTraffic { rng, source, sink, resets: 0.0, withdraws: 0.0, cycles_left: None };
        Self(Pattern::Random(Box::new(random)))
    }

    /// Random handshake patterns of source and sink for this many cycles, for most seeds with resets in random cycles,
    /// and for many with withdrawn jobs. Afterwards the source always offers and the sink is always ready. Phases that
    /// fill and drain a pipeline are `stretch` times as long as those for 64 jobs, and resets as many times rarer.
    pub fn eventful(seed: u64, cycles: u32, stretch: u32) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (source, sink) = (HandshakePattern::random(&mut rng, stretch), HandshakePattern::random(&mut rng, stretch));
        let mut one_of = |chances: [f64; 4]| chances[rng.random_range(0..chances.len())];
        let (resets, withdraws) = (one_of([0.0, 0.003, 0.01, 0.03]), one_of([0.0, 0.0, 0.02, 0.2]));
        // Beats of a sum, which wait for each other, fill a deep pipeline slowly.
        let (source, sink, resets) = match rng.random_ratio(1, 8) {
            true => (HandshakePattern::Chance(0.5), HandshakePattern::bursts([60 * stretch, 600 * stretch]), 0.0),
            false => (source, sink, resets),
        };
        let (rng, resets) = (CloneableRng(rng), resets / f64::from(stretch));
        let random = RandomTraffic { rng, source, sink, resets, withdraws, cycles_left: Some(cycles) };
        Self(Pattern::Random(Box::new(random)))
    }

    /// The same traffic with a reset in each cycle with this probability. Recorded traffic stays as it is.
    pub fn with_resets(mut self, probability: f64) -> Self {
        if let Pattern::Random(random) = &mut self.0 {
            random.resets = probability;
        }
        self
    }

    /// These cycles. Afterwards the source always offers and the sink is always ready.
    pub fn recorded(cycles: Vec<Cycle>) -> Self {
        Self(Pattern::Recorded(cycles.into()))
    }

    /// The events of the next cycle.
    pub fn next_cycle(&mut self) -> Cycle {
        match &mut self.0 {
            Pattern::Random(random) => random.next_cycle(),
            Pattern::Recorded(cycles) => cycles.pop_front().unwrap_or(Cycle::BOTH),
        }
    }
}

impl RandomTraffic {
    fn next_cycle(&mut self) -> Cycle {
        match &mut self.cycles_left {
            Some(0) => return Cycle::BOTH,
            Some(left) => *left -= 1,
            None => {}
        }
        let rng = &mut self.rng.0;
        Cycle {
            offers: self.source.acts(rng),
            takes: self.sink.acts(rng),
            withdraws: self.withdraws > 0.0 && rng.random_bool(self.withdraws),
            resets: self.resets > 0.0 && rng.random_bool(self.resets),
        }
    }
}

/// Mixes the operations of a stream at random, while the jobs of each operation keep their order. Other jobs then come
/// between the beats of a distance. `opcode` identifies the operation of an item.
pub fn interleave<T>(stream: Vec<T>, opcode: impl Fn(&T) -> u64, seed: u64) -> Vec<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let total = stream.len();
    let mut queues: BTreeMap<u64, VecDeque<T>> = BTreeMap::new();
    for item in stream {
        queues.entry(opcode(&item)).or_default().push_back(item);
    }
    let mut mixed = Vec::with_capacity(total);
    for left in (1..=total).rev() {
        // Weighted by the remaining jobs, so that no operation ends early.
        let mut chosen = rng.random_range(0..left);
        for queue in queues.values_mut() {
            if chosen < queue.len() {
                mixed.extend(queue.pop_front());
                break;
            }
            chosen -= queue.len();
        }
    }
    mixed
}

/// The handshakes of a source or a sink. To act is to offer a job or to be ready.
#[derive(Debug, Clone)]
enum HandshakePattern {
    /// Acts in every cycle.
    Always,
    /// Acts in each cycle with this probability.
    Chance(f64),
    /// Alternates between acting for at most `longest[0]` cycles and pausing for at most `longest[1]`.
    Bursts { longest: [u32; 2], acting: bool, cycles_left: u32 },
    /// Acts with a probability that is drawn again after a random number of cycles, at most `longest`.
    Phases { longest: u32, probability: f64, cycles_left: u32 },
}

/// The probabilities of a phase. Phases with low probability are long enough to fill or drain the pipeline.
const PROBABILITIES: [f64; 6] = [1.0, 0.9, 0.5, 0.1, 0.01, 0.0];
const MAX_PHASE_CYCLES: u32 = 80;

impl HandshakePattern {
    /// Phases, `stretch` times as long as those for a pipeline of 64 jobs.
    fn phases(stretch: u32) -> Self {
        Self::Phases { longest: MAX_PHASE_CYCLES * stretch, probability: 0.0, cycles_left: 0 }
    }

    fn bursts(longest: [u32; 2]) -> Self {
        Self::Bursts { longest, acting: true, cycles_left: 0 }
    }

    /// A random pattern. Patterns that keep the datapath busy are more likely than those that make it wait.
    fn random(rng: &mut ChaCha8Rng, stretch: u32) -> Self {
        match rng.random_range(0..16) {
            0..=4 => Self::Always,
            5 => Self::Chance(0.01),
            6 | 7 => Self::Chance(0.5),
            8 => Self::Chance(0.9),
            9 | 10 => Self::bursts([12, 12]),
            11 => Self::bursts([40, 3]),
            12 | 13 => Self::bursts([60 * stretch, 120 * stretch]),
            _ => Self::phases(stretch),
        }
    }

    /// Whether the source or sink acts in the next cycle.
    fn acts(&mut self, rng: &mut ChaCha8Rng) -> bool {
        match self {
            Self::Always => true,
            Self::Chance(chance) => rng.random_bool(*chance),
            Self::Phases { longest, probability, cycles_left } => {
                if *cycles_left == 0 {
                    *probability = PROBABILITIES[rng.random_range(0..PROBABILITIES.len())];
                    *cycles_left = rng.random_range(1..=*longest);
                }
                *cycles_left -= 1;
                rng.random_bool(*probability)
            }
            Self::Bursts { longest, acting, cycles_left } => {
                if *cycles_left == 0 {
                    *acting = !*acting;
                    *cycles_left = rng.random_range(1..=longest[usize::from(!*acting)]);
                }
                *cycles_left -= 1;
                *acting
            }
        }
    }
}
