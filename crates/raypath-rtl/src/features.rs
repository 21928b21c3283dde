use crate::choice::choices;
use crate::config::Config;
use crate::error::Error;
use raypath_float::Format;
use raypath_ops::{Culling, Rules};

/// What the paper's operations do not have (`docs/reference/features.md`). What is off leaves nothing behind in the
/// hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Features {
    /// Bits of a word that every job takes along, from the port `tag_i` to the port `tag_o`; 0 for none, at most
    /// [`Features::MOST_TAG`].
    pub tag: u32,
    /// A triangle's U, V and W at output ports.
    pub barycentrics: bool,
    /// The faces of triangles that are not hit.
    pub culling: Culling,
    /// Which face of a triangle a ray meets, at an output port.
    pub facing: bool,
    /// Triangles are hit only between `t_min`, an input port, and the ray's extent.
    pub range: bool,
    /// No box that a ray touches is missed for a rounding. Under the rules `paper` only.
    pub conservative: bool,
    /// How many vectors' distances are summed at a time, interleaved.
    pub accumulators: Accumulators,
    /// The exceptions of all of a job's additions and multiplications, at an output port.
    pub exception_flags: bool,
}

choices! {
    /// Accumulators of each distance mode, which an input port chooses from if there are several.
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
    /// As a number.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

impl Default for Features {
    fn default() -> Self {
        Self::OFF
    }
}

impl Features {
    /// The widest tag.
    pub const MOST_TAG: u32 = 32;

    /// None of them: the paper's operations.
    pub const OFF: Self = Self {
        tag: 0,
        barycentrics: false,
        culling: Culling::Back,
        facing: false,
        range: false,
        conservative: false,
        accumulators: Accumulators::One,
        exception_flags: false,
    };

    /// Whether triangles have more to do than the paper says.
    pub(crate) fn extend_triangles(self) -> bool {
        self.barycentrics || self.facing || self.range || self.culling != Culling::Back
    }

    /// Names and values, in order.
    pub(crate) fn values(self) -> [(&'static str, String); 8] {
        [
            ("tag", self.tag.to_string()),
            ("barycentrics", self.barycentrics.to_string()),
            ("culling", self.culling.to_string()),
            ("facing", self.facing.to_string()),
            ("range", self.range.to_string()),
            ("conservative", self.conservative.to_string()),
            ("accumulators", self.accumulators.to_string()),
            ("exception-flags", self.exception_flags.to_string()),
        ]
    }

    pub(crate) fn check(self, Config { rules, format, .. }: Config) -> Result<(), Error> {
        if self.tag > Self::MOST_TAG {
            let problem = format!("{} bits, expected 1 to {}, or 0 for none", self.tag, Self::MOST_TAG);
            return Err(Error::Feature { feature: "tag", problem });
        }
        if self.conservative && rules == Rules::Chisel {
            let problem = "the rules chisel miss what a ray only touches, expected the rules paper".to_string();
            return Err(Error::Feature { feature: "conservative", problem });
        }
        if self.exception_flags && format != Format::BINARY32 {
            let problem =
                format!("no model has them in format {format}, to hold hardware against; expected format fp32");
            return Err(Error::Feature { feature: "exception flags", problem });
        }
        Ok(())
    }
}

impl Config {
    /// That its features can be had.
    ///
    /// # Errors
    /// A tag of more than [`Features::MOST_TAG`] bits; conservative boxes under the rules `chisel`; exception flags in
    /// another format than binary32.
    pub fn check(self) -> Result<(), Error> {
        self.features.check(self)
    }
}
