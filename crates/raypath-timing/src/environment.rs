/// The environment of the datapath: the number of agents in flight, the memory latency and the sink.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Environment {
    /// Agents in flight at a time, at least 1. When an agent is done, the next one takes its slot.
    pub in_flight: usize,
    /// Cycles from a fetch to the first cycle in which the agent can use the data; 0 for ideal memory.
    pub memory_latency: u64,
    /// The consumer of the outcomes.
    pub sink: Sink,
}

/// The consumer at the output of the datapath.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sink {
    /// Ready in every cycle.
    Always,
    /// Not ready in random cycles, to exercise back pressure.
    Stalls {
        /// The probability that the sink is not ready, in each cycle with a valid output: 0 ≤ p < 1.
        probability: f64,
        /// The seed of the random generator. Equal seeds give equal stalls.
        seed: u64,
    },
}

impl Default for Environment {
    /// 32 agents in flight, a memory latency of 100 cycles, and a sink that is always ready.
    fn default() -> Self {
        Self { in_flight: 32, memory_latency: 100, sink: Sink::Always }
    }
}
