//! How a source or a sink behaves.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;

/// What a source or a sink does all the while.
#[derive(Debug, Clone)]
pub enum HandshakePattern {
    /// It acts in every cycle.
    Always,
    /// It acts in a cycle with this probability.
    Chance(f64),
    /// It acts for at most so many cycles, then does nothing for at most so many, and so on.
    Bursts { longest: [u32; 2], acting: bool, cycles_left: u32 },
    /// It changes its mind.
    Phases(ActivityPhase),
}

/// For some cycles it acts with one probability, then with another.
#[derive(Debug, Clone, Copy, Default)]
pub struct ActivityPhase {
    probability: f64,
    cycles_left: u32,
}

/// How likely source and sink are to act, by phase. Long stalls fill all places of the pipeline.
const PROBABILITIES: [f64; 6] = [1.0, 0.9, 0.5, 0.1, 0.01, 0.0];
const MAX_PHASE_CYCLES: u32 = 80;

impl HandshakePattern {
    /// One of them. Those that keep the datapath busy are more likely than those that let it wait.
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

    /// Whether it acts in the next cycle.
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
    /// Whether it acts in the next cycle.
    pub fn acts(&mut self, rng: &mut ChaCha8Rng) -> bool {
        if self.cycles_left == 0 {
            self.probability = PROBABILITIES[rng.random_range(0..PROBABILITIES.len())];
            self.cycles_left = rng.random_range(1..=MAX_PHASE_CYCLES);
        }
        self.cycles_left -= 1;
        rng.random_bool(self.probability)
    }
}
