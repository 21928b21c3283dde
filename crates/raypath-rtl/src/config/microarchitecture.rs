use super::choice::choices;
use super::parameter::{Values, declare_parameters, values};

declare_parameters! {
    config.microarchitecture;
    "How the datapath is built";

    /// How a datapath is built: number encodings, control, registers and units. The same for any set of operations.
    pub struct Microarchitecture {
        /// Encoding of numbers at the ports.
        io ("io"): Encoding = Encoding::Ieee,
        /// Encoding of numbers in the registers between stages.
        registers ("registers"): Encoding = Encoding::Recoded,
        /// Flow control: a skid buffer after every stage, or credits and a FIFO at the exit.
        control ("control"): Control = Control::Skid,
        /// Whether operations share registers.
        sharing ("sharing"): Sharing = Sharing::Union,
        /// Pipeline steps of an adder or a multiplier.
        unit_latency ("unit-latency"): UnitLatency = UnitLatency::One,
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
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}
