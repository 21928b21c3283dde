//! The options of the traversal unit.

use crate::CliError;
use clap::{Args, ValueEnum};
use raypath_unit::blocks::NodeKind;
use raypath_unit::{StepParameters, UnitFeatures, UnitParameters};

/// The parameters of the unit around the datapath.
#[derive(Debug, Args)]
#[command(next_help_heading = "Traversal unit")]
pub struct UnitArguments {
    /// Rays in flight [default: 64]
    #[arg(long, value_name = "8..256", value_parser = parser(|unit, value| unit.contexts = value))]
    contexts: Option<u32>,
    /// Entries of the stack of each ray [default: 8]
    #[arg(long, value_name = "2|4|8|16|32", value_parser = parser(|unit, value| unit.step.stack = value))]
    stack: Option<u32>,
    /// Nodes of the scene: boxes in binary32, or of 8 bits a bound [default: wide4]
    #[arg(long, value_name = "wide4|quantised")]
    node: Option<NodeKind>,
    /// Bits of a beat of the memory; 1024 with wide4 only [default: 512]
    #[arg(long, value_name = "128|256|512|1024", value_parser = parser(|unit, value| unit.memory_width = value))]
    memory_width: Option<u32>,
    /// Bits of the number that a ray brings and its hit returns [default: 16]
    #[arg(long, value_name = "1..64", value_parser = parser(|unit, value| unit.id_width = value))]
    id_width: Option<u32>,
    /// Cycles of a division, one of which begins in each cycle [default: 11]
    #[arg(long, value_name = "1..27", value_parser = parser(|unit, value| unit.divider_latency = value))]
    divider_latency: Option<u32>,
    /// Optional parts of the unit
    #[arg(long, value_name = "instances", value_delimiter = ',')]
    unit_features: Vec<UnitFeature>,
}

/// An optional part of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum UnitFeature {
    /// Scenes have instances
    Instances,
}

impl UnitArguments {
    /// The selected parameters, each in its range.
    pub fn parameters(&self) -> UnitParameters {
        let Self { contexts, stack, node, memory_width, id_width, divider_latency, ref unit_features } = *self;
        let default = UnitParameters::default();
        let features = UnitFeatures { instances: unit_features.contains(&UnitFeature::Instances), ..UnitFeatures::OFF };
        let stack = stack.unwrap_or(default.step.stack);
        let step = StepParameters { stack, node: node.unwrap_or_default(), features };
        UnitParameters {
            contexts: contexts.unwrap_or(default.contexts),
            step,
            memory_width: memory_width.unwrap_or(default.memory_width),
            id_width: id_width.unwrap_or(default.id_width),
            divider_latency: divider_latency.unwrap_or(default.divider_latency),
        }
    }

    /// An error if an option is given without what selects the unit.
    pub fn expect_none(&self, selector: &str) -> Result<(), CliError> {
        let Self { contexts, stack, node, memory_width, id_width, divider_latency, unit_features } = self;
        if !unit_features.is_empty() {
            return Err(CliError::unusable(format!(
                "--unit-features is an option of the traversal unit, expected {selector}"
            )));
        }
        let given = [
            ("contexts", contexts),
            ("stack", stack),
            ("memory-width", memory_width),
            ("id-width", id_width),
            ("divider-latency", divider_latency),
        ];
        let node = node.map(|node| ("node", node.to_string()));
        let number = || given.into_iter().find_map(|(name, value)| Some((name, (*value)?.to_string())));
        match node.or_else(number) {
            None => Ok(()),
            Some((name, value)) => Err(CliError::unusable(format!(
                "--{name} {value} is an option of the traversal unit, expected {selector}"
            ))),
        }
    }
}

/// A parser, for clap, of a parameter. The unit says which values it has.
fn parser(set: fn(&mut UnitParameters, u32)) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    move |text| {
        // No parameter has the greatest value, so that other text gets the same message.
        let value = text.parse().unwrap_or(u32::MAX);
        let mut parameters = UnitParameters::default();
        set(&mut parameters, value);
        parameters.check().map(|()| value).map_err(|error| format!("expected {}", error.expected))
    }
}
