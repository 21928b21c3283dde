/// What surrounds the datapath.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// How many agents are live at a time, at least 1. A finished one's place is taken by the next.
    pub in_flight: usize,
    /// Cycles from an agent's fetch to the first in which it can use what it has read; 0 is memory that costs nothing.
    pub memory_latency: u64,
    /// Who takes the answers.
    pub sink: Sink,
}

/// Who takes the answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sink {
    /// Takes each in the first cycle that shows it.
    Always,
    /// Refuses at random, so that stalls can be seen.
    Stalls {
        /// How probable it is that an answer is refused, in each cycle that shows one: 0 ≤ p < 1.
        probability: f64,
        /// The same seed, the same stalls.
        seed: u64,
    },
}

impl Default for Machine {
    /// 32 agents in flight, memory of 100 cycles, and a sink that always takes.
    fn default() -> Self {
        Self { in_flight: 32, memory_latency: 100, sink: Sink::Always }
    }
}
