//! Random handshakes of a source or a sink.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// The handshakes of a source or a sink. To act is to offer a job or to be ready.
#[derive(Debug, Clone)]
pub enum HandshakePattern {
    /// Acts in every cycle.
    Always,
    /// Acts in each cycle with this probability.
    Chance(f64),
    /// Alternates between acting and pausing. Each takes a random number of cycles, at most `longest[0]` to act and
    /// `longest[1]` to pause.
    Bursts { longest: [u32; 2], acting: bool, cycles_left: u32 },
    /// Acts with a probability that changes.
    Phases(ActivityPhase),
}

/// A probability of acting that is drawn again after a random number of cycles.
#[derive(Debug, Clone, Copy, Default)]
pub struct ActivityPhase {
    probability: f64,
    cycles_left: u32,
}

/// The probabilities of a phase. Phases with low probability are long enough to fill or drain the pipeline.
const PROBABILITIES: [f64; 6] = [1.0, 0.9, 0.5, 0.1, 0.01, 0.0];
const MAX_PHASE_CYCLES: u32 = 80;

impl HandshakePattern {
    /// A random pattern. Patterns that keep the datapath busy are more likely than those that make it wait.
    pub fn random(rng: &mut ChaCha8Rng) -> Self {
        let bursts = |longest| Self::Bursts { longest, acting: true, cycles_left: 0 };
        match rng.random_range(0..16) {
            0..=4 => Self::Always,
            5 => Self::Chance(0.01),
            6 | 7 => Self::Chance(0.5),
            8 => Self::Chance(0.9),
            9 | 10 => bursts([12, 12]),
            11 => bursts([40, 3]),
            12 | 13 => bursts([60, 120]),
            _ => Self::Phases(ActivityPhase::default()),
        }
    }

    /// Whether the source or sink acts in the next cycle.
    pub fn acts(&mut self, rng: &mut ChaCha8Rng) -> bool {
        match self {
            Self::Always => true,
            Self::Chance(chance) => rng.random_bool(*chance),
            Self::Phases(phase) => phase.acts(rng),
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

impl ActivityPhase {
    /// Whether the source or sink acts in the next cycle.
    pub fn acts(&mut self, rng: &mut ChaCha8Rng) -> bool {
        if self.cycles_left == 0 {
            self.probability = PROBABILITIES[rng.random_range(0..PROBABILITIES.len())];
            self.cycles_left = rng.random_range(1..=MAX_PHASE_CYCLES);
        }
        self.cycles_left -= 1;
        rng.random_bool(self.probability)
    }
}
