use super::choice::choices;
use super::features::Features;
use super::parameter::{Values, declare_parameters, values};
use crate::error::Error;
use raypath_float::Format;
use raypath_ops::{JobKind, Rules};

declare_parameters! {
    config.semantics;
    "What the datapath computes";

    /// What a datapath of the paper's operations computes: its operations and the values of its results.
    pub struct Semantics {
        /// Lanes of a Euclidean beat; an angular beat has half as many. `none`: no distance operations.
        lanes ("lanes"): Lanes = Lanes::Sixteen,
        /// The rules for edge cases: `paper` (this project's rulings) or `chisel` (those of the original hardware).
        rules ("rules"): Rules = Rules::Paper,
        /// The number format; `eXsY` has X exponent bits (3 to 11) and Y significand bits, hidden bit included (3 to
        /// 24).
        format ("format"): Format = Format::BINARY32,
    }
    /// Functions that the paper's operations do not have; off by default.
    pub features: Features = Features::OFF,
}

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

impl Semantics {
    /// The kinds of jobs that the datapath accepts.
    pub fn kinds(self) -> &'static [JobKind] {
        if self.lanes == Lanes::None { &[JobKind::Triangle, JobKind::Quadbox] } else { &JobKind::ALL }
    }

    /// Checks that the features can be combined with each other, the rules and the format.
    ///
    /// # Errors
    /// A tag of more than [`Features::MAX_TAG_WIDTH`] bits; conservative boxes under the rules `chisel`; exception
    /// flags in another format than binary32.
    pub fn check(self) -> Result<(), Error> {
        let Features { tag, conservative, exception_flags, .. } = self.features;
        Features::check_tag(tag)?;
        if conservative && self.rules == Rules::Chisel {
            let problem = "the rules chisel miss what a ray only touches, expected the rules paper".to_string();
            return Err(Error::Feature { feature: "conservative", problem });
        }
        if exception_flags && self.format != Format::BINARY32 {
            let problem =
                format!("no model has them in format {}, to hold hardware against; expected format fp32", self.format);
            return Err(Error::Feature { feature: "exception flags", problem });
        }
        Ok(())
    }
}
