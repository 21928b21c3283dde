//! The options of the traversal unit.

use crate::CliError;
use clap::builder::PossibleValuesParser;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use raypath_traversal::{UnitParameter, UnitParameters, fixed_parameters};

/// The parameters of the unit around the datapath, each in its range.
#[derive(Debug)]
pub struct UnitArguments {
    parameters: UnitParameters,
    /// An option that is given, with its value.
    given: Option<String>,
}

/// The option of all optional parts.
const FEATURES: &str = "unit-features";

impl UnitArguments {
    /// The selected parameters.
    pub fn parameters(&self) -> UnitParameters {
        self.parameters
    }

    /// An error if an option is given without what selects the unit.
    pub fn expect_none(&self, selector: &str) -> Result<(), CliError> {
        let problem = |given| format!("{given} is an option of the traversal unit, expected {selector}");
        self.given.as_ref().map_or(Ok(()), |given| Err(CliError::unusable(problem(given))))
    }
}

/// Which options of the datapath a unit around it does not have, for the help text of a command with `--unit`.
pub fn not_with_unit() -> String {
    let fixed: Vec<String> = fixed_parameters().map(|parameter| format!("--{}", parameter.name)).collect();
    format!("With --unit, --lanes has no effect, and these options cannot be changed: {}.", fixed.join(", "))
}

/// The parameters that have an option of their own.
fn values() -> impl Iterator<Item = &'static UnitParameter> {
    UnitParameters::TABLE.iter().filter(|parameter| !parameter.is_feature())
}

/// The parameters that are values of the option of optional parts.
fn features() -> impl Iterator<Item = &'static UnitParameter> {
    UnitParameters::TABLE.iter().filter(|parameter| parameter.is_feature())
}

/// The option of a parameter. Its value is checked here and stored as text.
fn option(parameter: &'static UnitParameter) -> Arg {
    let check = |text: &str| parameter.set(&mut UnitParameters::default(), text).map(|()| text.to_string());
    let default = parameter.get(&UnitParameters::default());
    Arg::new(parameter.name)
        .long(parameter.name)
        .value_name(parameter.values)
        .help(format!("{} [default: {default}]", parameter.help))
        .value_parser(check)
}

impl Args for UnitArguments {
    fn augment_args(command: Command) -> Command {
        let parts: Vec<String> = features().map(|part| format!("{}: {}", part.name, part.help)).collect();
        let features = Arg::new(FEATURES)
            .long(FEATURES)
            .value_name("NAME,...")
            .help(format!("Optional parts of the unit ({})", parts.join("; ")))
            .value_delimiter(',')
            .action(ArgAction::Append)
            .value_parser(PossibleValuesParser::new(features().map(|part| part.name)));
        command.next_help_heading("Traversal unit").args(values().map(option)).arg(features)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for UnitArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut found = Self { parameters: UnitParameters::default(), given: None };
        let chosen: Vec<&String> = matches.get_many(FEATURES).into_iter().flatten().collect();
        let mut set = |parameter: &UnitParameter, value: &str, given: String| {
            found.given.get_or_insert(given);
            parameter
                .set(&mut found.parameters, value)
                .map_err(|problem| Error::raw(ErrorKind::ValueValidation, problem))
        };
        for parameter in values() {
            if let Some(value) = matches.get_one::<String>(parameter.name) {
                set(parameter, value, format!("--{} {value}", parameter.name))?;
            }
        }
        for part in features().filter(|part| chosen.iter().any(|name| *name == part.name)) {
            set(part, "true", format!("--{FEATURES} {}", part.name))?;
        }
        Ok(found)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
