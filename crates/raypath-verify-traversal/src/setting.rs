//! A unit whose modules are proved.

use crate::built;
use raypath_hdl::{Module, verilog};
use raypath_rtl::Config;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::{StepParameters, UnitFeatures, UnitNetlist, UnitParameters};
use raypath_verify::Error;
use std::sync::Arc;

/// The least unit: the faults of the claims are in its text.
pub(super) const LEAST: UnitParameters = UnitParameters {
    contexts: 8,
    step: StepParameters { stack: 2, node: NodeKind::Wide4, features: UnitFeatures::OFF },
    memory_width: 256,
    id_width: 16,
    divider_latency: 2,
};

/// The optional parts of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// None.
    Plain,
    /// Instances and barycentric coordinates.
    Instances,
    /// Quantised nodes and barycentric coordinates.
    Quantised,
}

impl Variant {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::Plain, Self::Instances, Self::Quantised];

    /// The parameters of a unit, with these parts.
    pub fn of(self, parameters: UnitParameters) -> UnitParameters {
        let features = UnitFeatures { barycentrics: self != Self::Plain, instances: self == Self::Instances };
        let node = if self == Self::Quantised { NodeKind::Quantised } else { NodeKind::Wide4 };
        UnitParameters { step: StepParameters { node, features, ..parameters.step }, ..parameters }
    }
}

/// A unit whose modules are proved.
pub struct Setting {
    /// The unit.
    pub unit: UnitNetlist,
    pub(super) variant: Variant,
    pub(super) modules: Vec<Arc<Module>>,
}

impl Setting {
    /// The least unit with these parts.
    ///
    /// # Errors
    /// The unit cannot be built.
    pub fn least(variant: Variant) -> Result<Self, Error> {
        Self::new(variant, LEAST)
    }

    pub(super) fn new(variant: Variant, parameters: UnitParameters) -> Result<Self, Error> {
        let unit = built(Config::DEFAULT, variant.of(parameters))?;
        let modules = verilog::modules(&unit.top)?;
        Ok(Self { unit, variant, modules })
    }

    pub(super) fn module(&self, name: &str) -> Result<&Arc<Module>, Error> {
        let found = self.modules.iter().find(|module| module.name() == name);
        let missing = || raypath_hdl::Error::Name {
            module: "raypath_unit".to_string(),
            name: name.to_string(),
            problem: "is the name of no module in it".to_string(),
        };
        Ok(found.ok_or_else(missing)?)
    }
}
