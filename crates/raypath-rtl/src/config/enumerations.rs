//! The parameters with named values, except those of the operations themselves.

use super::choice::choices;
use raypath_float::Product;
use raypath_hdl::Technology;
use std::fmt;
use std::str::FromStr;

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
    /// Whether operations share units.
    pub enum UnitSharing ("sharing of units") {
        /// All operations share the adders, multipliers and comparators of a stage (the paper's).
        Shared = "shared",
        /// Every operation has its own units, without multiplexers before them.
        Disjoint = "disjoint",
    }
}

choices! {
    /// The number of cycles from a job to the next one at full throughput.
    pub enum Interval ("interval between jobs") {
        /// One (the paper's).
        One = "1",
        /// Two.
        Two = "2",
        /// Four.
        Four = "4",
        /// Eight.
        Eight = "8",
    }
}

impl Interval {
    /// The number of cycles.
    pub fn cycles(self) -> u32 {
        [1, 2, 4, 8][self as usize]
    }
}

/// The numbers of pipeline steps of adders and of multipliers. As a text, `10/7`, or one number for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct UnitLatency {
    /// Steps of an adder, 1 to 10.
    pub sums: u32,
    /// Steps of a multiplier, 1 to 8.
    pub products: u32,
}

impl UnitLatency {
    /// Units are combinational (the paper's).
    pub const ONE: Self = Self { sums: 1, products: 1 };
    /// Two steps each.
    pub const TWO: Self = Self { sums: 2, products: 2 };
    /// Three steps each.
    pub const THREE: Self = Self { sums: 3, products: 3 };
    /// The most steps.
    pub const MAX: Self = Self { sums: 10, products: 8 };
    /// Values that tests try.
    pub const REPRESENTATIVES: [Self; 3] = [Self::ONE, Self::TWO, Self { sums: 5, products: 3 }];

    /// Whether a unit has several steps.
    pub fn is_divided(self) -> bool {
        self != Self::ONE
    }
}

impl FromStr for UnitLatency {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (sums, products) = text.split_once('/').unwrap_or((text, text));
        let number = |text: &str, most: u32| text.parse().ok().filter(|steps| (1..=most).contains(steps));
        match (number(sums, Self::MAX.sums), number(products, Self::MAX.products)) {
            (Some(sums), Some(products)) => Ok(Self { sums, products }),
            _ => Err(format!(
                "'{text}', expected the steps of adders and multipliers, 1/1 to {}, or one number for both",
                Self::MAX
            )),
        }
    }
}

impl fmt::Display for UnitLatency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sums, products } = self;
        if sums == products { write!(f, "{sums}") } else { write!(f, "{sums}/{products}") }
    }
}

choices! {
    /// How the text of a multiplier forms the product of significands.
    pub enum Multiplier ("multiplier") {
        /// Booth digits, rows and full adders: gates, the same in every synthesis.
        Booth = "booth",
        /// The operator `*`, for which synthesis for an FPGA takes DSP blocks.
        Inferred = "inferred",
        /// Modules of 18 by 18 bits with registers at their inputs and output, in place of which a design can have the
        /// DSP blocks of its FPGA.
        Dsp = "dsp",
    }
}

impl Multiplier {
    /// How a multiplier forms the product of significands.
    pub fn product(self) -> Product {
        match self {
            Self::Booth => Product::Booth,
            Self::Inferred => Product::Inferred,
            Self::Dsp => Product::Dsp,
        }
    }

    /// What the steps of units are divided for.
    pub fn technology(self) -> Technology {
        match self {
            Self::Booth => Technology::Gates,
            Self::Inferred | Self::Dsp => Technology::Luts,
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
