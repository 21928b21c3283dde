//! The parameters with named values, except those of the operations themselves.

use super::choice::choices;
use raypath_float::Format;
use raypath_hdl::{Error, Module};
use std::sync::Arc;

choices! {
    /// The number of dimensions of a Euclidean beat. An angular beat has half as many.
    pub enum Lanes ("number of lanes") {
        /// No distance operations: their ports, registers and units are absent.
        None = "none",
        /// 2 Euclidean lanes, 1 angular.
        Two = "2",
        /// 4 Euclidean lanes, 2 angular.
        Four = "4",
        /// 8 Euclidean lanes, 4 angular.
        Eight = "8",
        /// 16 Euclidean lanes, 8 angular.
        Sixteen = "16",
        /// 32 Euclidean lanes, 16 angular.
        ThirtyTwo = "32",
        /// 64 Euclidean lanes, 32 angular.
        SixtyFour = "64",
    }
}

impl Lanes {
    /// The number of Euclidean lanes; 0 without distance operations.
    pub fn count(self) -> usize {
        [0, 2, 4, 8, 16, 32, 64][self as usize]
    }
}

choices! {
    /// The encoding of a number in a word.
    pub enum Encoding ("encoding of numbers") {
        /// IEEE 754: a binary32 number has 32 bits.
        Ieee = "ieee",
        /// The format of the units' ports (`docs/reference/formats.md`): one bit more.
        Recoded = "recoded",
    }
}

choices! {
    /// The flow control of the pipeline: how jobs are kept while the sink is not ready.
    pub enum Control ("elastic control") {
        /// A skid buffer after every stage: two registers, and ready from a flip-flop (the paper's).
        Skid = "skid",
        /// Registers that never stall, and a FIFO at the exit with an entry for every job in the pipeline.
        Credit = "credit",
    }
}

choices! {
    /// Whether values of different operations share registers.
    pub enum Sharing ("sharing of registers") {
        /// All operations share all registers; the opcode selects the meaning of a register.
        Union = "union",
        /// Every operation has its own registers (the paper's).
        Segregated = "segregated",
    }
}

choices! {
    /// The number of pipeline steps of an adder or a multiplier.
    pub enum UnitLatency ("latency of units") {
        /// One: units are combinational (the paper's).
        One = "1",
        /// Two.
        Two = "2",
        /// Three.
        Three = "3",
    }
}

impl UnitLatency {
    /// The number of steps.
    pub fn steps(self) -> u32 {
        [1, 2, 3][self as usize]
    }
}

choices! {
    /// How the text of a multiplier forms the product of significands.
    pub enum Multiplier ("multiplier") {
        /// Booth digits, rows and full adders: gates, the same in every synthesis.
        Booth = "booth",
        /// The operator `*`, for which synthesis for an FPGA takes DSP blocks.
        Inferred = "inferred",
    }
}

impl Multiplier {
    /// The modules of the parts of a multiplier, like [`raypath_float::mul_parts`].
    ///
    /// # Errors
    /// Another number of parts than 1, 2 or 3.
    pub fn parts(self, format: Format, parts: u32, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
        match self {
            Self::Booth => raypath_float::mul_parts(format, parts, with_flags),
            Self::Inferred => raypath_float::mul_inferred_parts(format, parts, with_flags),
        }
    }
}

choices! {
    /// The number of accumulators of each distance operation. With several, an input port selects one.
    pub enum Accumulators ("number of accumulators") {
        /// One (the paper's).
        One = "1",
        /// Two.
        Two = "2",
        /// Four.
        Four = "4",
        /// Eight.
        Eight = "8",
        /// Sixteen.
        Sixteen = "16",
    }
}

impl Accumulators {
    /// The number.
    pub fn count(self) -> usize {
        [1, 2, 4, 8, 16][self as usize]
    }
}
