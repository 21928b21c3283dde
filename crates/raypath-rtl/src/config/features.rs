use super::choice::choices;
use super::parameter::{Values, declare_parameters, values};
use crate::error::Error;
use raypath_ops::Culling;

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
        /// The faces of triangles that are not hit.
        culling ("culling"): Culling = Culling::Back,
        /// An output port for the face of the triangle that the ray meets.
        facing ("facing"): bool = false,
        /// Triangles are hit only between the input port `t_min` and the ray's extent.
        range ("range"): bool = false,
        /// No box that a ray touches is missed through rounding; needs the rules `paper`.
        conservative ("conservative"): bool = false,
        /// Accumulators of each distance operation; an input port selects one, so that vectors can be interleaved.
        accumulators ("accumulators"): Accumulators = Accumulators::One,
        /// An output port for the floating-point exceptions of a job's additions and multiplications.
        exception_flags ("exception-flags"): bool = false,
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
        match self {
            Self::One => 1,
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

impl Features {
    /// The greatest width of a tag in bits.
    pub const MAX_TAG_WIDTH: u32 = 32;

    /// No features: the paper's operations.
    pub const OFF: Self = Self::DEFAULT;

    /// Whether a feature changes what a triangle job computes.
    pub(crate) fn extend_triangles(self) -> bool {
        self.barycentrics || self.facing || self.range || self.culling != Culling::Back
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

/// The texts of a tag's width.
struct TagWidth;

impl Values<u32> for TagWidth {
    const TEXTS: &'static str = "0..32";
    fn parse(text: &str) -> Result<u32, String> {
        let max = Features::MAX_TAG_WIDTH;
        let width = text.parse().ok().filter(|&width| width <= max);
        width.ok_or_else(|| format!("'{text}', expected a whole number from 0 to {max}"))
    }
    fn write(width: u32) -> String {
        width.to_string()
    }
}
