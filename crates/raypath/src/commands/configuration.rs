//! The options that say which configuration is meant: shared by all commands that elaborate one.

use crate::commands::Failure;
use clap::Args;
use raypath::configuration;
use raypath::format::Format;
use raypath::ops::Rules;
use raypath::rtl::{Config, Control, Encoding, Lanes, Preset, Sharing, UnitLatency};
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
}

impl ConfigArguments {
    /// The configuration that is meant.
    pub fn config(&self) -> Result<Config, Failure> {
        let base = match (&self.config, self.preset) {
            (Some(path), _) => configuration::read(path)?,
            (None, Some(preset)) => preset.config,
            (None, None) => Config::DEFAULT,
        };
        Ok(Config {
            lanes: self.lanes.unwrap_or(base.lanes),
            rules: self.rules.unwrap_or(base.rules),
            format: self.format.unwrap_or(base.format),
            io: self.io.unwrap_or(base.io),
            registers: self.registers.unwrap_or(base.registers),
            control: self.control.unwrap_or(base.control),
            sharing: self.sharing.unwrap_or(base.sharing),
            unit_latency: self.unit_latency.unwrap_or(base.unit_latency),
        })
    }
}
