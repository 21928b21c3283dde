//! A unit whose modules are proved.

use crate::built;
use raypath_hdl::{Module, verilog};
use raypath_rtl::Config;
use raypath_tools::ToolError;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::search::{SearchParameters, Searches};
use raypath_traversal::{Front, NODE_LIMIT, Queries, StepParameters, UnitFeatures, UnitNetlist, UnitParameters};
use raypath_verify::Error;
use std::sync::Arc;

/// The least unit: the faults of the claims are in its text.
pub(super) const LEAST: UnitParameters = UnitParameters {
    contexts: 8,
    step: StepParameters {
        stack: 2,
        node: NodeKind::Wide4,
        front: Front::CounterClockwise,
        node_limit: NODE_LIMIT,
        features: UnitFeatures::OFF,
    },
    memory_width: 256,
    id_width: 16,
    address_width: 32,
    divider_latency: 2,
    ram_latency: 1,
    parity: false,
    search: Searches(None),
};

/// The fewest indices that a search remembers.
const FEW: SearchParameters = SearchParameters { remembered: 64, ..SearchParameters::MOST };

/// The optional parts of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// None.
    Plain,
    /// Instances and barycentric coordinates, as the others have.
    Instances,
    /// Quantised nodes.
    Quantised,
    /// Nodes with eight children.
    Eight,
    /// Queries and nested instances.
    Queries,
    /// Searches, without the others.
    Searches,
}

impl Variant {
    /// All variants. A module that several have comes first in the unit about which its claim is.
    pub const ALL: [Self; 6] =
        [Self::Plain, Self::Quantised, Self::Instances, Self::Eight, Self::Queries, Self::Searches];

    /// The parameters of a unit, with these parts.
    pub fn of(self, parameters: UnitParameters) -> UnitParameters {
        let (has_more, nested) = (!matches!(self, Self::Plain | Self::Searches), self == Self::Queries);
        let queries = if nested { Queries::Full } else { Queries::None };
        let features =
            UnitFeatures { barycentrics: has_more, instances: has_more, nested, queries, ..UnitFeatures::OFF };
        let node = match self {
            Self::Plain | Self::Instances | Self::Queries | Self::Searches => NodeKind::Wide4,
            Self::Quantised => NodeKind::Quantised,
            Self::Eight => NodeKind::Wide8,
        };
        let least = SearchParameters { neighbours: 32, candidates: 32, contexts: 2, dimensions: 64, blocks: 32, ..FEW };
        let more = SearchParameters { trees: 1, ..SearchParameters::default() };
        let searches = if parameters.contexts == LEAST.contexts { least } else { more };
        let search = Searches((self == Self::Searches).then_some(searches));
        // A memory as fast as the datapath, so that vectors wait for the list.
        let memory_width = if self == Self::Searches { 512 } else { parameters.memory_width };
        let step = StepParameters { node, features, ..parameters.step };
        UnitParameters { step, search, memory_width, ..parameters }
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
        Ok(found
            .ok_or_else(|| ToolError::unexpected("raypath_unit", format!("no module {name}"), "all of the claims"))?)
    }
}
