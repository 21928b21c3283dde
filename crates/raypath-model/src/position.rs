//! The positions of a pipeline's jobs.

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
