//! Configurations with names: the one table that command line, tests, documents and reports share.

use crate::choice::ParseChoiceError;
use crate::config::{Config, Control, Encoding, Lanes, Sharing, UnitLatency};
use raypath_float::Format;
use raypath_ops::Rules;
use std::fmt;
use std::str::FromStr;

/// A configuration with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// What the command line calls it.
    pub name: &'static str,
    /// Whom it is for.
    pub purpose: &'static str,
    /// What it is.
    pub config: Config,
}

const PAPER: Config = Config::DEFAULT;
const GRAPHICS: Config = Config { lanes: Lanes::None, ..PAPER };

/// All of them; the first is the default.
pub const PRESETS: &[Preset] = &[
    preset("paper", "all four operations, 16 lanes", PAPER),
    preset("original", "the original hardware's answers, bit for bit", Config { rules: Rules::Chisel, ..PAPER }),
    preset("graphics", "boxes and triangles only", GRAPHICS),
    preset("search", "the widest distance beats", Config { lanes: Lanes::SixtyFour, ..PAPER }),
    preset("credit", "all four, half the pipeline registers", Config { control: Control::Credit, ..PAPER }),
    preset("compact", "the smallest in binary32", Config { control: Control::Credit, ..GRAPHICS }),
    preset("fast", "boxes and triangles, units in two stages", Config { unit_latency: UnitLatency::Two, ..GRAPHICS }),
    preset("fastest", "boxes and triangles, units in three", Config { unit_latency: UnitLatency::Three, ..GRAPHICS }),
    preset("half", "boxes and triangles in binary16", Config { format: Format::BINARY16, ..GRAPHICS }),
    preset("recoded", "recoded numbers at the ports as well", Config { io: Encoding::Recoded, ..PAPER }),
    preset("ieee", "binary32 in the stage registers as well", Config { registers: Encoding::Ieee, ..PAPER }),
    preset("segregated", "registers of its own for each operation", Config { sharing: Sharing::Segregated, ..PAPER }),
];

const fn preset(name: &'static str, purpose: &'static str, config: Config) -> Preset {
    Preset { name, purpose, config }
}

impl FromStr for Preset {
    type Err = ParseChoiceError;
    fn from_str(name: &str) -> Result<Self, ParseChoiceError> {
        let found = PRESETS.iter().copied().find(|preset| preset.name == name);
        found.ok_or_else(|| ParseChoiceError::new(name, "preset", PRESETS))
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
