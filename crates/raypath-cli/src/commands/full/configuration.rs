//! Configurations for commands that support the paper's operations only.

use crate::commands::configuration::ConfigArguments;
use crate::error::CliError;
use raypath_rtl::{Config, Features};

impl ConfigArguments {
    /// The selected configuration; an error if it has features.
    pub fn paper(&self) -> Result<Config, CliError> {
        let config = self.config()?;
        if config.semantics.features == Features::OFF {
            return Ok(config);
        }
        let problem = "features are for generate, ppa, explore, replay and wave; expected none of them here";
        Err(CliError::unusable(format!("{config}: {problem}")))
    }
}
