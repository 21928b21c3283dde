//! Where the items of a pipeline are.

/// One bit for each place of a pipeline, so that all of them move at once.
pub type Row = u128;

/// Where an item is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Place {
    /// How many clock edges lead to it in an empty pipeline: 1 behind the input, the latency at the output.
    pub stage: usize,
    /// An older item is in the same place: it is in the spare of a skid buffer, or not the first in the FIFO at the exit.
    pub waits: bool,
}

/// The place that is farthest on; there is one.
#[inline]
pub fn highest(row: Row) -> u32 {
    row.ilog2()
}
