use crate::LATENCY;

/// The properties of a pipeline that determine its timing: latency, control, and accumulator loops.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Cycles from the acceptance of a job to the cycle that shows its outcome, in an empty pipeline; clamped to 1 to
    /// 128.
    pub latency: usize,
    /// The flow control.
    pub control: Control,
    /// Cycles from a job to the next at full throughput. Above 1, the pipeline is folded: jobs are at least as many
    /// positions apart, and with skid buffers there are no accumulator loops. Clamped to 1 to 64, and the latency to at
    /// least 2 then.
    pub interval: usize,
    /// The accumulators whose loop takes more than one cycle. Step i is between registers i - 1 and i; the input's
    /// register is 0. A loop delays jobs only if 1 ≤ first < last < latency.
    pub loops: Vec<Loop>,
}

/// The flow control of a pipeline: where jobs wait while the sink is not ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Control {
    /// `latency` skid buffers. Each holds two jobs, and its ready output is a flip-flop.
    Skid,
    /// `latency - 1` registers that never stall, then a FIFO. A credit counter admits at most `latency + 1` jobs.
    Credit,
}

/// An accumulator that is read in one step and written in a later one. While a job of its operation is between the two,
/// no other job of that operation may enter the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Loop {
    /// The opcode of the accumulator's operation.
    pub opcode: u64,
    /// The step that reads the accumulator.
    pub first: usize,
    /// The step that writes the accumulator.
    pub last: usize,
}

impl Default for Shape {
    /// The shape of the paper's datapath: twelve skid buffers, and accumulators that take one cycle.
    fn default() -> Self {
        Self { latency: LATENCY, control: Control::Skid, interval: 1, loops: Vec::new() }
    }
}

impl Shape {
    /// The number of jobs that fit while the sink is not ready, if no loop delays them.
    pub fn capacity(&self) -> usize {
        match self.control {
            // A job in each interval of positions, and two at the exit.
            Control::Skid if self.is_folded() => (self.length() - 1).div_ceil(self.spacing()) + 2,
            Control::Skid => 2 * self.length(),
            // As many as a source offers until the credit of the first job returns.
            Control::Credit => (self.length() + 1).div_ceil(self.spacing()),
        }
    }

    /// The initiation interval of an operation: cycles between jobs with this opcode if the source always offers one
    /// and the sink is always ready.
    pub fn interval(&self, opcode: u64) -> usize {
        let own = self.loops().filter(|a_loop| a_loop.opcode == opcode);
        own.map(|Loop { first, last, .. }| last - first + 1).max().unwrap_or(1).max(self.spacing())
    }

    /// The latency, clamped to its bounds.
    pub(crate) fn length(&self) -> usize {
        self.latency.clamp(if self.is_folded() { 2 } else { 1 }, Occupancy::BITS as usize)
    }

    /// The interval, clamped to its bounds.
    pub(crate) fn spacing(&self) -> usize {
        self.interval.clamp(1, 64)
    }

    /// Whether jobs take several cycles in a stage.
    pub(crate) fn is_folded(&self) -> bool {
        self.interval > 1
    }

    /// The loops that delay jobs.
    pub(crate) fn loops(&self) -> impl Iterator<Item = Loop> {
        let fits = |a_loop: &Loop| 1 <= a_loop.first && a_loop.first < a_loop.last && a_loop.last < self.length();
        let is_elastic = self.control == Control::Skid && self.is_folded();
        self.loops.iter().copied().filter(move |a_loop| !is_elastic && fits(a_loop))
    }
}

/// One bit per register or skid buffer of a pipeline, so that all jobs move in one operation. Bit 0 is the input's.
pub type Occupancy = u128;

/// The position of a job in the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PipelinePosition {
    /// The number of clock edges after which a job is here in an empty pipeline: 1 after the input register, the
    /// latency at the output.
    pub stage: usize,
    /// An older job has the same stage: this one is in the second register of a skid buffer, or in the FIFO at the
    /// output but not its first.
    pub waits: bool,
}

/// The occupied position closest to the output. `occupancy` must not be 0.
#[inline]
pub fn highest(occupancy: Occupancy) -> u32 {
    occupancy.ilog2()
}
