//! The parameters of the unit by name: one table, from which options, configuration files and keywords follow.

use super::parameters::UnitParameters;
use crate::search::Searches;

/// A parameter of the unit: what users need to know of it, and how it is read and changed.
#[derive(Debug, Clone, Copy)]
pub struct UnitParameter {
    /// The key in configuration files. On the command line, `--` and this is the option of a value, and this is a value
    /// of `--unit-features` for an optional part.
    pub name: &'static str,
    /// The accepted values: the least and the greatest number with `..` between them, or all values separated by `|`.
    pub values: &'static str,
    /// What it means, without a full stop.
    pub help: &'static str,
    get: fn(&UnitParameters) -> String,
    set: fn(&mut UnitParameters, &str) -> Option<()>,
}

/// Declares the parameters: the name, the field, the accepted values and the meaning of each.
macro_rules! declare {
    ($($name:literal: $($field:ident).+, $values:literal, $help:literal;)*) => {
        impl UnitParameters {
            /// The parameters, in the order in which they are shown. The feature `barycentrics` is missing: it belongs
            /// to the configuration of the datapath.
            pub const TABLE: &[UnitParameter] = &[$(UnitParameter {
                name: $name,
                values: $values,
                help: $help,
                get: |parameters| parameters.$($field).+.to_string(),
                set: |parameters, text| text.parse().ok().map(|value| parameters.$($field).+ = value),
            }),*];
            /// The names of the parameters.
            pub const NAMES: &[&str] = &[$($name),*];
        }
    };
}

declare! {
    "contexts": contexts, "8..256", "Rays that are traced at a time; the hit of one more may wait at the port";
    "stack": step.stack, "2|4|8|16|32", "Entries of the stack of each ray";
    "node": step.node, "wide4|quantised|wide8",
        "Nodes of the scene: four boxes in binary32, four of 8 bits a bound, or eight of them";
    "memory-width": memory_width, "128|256|512|1024", "Bits of a beat of the memory; 1024 not with quantised";
    "id-width": id_width, "1..64", "Bits of the number that a ray brings and its hit returns";
    "address-width": address_width, "32..64", "Bits of an address; those above 32 are a base that each ray brings";
    "divider-latency": divider_latency, "1..27", "Cycles of a division, one of which begins in each cycle";
    "ram-latency": ram_latency, "1|2", "Cycles of a read of the memories that a step reads; 2 for output registers";
    "node-limit": step.node_limit, "0..4294967295",
        "Nodes and instances that a ray may read, 0 for any number; an input of the hardware";
    "instances": step.features.instances, "true|false", "Scenes have instances";
    "nested-instances": step.features.nested, "true|false", "Objects of instances have instances; with instances only";
    "queries": step.features.queries, "none|flags|full",
        "What ray queries need: opacity, masks and flags of instances; with full also candidates for a shader";
    "parity": parity, "true|false", "The memories that a step reads have parity, and an error ends the ray";
    "search": search, "none|k=K,m=M,...",
        "Searches beside rays: the most neighbours k and candidates m, and contexts, dimensions, blocks, remembered, turns";
    "front": step.front, "counter-clockwise|clockwise", "Order of the vertices of a front face";
}

impl UnitParameter {
    /// Whether it is an optional part of the unit, which is there (`true`) or not.
    pub fn is_feature(&self) -> bool {
        self.values == "true|false"
    }

    /// The value among these parameters, as users write it.
    pub fn get(&self, parameters: &UnitParameters) -> String {
        (self.get)(parameters)
    }

    /// Sets the parameter to a value that a user wrote, whatever the others are.
    ///
    /// # Errors
    /// A value that the parameter does not have: what was found, and what was expected.
    pub fn set(&self, parameters: &mut UnitParameters, text: &str) -> Result<(), String> {
        let mut changed = *parameters;
        match (self.set)(&mut changed, text) {
            Some(()) if self.accepts(&self.get(&changed)) => *parameters = changed,
            _ => return Err(format!("'{text}', expected {}", self.expected())),
        }
        Ok(())
    }

    fn is_search(&self) -> bool {
        self.name == "search"
    }

    /// Whether the parameter has this value.
    pub(super) fn accepts(&self, value: &str) -> bool {
        if self.is_search() {
            return value.parse::<Searches>().is_ok();
        }
        let number = |text: &str| text.parse::<u32>().ok();
        match self.values.split_once("..") {
            Some((least, greatest)) => (number(least)..=number(greatest)).contains(&number(value)),
            None => self.values.split('|').any(|accepted| accepted == value),
        }
    }

    /// The accepted values in words.
    pub(super) fn expected(&self) -> String {
        if self.is_search() {
            return Searches::expected();
        }
        let words = self.values.replace("..", " to ");
        match words.rsplit_once('|') {
            Some((others, last)) => format!("{} or {last}", others.replace('|', ", ")),
            None => words,
        }
    }
}

impl UnitParameters {
    /// Sets the parameter of this name. Returns `None` if there is none.
    ///
    /// ```
    /// use raypath_traversal::UnitParameters;
    ///
    /// let mut parameters = UnitParameters::default();
    /// assert_eq!(parameters.set("memory-width", "128"), Some(Ok(())));
    /// assert_eq!(parameters.memory_width, 128);
    /// let problem = "'5', expected 2, 4, 8, 16 or 32".to_string();
    /// assert_eq!(parameters.set("stack", "5"), Some(Err(problem)));
    /// let problem = "'true': instances is false, expected true, which nested instances need".to_string();
    /// assert_eq!(parameters.set("nested-instances", "true"), Some(Err(problem)));
    /// assert_eq!(parameters.set("lanes", "4"), None);
    /// ```
    ///
    /// # Errors
    /// A value that the parameter does not have, or not with the others: what was found, and what was expected.
    pub fn set(&mut self, name: &str, value: &str) -> Option<Result<(), String>> {
        let parameter = Self::TABLE.iter().find(|parameter| parameter.name == name)?;
        let mut changed = *self;
        let checked = parameter
            .set(&mut changed, value)
            .and_then(|()| changed.check().map_err(|problem| format!("'{value}': {problem}")));
        Some(checked.map(|()| *self = changed))
    }
}
