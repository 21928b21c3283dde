use crate::choice::choices;
use crate::features::Features;
use raypath_float::Format;
use raypath_ops::{JobKind, Rules};
use std::fmt;

/// What a datapath can do and how it is built. The default is the paper's, but with all four operations, so that who
/// asks for nothing sees everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// The rules on the edges.
    pub rules: Rules,
    /// The distance modes (Table VI, `support_euclidean`).
    pub lanes: Lanes,
    /// The numbers' format.
    pub format: Format,
    /// How numbers stand at the ports (Table VI, `io_recorded_float`).
    pub io: Encoding,
    /// How numbers stand in the registers between stages (Table VI, `internal_recorded_float`).
    pub registers: Encoding,
    /// What keeps stages from losing jobs.
    pub control: Control,
    /// Whether operations share registers.
    pub sharing: Sharing,
    /// Stages that an adder or a multiplier takes.
    pub unit_latency: UnitLatency,
    /// What the paper's operations do not have; nothing by default.
    pub features: Features,
}

choices! {
    /// How many dimensions a Euclidean beat has; an angular one has half as many.
    pub enum Lanes ("number of lanes") {
        /// The distance modes are off: their ports, registers and units are not there.
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
    /// Euclidean lanes; 0 where the distance modes are off.
    pub fn count(self) -> usize {
        match self {
            Self::None => 0,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
            Self::SixtyFour => 64,
        }
    }
}

choices! {
    /// How a number stands in a word.
    pub enum Encoding ("encoding of numbers") {
        /// As IEEE 754 has it: binary32 has 32 bits.
        Ieee = "ieee",
        /// As the units want it (`docs/reference/formats.md`): one bit more.
        Recoded = "recoded",
    }
}

choices! {
    /// What keeps stages from losing jobs while the sink is not ready.
    pub enum Control ("elastic control") {
        /// A skid buffer after every stage: two registers, and ready from a flip-flop (the paper's).
        Skid = "skid",
        /// Registers that never stall, and a FIFO at the exit with a place for every job that was let in.
        Credit = "credit",
    }
}

choices! {
    /// Whether values of different operations live in the same registers.
    pub enum Sharing ("sharing of registers") {
        /// A register holds a value of whichever operation the job belongs to.
        Union = "union",
        /// Every operation has registers of its own (the paper's).
        Segregated = "segregated",
    }
}

choices! {
    /// Stages that an adder or a multiplier takes.
    pub enum UnitLatency ("latency of units") {
        /// One: units are combinational (the paper's).
        One = "1",
        /// Two.
        Two = "2",
        /// Three.
        Three = "3",
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Config {
    /// What is built where nothing else is asked for.
    pub const DEFAULT: Self = Self {
        rules: Rules::Paper,
        lanes: Lanes::Sixteen,
        format: Format::BINARY32,
        io: Encoding::Ieee,
        registers: Encoding::Recoded,
        control: Control::Skid,
        sharing: Sharing::Union,
        unit_latency: UnitLatency::One,
        features: Features::OFF,
    };

    /// The jobs that it answers.
    pub fn kinds(self) -> &'static [JobKind] {
        if self.lanes == Lanes::None { &[JobKind::Triangle, JobKind::Quadbox] } else { &JobKind::ALL }
    }
}

impl UnitLatency {
    /// As a number.
    pub fn stages(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

/// Lanes and rules, and what else differs from the default.
impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "lanes {}, rules {}", self.lanes, self.rules)?;
        for (name, value, default) in self.others() {
            if value != default {
                write!(f, ", {} {value}", name.replace('-', " "))?;
            }
        }
        Ok(())
    }
}

impl Config {
    /// The options of the command line that ask for it, `--lanes none --control credit`; empty for the default.
    pub fn options(self) -> String {
        let default = Self::DEFAULT;
        let all = [
            ("lanes", self.lanes.to_string(), default.lanes.to_string()),
            ("rules", self.rules.to_string(), default.rules.to_string()),
        ];
        let differing = all.into_iter().chain(self.others()).filter(|(_, value, default)| value != default);
        let option = |(name, value, _): (&str, String, String)| match value.as_str() {
            "true" => format!("--{name}"),
            _ => format!("--{name} {value}"),
        };
        differing.map(option).collect::<Vec<_>>().join(" ")
    }

    /// Parameters but lanes and rules: name, value, default.
    fn others(self) -> impl Iterator<Item = (&'static str, String, String)> {
        let default = Self::DEFAULT;
        let building = [
            ("format", self.format.name(), default.format.name()),
            ("io", self.io.to_string(), default.io.to_string()),
            ("registers", self.registers.to_string(), default.registers.to_string()),
            ("control", self.control.to_string(), default.control.to_string()),
            ("sharing", self.sharing.to_string(), default.sharing.to_string()),
            ("unit-latency", self.unit_latency.to_string(), default.unit_latency.to_string()),
        ];
        let features = self.features.values().into_iter().zip(default.features.values());
        building.into_iter().chain(features.map(|((name, value), (_, default))| (name, value, default)))
    }
}
