//! The configurations that `ppa` and `explore` measure.

use crate::commands::Failure;
use clap::Args;
use raypath::ops::Rules;
use raypath::ppa::Design;
use raypath::rtl::{Config, Datapath, Lanes, Preset};

/// One configuration.
#[derive(Debug, Args)]
pub struct ChosenConfiguration {
    /// A configuration by name
    #[arg(long)]
    preset: Option<Preset>,
    /// Lanes of a Euclidean beat, or none [default: the preset's]
    #[arg(long, value_name = "none|2|4|8|16|32|64")]
    lanes: Option<Lanes>,
    /// The rules on the edges [default: the preset's]
    #[arg(long, value_name = "paper|chisel")]
    rules: Option<Rules>,
}

impl ChosenConfiguration {
    pub fn config(&self) -> Config {
        let preset = self.preset.map_or(Config::DEFAULT, |preset| preset.config);
        Config { lanes: self.lanes.unwrap_or(preset.lanes), rules: self.rules.unwrap_or(preset.rules), ..preset }
    }
}

/// A configuration, elaborated.
pub fn design(config: Config) -> Result<Design, Failure> {
    Ok(Design::new(config.to_string(), Datapath::new(config)?.top()))
}
