use crate::LATENCY;
use crate::places::Row;

/// What time depends on, beside the handshakes: how long a pipeline is, what controls it, and who must wait for whom.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Cycles from the one in which a job is accepted to the one that shows its outcome, in an empty pipeline: 1 to 128.
    /// What is less counts as 1, what is more as 128.
    pub latency: usize,
    /// What keeps jobs while the sink refuses.
    pub control: Control,
    /// Sums that take longer than a cycle. Step i is between registers i - 1 and i, the input's being 0; a loop whose
    /// steps are not 1 ≤ first < last < latency holds nobody back.
    pub loops: Vec<Loop>,
}

/// What keeps jobs while the sink refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Control {
    /// A skid buffer in each of the `latency` places: two items, ready from a flip-flop.
    Skid,
    /// Registers that never stall, `latency - 1` of them, then a FIFO. `latency` + 1 jobs may be inside, counted at the
    /// entrance.
    Credit,
}

/// An accumulator between the step that reads it and the one that writes it: while a job of its operation is between
/// them, no other of that operation may follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Loop {
    /// Whose accumulator it is: the opcode of its operation.
    pub opcode: u64,
    /// The step that reads it.
    pub first: usize,
    /// The step that writes it, as it hands the job on.
    pub last: usize,
}

impl Default for Shape {
    /// The paper's: twelve skid buffers, sums in one cycle.
    fn default() -> Self {
        Self { latency: LATENCY, control: Control::Skid, loops: Vec::new() }
    }
}

impl Shape {
    /// How many jobs fit while the sink refuses, if no loop keeps them apart.
    pub fn capacity(&self) -> usize {
        match self.control {
            Control::Skid => 2 * self.places(),
            Control::Credit => self.places() + 1,
        }
    }

    /// Cycles from one job with this opcode to the next while the source offers nothing else and the sink always takes.
    pub fn interval(&self, opcode: u64) -> usize {
        let own = self.loops().filter(|a_loop| a_loop.opcode == opcode);
        own.map(|Loop { first, last, .. }| last - first + 1).max().unwrap_or(1)
    }

    /// The latency, in its bounds.
    pub(crate) fn places(&self) -> usize {
        self.latency.clamp(1, Row::BITS as usize)
    }

    /// The loops that hold somebody back.
    pub(crate) fn loops(&self) -> impl Iterator<Item = Loop> {
        let fits = |a_loop: &Loop| 1 <= a_loop.first && a_loop.first < a_loop.last && a_loop.last < self.places();
        self.loops.iter().copied().filter(fits)
    }
}
