//! The options that select a configuration.

use crate::error::CliError;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use raypath_oracle::{AnyOperationSpec, added_operation};
use raypath_rtl::{Config, PARAMETER_GROUPS, Parameter, Preset, parameters};
use raypath_sim::{Datapath, configuration};
use std::path::PathBuf;

/// A preset or a file, and the parameters that differ from it.
#[derive(Debug)]
pub struct ConfigArguments {
    base: Base,
    changes: Vec<(&'static Parameter, String)>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Configuration (a preset or a file first, then the options that differ from it)")]
struct Base {
    /// A named configuration; `raypath configs` lists them, and the first is the default
    #[arg(long, value_name = "NAME", conflicts_with = "config")]
    preset: Option<Preset>,
    /// A TOML file whose keys are `preset` and the options below
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

impl ConfigArguments {
    /// The selected configuration.
    pub fn config(&self) -> Result<Config, CliError> {
        let mut config = match (&self.base.config, self.base.preset) {
            (Some(path), _) => configuration::read(path)?,
            (None, Some(preset)) => preset.config,
            (None, None) => Config::DEFAULT,
        };
        for (parameter, value) in &self.changes {
            parameter.set(&mut config, value).map_err(CliError::unusable)?;
        }
        // Values of the file and of options may exclude each other.
        config.check().map_err(|problem| match &self.base.config {
            Some(path) => CliError::unusable(format!("{}: {problem}", path.display())),
            None => problem.into(),
        })?;
        Ok(config)
    }

    /// Whether the user selected nothing: the default.
    #[cfg(feature = "verify")]
    fn is_default(&self) -> bool {
        self.base.preset.is_none() && self.base.config.is_none() && self.changes.is_empty()
    }

    /// The selected configuration, for commands that support the paper's operations only; an error if it has features.
    #[cfg(feature = "full")]
    pub fn paper(&self) -> Result<Config, CliError> {
        let config = self.config()?;
        if config.semantics.features == raypath_rtl::Features::OFF {
            return Ok(config);
        }
        let problem = "features are for generate, ppa, explore, replay and wave; expected none of them here";
        Err(CliError::unusable(format!("{config}: {problem}")))
    }
}

/// The option of a parameter. Its value is checked here and stored as text.
fn option(parameter: &'static Parameter) -> Arg {
    let check = |text: &str| parameter.set(&mut Config::DEFAULT.clone(), text).map(|()| text.to_string());
    let option = Arg::new(parameter.name)
        .long(parameter.name)
        .value_name(parameter.values)
        .help(parameter.help())
        .value_parser(check);
    if parameter.is_switch { option.num_args(0..=1).require_equals(true).default_missing_value("true") } else { option }
}

impl Args for ConfigArguments {
    fn augment_args(command: Command) -> Command {
        PARAMETER_GROUPS.iter().fold(Base::augment_args(command), |command, group| {
            command.next_help_heading(group.heading).args(group.parameters.iter().map(option))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ConfigArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let change = |parameter: &'static Parameter| {
            let value = matches.get_one::<String>(parameter.name)?;
            Some((parameter, value.clone()))
        };
        Ok(Self { base: Base::from_arg_matches(matches)?, changes: parameters().filter_map(change).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// A configuration, and operations besides those of the paper.
#[derive(Debug, Args)]
pub struct DatapathArguments {
    /// Add an operation to those of the paper; `raypath operations` lists them
    #[arg(long = "with", value_name = "NAME,...", value_delimiter = ',', value_parser = added_operation)]
    pub specs: Vec<AnyOperationSpec>,
    #[command(flatten)]
    config: ConfigArguments,
}

impl DatapathArguments {
    /// The selected configuration.
    pub fn config(&self) -> Result<Config, CliError> {
        self.config.config()
    }

    /// Whether the user selected nothing: the default.
    #[cfg(feature = "verify")]
    pub fn is_default(&self) -> bool {
        self.specs.is_empty() && self.config.is_default()
    }

    /// The selected configuration and its datapath with the added operations.
    pub fn datapath(&self) -> Result<(Config, Datapath), CliError> {
        let config = self.config.config()?;
        let with = |datapath: Datapath, spec: &AnyOperationSpec| datapath.with_any(spec.operation());
        Ok((config, self.specs.iter().fold(Datapath::paper(config), with)))
    }

    /// The description of a configuration with the added operations.
    pub fn name(&self, config: Config) -> String {
        let names: Vec<&str> = self.specs.iter().map(AnyOperationSpec::name).collect();
        if names.is_empty() { config.to_string() } else { format!("{config}, with {}", names.join(", ")) }
    }
}
