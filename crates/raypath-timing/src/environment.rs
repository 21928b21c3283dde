use raypath_model::{CycleModel, Model, Shape};
use std::num::NonZeroUsize;

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

/// An evenly spaced subset of numbered items: 0, `stride`, 2 · `stride` and so on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// The distance between two selected items.
    pub stride: NonZeroUsize,
    /// The maximum number of selected items.
    pub max: usize,
}

impl Sample {
    /// All items.
    pub const ALL: Self = Self::first(usize::MAX);

    /// The first `max` items.
    pub const fn first(max: usize) -> Self {
        Self { stride: NonZeroUsize::MIN, max }
    }

    /// At most `max` of `count` items, evenly spaced over all of them; at least one.
    pub fn spread(count: usize, max: usize) -> Self {
        Self { stride: NonZeroUsize::new(count.div_ceil(max.max(1))).unwrap_or(NonZeroUsize::MIN), max: usize::MAX }
    }

    /// The numbers of the selected items among `count`.
    pub fn numbers(self, count: usize) -> impl ExactSizeIterator<Item = usize> + Clone + use<> {
        (0..count).step_by(self.stride.get()).take(self.max)
    }
}

/// A simulated system: the pipeline of a datapath and its environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct System {
    /// The environment: agents in flight, memory latency and sink.
    pub environment: Environment,
    /// The shape of the pipeline.
    pub shape: Shape,
}

impl System {
    /// An empty pipeline of this shape, with `model` for the outcomes.
    pub fn pipeline<M: Model>(&self, model: M) -> CycleModel<M> {
        CycleModel::new(model, &self.shape)
    }
}
