//! The options that say which configuration is meant: shared by all commands that elaborate one.

use crate::commands::Failure;
use crate::commands::numbers::whole;
use clap::Args;
use raypath::configuration;
use raypath::format::Format;
use raypath::ops::{Culling, Rules};
use raypath::rtl::{Accumulators, Config, Control, Encoding, Features, Lanes, Preset, Sharing, UnitLatency};
use std::path::PathBuf;

/// A preset or a file, and what is to differ from it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Configuration (a preset or a file first, then the options that differ from it)")]
pub struct ConfigArguments {
    /// A configuration with a name; `raypath configs` lists them, and the first is the default
    #[arg(long, value_name = "NAME", conflicts_with = "config")]
    preset: Option<Preset>,
    /// A TOML file whose keys are the options below, or preset
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Lanes of a Euclidean beat (an angular one has half as many), or none: no distance modes
    #[arg(long, value_name = "none|2|4|8|16|32|64")]
    lanes: Option<Lanes>,
    /// The rules on the edges: paper (this project's rulings) or chisel (the original hardware's)
    #[arg(long, value_name = "paper|chisel")]
    rules: Option<Rules>,
    /// The numbers' format; eXsY has X exponent bits and Y significand bits, the hidden one included
    #[arg(long, value_name = "fp32|tf32|bf16|fp16|eXsY")]
    format: Option<Format>,
    /// How numbers stand at the ports
    #[arg(long, value_name = "ieee|recoded")]
    io: Option<Encoding>,
    /// How numbers stand in the registers between stages
    #[arg(long, value_name = "ieee|recoded")]
    registers: Option<Encoding>,
    /// What keeps jobs while the sink refuses: skid buffers, or credits and a FIFO at the exit
    #[arg(long, value_name = "skid|credit")]
    control: Option<Control>,
    /// Whether operations share registers
    #[arg(long, value_name = "union|segregated")]
    sharing: Option<Sharing>,
    /// Stages that an adder or a multiplier takes
    #[arg(long, value_name = "1|2|3")]
    unit_latency: Option<UnitLatency>,
    #[command(flatten)]
    features: FeatureArguments,
}

/// What the paper's operations do not have; off where nothing is said (`docs/reference/features.md`).
#[derive(Debug, Args)]
#[command(next_help_heading = "Features that the paper's operations do not have")]
struct FeatureArguments {
    /// Bits of a word that every job takes along, from tag_i to tag_o
    #[arg(long, value_name = "0..32", value_parser = whole(0..=Features::MOST_TAG))]
    tag: Option<u32>,
    /// A triangle's U, V and W at output ports
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    barycentrics: Option<bool>,
    /// The faces of triangles that are not hit
    #[arg(long, value_name = "back|front|none")]
    culling: Option<Culling>,
    /// Which face of a triangle a ray meets, at an output port
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    facing: Option<bool>,
    /// Triangles are hit only between the input t_min and the ray's extent
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    range: Option<bool>,
    /// No box that a ray touches is missed for a rounding (rules paper)
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    conservative: Option<bool>,
    /// How many vectors' distances are summed at a time, interleaved
    #[arg(long, value_name = "1|2|4|8|16")]
    accumulators: Option<Accumulators>,
    /// What a job's additions and multiplications raised, at an output port
    #[arg(long, value_name = "true|false", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    exception_flags: Option<bool>,
}

impl ConfigArguments {
    /// The configuration that is meant, of the paper's operations as they are: for commands that know their jobs.
    pub fn paper(&self) -> Result<Config, Failure> {
        let config = self.config()?;
        if config.features == Features::OFF {
            return Ok(config);
        }
        let problem = "features are for generate, ppa, explore, replay and wave; expected none of them here";
        Err(Failure::unusable(format!("{config}: {problem}")))
    }

    /// The configuration that is meant.
    pub fn config(&self) -> Result<Config, Failure> {
        let base = match (&self.config, self.preset) {
            (Some(path), _) => configuration::read(path)?,
            (None, Some(preset)) => preset.config,
            (None, None) => Config::DEFAULT,
        };
        let config = Config {
            lanes: self.lanes.unwrap_or(base.lanes),
            rules: self.rules.unwrap_or(base.rules),
            format: self.format.unwrap_or(base.format),
            io: self.io.unwrap_or(base.io),
            registers: self.registers.unwrap_or(base.registers),
            control: self.control.unwrap_or(base.control),
            sharing: self.sharing.unwrap_or(base.sharing),
            unit_latency: self.unit_latency.unwrap_or(base.unit_latency),
            features: self.features.over(base.features),
        };
        config.check()?;
        Ok(config)
    }
}

impl FeatureArguments {
    fn over(&self, base: Features) -> Features {
        Features {
            tag: self.tag.unwrap_or(base.tag),
            barycentrics: self.barycentrics.unwrap_or(base.barycentrics),
            culling: self.culling.unwrap_or(base.culling),
            facing: self.facing.unwrap_or(base.facing),
            range: self.range.unwrap_or(base.range),
            conservative: self.conservative.unwrap_or(base.conservative),
            accumulators: self.accumulators.unwrap_or(base.accumulators),
            exception_flags: self.exception_flags.unwrap_or(base.exception_flags),
        }
    }
}
