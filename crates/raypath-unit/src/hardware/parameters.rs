//! The parameters of the unit's hardware.

use crate::blocks::NodeKind;
use crate::step::StepParameters;
use std::fmt;
use thiserror::Error;

/// The parameters of the unit around its datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitParameters {
    /// Rays in flight: 8 to 256.
    pub contexts: u32,
    /// The step of a ray, with the entries of its stack.
    pub step: StepParameters,
    /// Bits of a beat of the memory: 128, 256, 512 or, with wide nodes, 1024.
    pub memory_width: u32,
    /// Bits of the number that comes out with a ray's hit: 1 to 64.
    pub id_width: u32,
    /// Cycles of a division: 1 to 27.
    pub divider_latency: u32,
}

impl Default for UnitParameters {
    fn default() -> Self {
        Self { contexts: 64, step: StepParameters::default(), memory_width: 512, id_width: 16, divider_latency: 11 }
    }
}

impl fmt::Display for UnitParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contexts, step, memory_width, id_width, divider_latency } = self;
        write!(
            f,
            "{contexts} contexts, stacks of {}, memory of {memory_width} bits, ids of {id_width} bits, division in \
             {divider_latency} cycles",
            step.stack
        )?;
        if step.node == NodeKind::Quantised {
            f.write_str(", quantised nodes")?;
        }
        f.write_str(if step.features.instances { ", instances" } else { "" })
    }
}

/// The error of a parameter out of its range.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{name} is {value}, expected {expected}")]
pub struct UnitParametersError {
    /// The parameter.
    pub name: &'static str,
    /// Its value.
    pub value: u32,
    /// The values that it may have.
    pub expected: &'static str,
}

impl UnitParameters {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(self) -> Result<(), UnitParametersError> {
        let Self { contexts, step, memory_width, id_width, divider_latency } = self;
        let (widths, expected_widths) = match step.node {
            NodeKind::Wide4 => (&[128, 256, 512, 1024][..], "128, 256, 512 or 1024"),
            NodeKind::Quantised => {
                (&[128, 256, 512][..], "128, 256 or 512 with quantised nodes, whose blocks have 512")
            }
        };
        let bytes = step.node.block_bytes();
        let checks = [
            ("contexts", contexts, (8..=256).contains(&contexts), "8 to 256"),
            ("stack", step.stack, [2, 4, 8, 16, 32].contains(&step.stack), "2, 4, 8, 16 or 32"),
            ("memory width", memory_width, widths.contains(&memory_width), expected_widths),
            ("id width", id_width, (1..=64).contains(&id_width), "1 to 64"),
            ("divider latency", divider_latency, (1..=27).contains(&divider_latency), "1 to 27"),
            ("size of a block in bytes", bytes, bytes == 128 || !step.features.instances, "128, which instances need"),
        ];
        match checks.into_iter().find(|(_, _, is_valid, _)| !is_valid) {
            None => Ok(()),
            Some((name, value, _, expected)) => Err(UnitParametersError { name, value, expected }),
        }
    }
}
