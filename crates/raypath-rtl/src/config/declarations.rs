//! The parameters and the configuration that they make up.

use super::enumerations::{
    Accumulators, Control, Encoding, Interval, Lanes, Multiplier, Sharing, UnitLatency, UnitSharing,
};
use super::exceptions::EXCEPTIONS;
use super::parameter::{Parameter, ParameterGroup, declare_parameters, values};
use super::values::{DelayLines, MAX_TAG_WIDTH, TagWidth, Values};
use crate::error::Error;
use raypath_float::Format;
use raypath_ops::{BoxBits, Culling, EdgeRule, JobKind, Rounding, Rules};
use std::fmt;

declare_parameters! {
    config.semantics;
    "What the datapath computes";

    /// What a datapath of the paper's operations computes: its operations and the values of its results.
    pub struct Semantics {
        /// Lanes of a Euclidean beat; an angular beat has half as many. `none`: no distance operations.
        lanes ("lanes"): Lanes = Lanes::Sixteen,
        /// The rules for edge cases: `paper` (this project's rulings), `chisel` (those of the original hardware) or
        /// `bounds` (`paper`, with boxes in fewer bits, rounded outwards).
        rules ("rules"): Rules = Rules::Paper,
        /// Bits of the significands in box tests, hidden bit included; needs the rules `bounds`.
        box_bits ("box-bits"): BoxBits = BoxBits::DEFAULT,
        /// The number format; `eXsY` has X exponent bits (3 to 11) and Y significand bits, hidden bit included (3 to
        /// 24, and at most 2^(X-2) + 3).
        format ("format"): Format = Format::BINARY32,
        /// How sums of several products are rounded: at every adder (the paper's), or once, which shortens the
        /// pipeline.
        rounding ("rounding"): Rounding = Rounding::Unit,
    }
    /// Functions that the paper's operations do not have; off by default.
    pub features: Features = Features::OFF,
}

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
        /// Whether operations share the units of a stage and the multiplexers of their operands.
        units ("units"): UnitSharing = UnitSharing::Shared,
        /// Cycles from a job to the next: with k, each stage computes its values in k rounds on about 1/k of the units.
        interval ("interval"): Interval = Interval::One,
        /// Pipeline steps of adders and of multipliers: `10/7`, or one number for both.
        unit_latency ("unit-latency"): UnitLatency = UnitLatency::ONE,
        /// Steps from which on a value that waits is in a memory; 0: always in registers.
        delay_lines ("delay-lines"): u32 as DelayLines = 0,
        /// Clock gates, so that registers get a clock edge only when they load a value that the job uses.
        clock_gating ("clock-gating"): bool = false,
        /// How a multiplier multiplies significands: in gates (Booth), or for the DSP blocks of an FPGA with `*`, or
        /// with modules that have the registers of these blocks.
        multiplier ("multiplier"): Multiplier = Multiplier::Booth,
    }
}

declare_parameters! {
    config.semantics.features;
    "Features that the paper's operations do not have";

    /// Functions that the paper's operations do not have (`docs/reference/features.md`). A feature that is off has no
    /// hardware.
    pub struct Features {
        /// Bits of a word that every job carries from the port `tag_i` to the port `tag_o`; 0: no such ports.
        tag ("tag"): u32 as TagWidth = 0,
        /// Output ports for a triangle's U, V and W.
        barycentrics ("barycentrics"): bool = false,
        /// To which triangles the points of an edge belong: all that share it, or one; needs the rules `paper` or
        /// `bounds`.
        edges ("edges"): EdgeRule = EdgeRule::Shared,
        /// The faces of triangles that are not hit.
        culling ("culling"): Culling = Culling::Back,
        /// An output port for the face of the triangle that the ray meets.
        facing ("facing"): bool = false,
        /// Triangles are hit only between the input port `t_min` and the ray's extent.
        range ("range"): bool = false,
        /// Rounding makes no box a miss that a ray touches, or that is around a triangle that it hits.
        conservative ("conservative"): bool = false,
        /// Boxes with bounds of 8 bits (the operation `quantised_box`) in place of boxes of numbers; needs the rules
        /// `paper`.
        quantised_boxes ("quantised-boxes"): bool = false,
        /// Accumulators of each distance operation; an input port selects one, so that vectors can be interleaved.
        accumulators ("accumulators"): Accumulators = Accumulators::One,
        /// An output port for the floating-point exceptions of a job's additions and multiplications.
        exception_flags ("exception-flags"): bool = false,
    }
}

/// All parameters, by group.
pub const PARAMETER_GROUPS: [ParameterGroup; 3] =
    [Semantics::PARAMETERS, Microarchitecture::PARAMETERS, Features::PARAMETERS];

/// All parameters, in the order in which they are shown.
pub fn parameters() -> impl Iterator<Item = &'static Parameter> {
    PARAMETER_GROUPS.iter().flat_map(|group| group.parameters)
}

/// A configuration of the paper's operations. The default has all four of them.
///
/// Each parameter has a method of its name that returns a changed copy:
///
/// ```
/// use raypath_rtl::{Config, Control, Lanes};
///
/// let config = Config::DEFAULT.lanes(Lanes::Four).control(Control::Credit);
/// assert_eq!(config.options(), "--lanes 4 --control credit");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Config {
    /// What the datapath computes.
    pub semantics: Semantics,
    /// How the datapath is built.
    pub microarchitecture: Microarchitecture,
}

impl Config {
    /// Every parameter at its default.
    pub const DEFAULT: Self = Self { semantics: Semantics::DEFAULT, microarchitecture: Microarchitecture::DEFAULT };

    /// This configuration with these features.
    pub const fn features(mut self, features: Features) -> Self {
        self.semantics.features = features;
        self
    }

    /// The kinds of jobs that the datapath accepts.
    pub fn kinds(self) -> &'static [JobKind] {
        self.semantics.kinds()
    }

    /// Checks that the parameters can be combined.
    ///
    /// # Errors
    /// One of [`EXCEPTIONS`]; a tag of more than [`Features::MAX_TAG_WIDTH`] bits; bits of boxes below
    /// [`BoxBits::MIN`] or above [`BoxBits::MAX`].
    pub fn check(self) -> Result<(), Error> {
        Features::check_tag(self.semantics.features.tag)?;
        let (BoxBits(bits), least, most) = (self.semantics.box_bits, BoxBits::MIN.0, BoxBits::MAX.0);
        if !(least..=most).contains(&bits) {
            return Err(Error::Feature { feature: "box-bits", problem: format!("{bits}, expected {least} to {most}") });
        }
        EXCEPTIONS.iter().try_for_each(|exception| exception.check(&self))
    }

    /// The command-line options that select this configuration, such as `--lanes none --control credit`; empty for the
    /// default.
    pub fn options(self) -> String {
        let option = |parameter: &Parameter| match parameter.get(&self).as_str() {
            "true" => format!("--{}", parameter.name),
            value => format!("--{} {value}", parameter.name),
        };
        let changed = parameters().filter(|parameter| parameter.get(&self) != parameter.default());
        changed.map(option).collect::<Vec<_>>().join(" ")
    }
}

/// Parameters that [`Config`]'s `Display` shows even if they have their default values.
const ALWAYS_SHOWN: [&str; 2] = ["lanes", "rules"];

/// The lanes, the rules, and each other parameter that differs from its default.
impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for parameter in parameters() {
            let value = parameter.get(self);
            if ALWAYS_SHOWN.contains(&parameter.name) || value != parameter.default() {
                write!(f, "{separator}{} {value}", parameter.name.replace('-', " "))?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

impl Semantics {
    /// The paper's kinds of jobs that the datapath accepts.
    pub fn kinds(self) -> &'static [JobKind] {
        match (self.lanes, self.features.quantised_boxes) {
            (Lanes::None, false) => &[JobKind::Triangle, JobKind::Quadbox],
            (Lanes::None, true) => &[JobKind::Triangle],
            (_, false) => &JobKind::ALL,
            (_, true) => &[JobKind::Triangle, JobKind::Euclidean, JobKind::Angular],
        }
    }

    /// The rules with the parameters that belong to them: the bits of boxes.
    pub fn rules_in_full(self) -> Rules {
        match self.rules {
            Rules::Bounds(_) => Rules::Bounds(self.box_bits),
            rules => rules,
        }
    }
}

impl Features {
    /// The greatest width of a tag in bits.
    pub const MAX_TAG_WIDTH: u32 = MAX_TAG_WIDTH;

    /// No features: the paper's operations.
    pub const OFF: Self = Self::DEFAULT;

    /// Whether a feature changes what a triangle job computes.
    pub(crate) fn extend_triangles(self) -> bool {
        let is_paper = self.culling == Culling::Back && self.edges == EdgeRule::Shared;
        self.barycentrics || self.facing || self.range || !is_paper
    }

    /// Checks the width of a tag.
    pub(crate) fn check_tag(width: u32) -> Result<(), Error> {
        if width <= Self::MAX_TAG_WIDTH {
            return Ok(());
        }
        let problem = format!("{width} bits, expected 1 to {}, or 0 for none", Self::MAX_TAG_WIDTH);
        Err(Error::Feature { feature: "tag", problem })
    }
}
