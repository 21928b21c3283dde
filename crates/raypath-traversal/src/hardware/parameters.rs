//! The parameters of the unit's hardware.

use super::search::SearchPorts;
use crate::blocks::NodeKind;
use crate::query::Front;
use crate::search::{SEARCH_BLOCK, Searches};
use crate::step::{StepParameters, UnitFeatures};
use std::fmt;
use thiserror::Error;

/// The parameters of the unit around its datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitParameters {
    /// Rays that are traced at a time: 8 to 256. The hit of one more may wait at the port.
    pub contexts: u32,
    /// The step of a ray, with the entries of its stack.
    pub step: StepParameters,
    /// Bits of a beat of the memory: 128, 256, 512 or, but for quantised nodes, 1024.
    pub memory_width: u32,
    /// Bits of the number that comes out with a ray's hit: 1 to 64.
    pub id_width: u32,
    /// Bits of an address: 32 to 64. A ray brings those above 32 ([`RayRequest::base`](crate::RayRequest::base)).
    pub address_width: u32,
    /// Cycles of a division: 1 to 27.
    pub divider_latency: u32,
    /// Cycles of a read of the memories that a step reads: 1, or 2 with their output registers. A step has two stages
    /// of as many cycles.
    pub ram_latency: u32,
    /// The words that a step reads have a parity bit in their memories; if it is wrong, the ray ends with
    /// [`status::MEMORY`](crate::state::status::MEMORY).
    pub parity: bool,
    /// Searches, which share the datapath with rays.
    pub search: Searches,
}

impl Default for UnitParameters {
    fn default() -> Self {
        Self {
            contexts: 64,
            step: StepParameters::default(),
            memory_width: 512,
            id_width: 16,
            address_width: 32,
            divider_latency: 11,
            ram_latency: 1,
            parity: false,
            search: Searches(None),
        }
    }
}

impl fmt::Display for UnitParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            contexts,
            step,
            memory_width,
            id_width,
            address_width,
            divider_latency,
            ram_latency,
            parity,
            search,
        } = self;
        write!(
            f,
            "{contexts} contexts, stacks of {}, memory of {memory_width} bits, ids of {id_width} bits, division in \
             {divider_latency} cycles",
            step.stack
        )?;
        if *ram_latency > 1 {
            write!(f, ", memories of a step in {ram_latency} cycles")?;
        }
        if *address_width > CHILD_ADDRESS_BITS {
            write!(f, ", addresses of {address_width} bits")?;
        }
        match step.node {
            NodeKind::Wide4 => {}
            NodeKind::Quantised => f.write_str(", quantised nodes")?,
            NodeKind::Wide8 => f.write_str(", nodes with eight children")?,
        }
        f.write_str(match step.features {
            UnitFeatures { nested: true, .. } => ", nested instances",
            UnitFeatures { instances: true, .. } => ", instances",
            _ => "",
        })?;
        if step.features.has_flags() {
            write!(f, ", queries {}", step.features.queries)?;
        }
        f.write_str(if step.front == Front::Clockwise { ", clockwise fronts" } else { "" })?;
        f.write_str(if *parity { ", parity" } else { "" })?;
        search.0.map_or(Ok(()), |search| write!(f, ", {search}"))
    }
}

/// Bits of the addresses that child words have.
const CHILD_ADDRESS_BITS: u32 = 32;

/// The error of a parameter out of its range.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{} is {value}, expected {expected}", name.replace('-', " "))]
pub struct UnitParametersError {
    /// The parameter.
    pub name: &'static str,
    /// Its value.
    pub value: String,
    /// The values that it may have.
    pub expected: String,
}

impl UnitParameters {
    /// The bits of the base that each ray brings: 0 with addresses of 32 bits, which have none.
    pub fn base_bits(self) -> u32 {
        self.address_width.saturating_sub(CHILD_ADDRESS_BITS)
    }

    /// The greatest base that a ray may bring.
    pub fn greatest_base(self) -> u32 {
        u32::MAX.checked_shr(CHILD_ADDRESS_BITS - self.base_bits()).unwrap_or(0)
    }

    /// What searches need of it.
    pub(crate) fn search_ports(self) -> SearchPorts {
        let Self { memory_width, address_width, id_width, divider_latency, .. } = self;
        SearchPorts { memory_width: memory_width.min(8 * SEARCH_BLOCK), address_width, id_width, divider_latency }
    }

    /// Checks the range of each parameter, and what `quantised` nodes cannot be combined with.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(self) -> Result<(), UnitParametersError> {
        let error = |name, value, expected| Err(UnitParametersError { name, value, expected });
        for parameter in Self::TABLE {
            let value = parameter.get(&self);
            if !parameter.accepts(&value) {
                return error(parameter.name, value, parameter.expected());
            }
        }
        let Self { step: StepParameters { node, features, .. }, memory_width, .. } = self;
        let bits = 8 * node.block_bytes();
        if memory_width > bits {
            let expected = format!("128, 256 or 512 with {node} nodes, whose blocks have {bits}");
            return error("memory-width", memory_width.to_string(), expected);
        }
        if features.nested && !features.instances {
            return error("instances", "false".to_string(), "true, which nested instances need".to_string());
        }
        Ok(())
    }
}
