//! Presets: named configurations, for the command line, tests, documents and reports.

use super::choice::ParseChoiceError;
use super::declarations::{Config, Features};
use super::enumerations::{Control, Encoding, Lanes, Multiplier, Sharing, UnitLatency};
use raypath_float::Format;
use raypath_ops::Rules;
use std::fmt;
use std::str::FromStr;

/// A configuration with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its purpose, in a few words.
    pub purpose: &'static str,
    /// The configuration.
    pub config: Config,
}

const PAPER: Config = Config::DEFAULT;
const GRAPHICS: Config = PAPER.lanes(Lanes::None);
const QUANTISED: Config =
    GRAPHICS.control(Control::Credit).features(Features { quantised_boxes: true, ..Features::OFF });

/// All presets; the first is the default.
pub const PRESETS: &[Preset] = &[
    preset("paper", "all four operations, 16 lanes", PAPER),
    preset("original", "the original hardware's answers, bit for bit", PAPER.rules(Rules::Chisel)),
    preset("graphics", "boxes and triangles only", GRAPHICS),
    preset("search", "the widest distance beats", PAPER.lanes(Lanes::SixtyFour)),
    preset("credit", "all four, half the pipeline registers", PAPER.control(Control::Credit)),
    preset("compact", "the smallest in binary32", GRAPHICS.control(Control::Credit)),
    preset("quantised", "triangles, and boxes of 8 bits a bound", QUANTISED),
    preset("fast", "boxes and triangles, units in 5 and 4 steps", divided(5, 4)),
    preset("fastest", "boxes and triangles, units in 7 and 6 steps", divided(7, 6)),
    preset("ecp5", "boxes and triangles for an FPGA", ECP5),
    preset("half", "boxes and triangles in binary16", GRAPHICS.format(Format::BINARY16)),
    preset("recoded", "recoded numbers at the ports as well", PAPER.io(Encoding::Recoded)),
    preset("ieee", "binary32 in the stage registers as well", PAPER.registers(Encoding::Ieee)),
    preset("segregated", "registers of its own for each operation", PAPER.sharing(Sharing::Segregated)),
];

const fn divided(sums: u32, products: u32) -> Config {
    GRAPHICS.control(Control::Credit).unit_latency(UnitLatency { sums, products })
}

/// Products in DSP blocks, units in as many steps as their carry chains need, waiting values in LUT RAM.
const ECP5: Config = divided(10, 7).multiplier(Multiplier::Dsp).delay_lines(4);

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
