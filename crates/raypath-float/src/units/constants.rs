//! Named constants of a format, which the modules declare.

use crate::Format;
use raypath_hdl::{Builder, Formula, Wire};

/// The class that the top three bits of a recoded exponent encode.
#[derive(Clone, Copy)]
pub(crate) enum Class {
    Zero,
    Infinity,
    Nan,
}

impl Class {
    /// The class as a named constant of three bits.
    pub fn wire(self, m: &Builder) -> Wire<'_> {
        match self {
            Self::Zero => m.parameter("ClassZero", 3, 0b000),
            Self::Infinity => m.parameter("ClassInfinity", 3, 0b110),
            Self::Nan => m.parameter("ClassNan", 3, 0b111),
        }
    }
}

/// Constants of a format as formulas of its widths.
#[derive(Clone, Copy)]
pub(crate) struct Constants(pub Format);

impl Constants {
    /// Exponent bits in IEEE 754's layout.
    pub fn exp_bits(self) -> Formula {
        Formula::named("ExpBits", self.0.exponent().into())
    }

    /// Significand bits, hidden bit included.
    pub fn sig_bits(self) -> Formula {
        Formula::named("SigBits", self.0.significand().into())
    }

    /// The recoded exponent of the smallest normal number.
    pub fn min_normal(self) -> Formula {
        (Formula::from(1) << (self.exp_bits() - 1)) + 2
    }

    /// The recoded exponent of the largest finite numbers.
    pub fn max_finite(self) -> Formula {
        (Formula::from(3) << (self.exp_bits() - 1)) - 1
    }
}
