//! What can be counted in a netlist without synthesis, from which area and slowest path are predicted.

use crate::design::is_unit;
use crate::{Design, Error};
use raypath_hdl::{Driver, Module, RegisterInfo, Technology, longest_path};
use raypath_tools::digest;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The counts of a design. Floating-point units are counted by their modules and not looked into, except for the path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Structure {
    /// The number of units by the digest of their text.
    pub units: BTreeMap<String, u64>,
    /// Bits of registers.
    pub register_bits: u64,
    /// Those of them behind clock gates.
    pub gated_bits: u64,
    /// Multiplexers of two words, in bits; those that hold the value of a register are among them.
    pub mux_bits: u64,
    /// All other logic, in gates of two inputs.
    pub gates: f64,
    /// The longest path in gates, with those that a large load needs.
    pub depth: f64,
}

impl Structure {
    /// Counts a design.
    ///
    /// # Errors
    /// Signals that depend on themselves; names that cannot be printed.
    pub fn of(design: &Design) -> Result<Self, Error> {
        let mut structure = Self {
            depth: longest_path(design.netlist(), |driver, operands, width, load| {
                Technology::Gates.delay(driver, operands, width, load)
            })?,
            ..Self::default()
        };
        structure.add(design.netlist());
        let digests = design.blocks()?.into_iter().map(|block| (block.module, digest(block.text.as_bytes())));
        let digests: BTreeMap<String, String> = digests.collect();
        let named = std::mem::take(&mut structure.units).into_iter();
        structure.units = named.filter_map(|(module, count)| Some((digests.get(&module)?.clone(), count))).collect();
        Ok(structure)
    }

    fn add(&mut self, module: &Module) {
        for signal in module.signals() {
            let words = match &signal.driver {
                Driver::Mux { .. } => 1,
                Driver::Case { arms, .. } => arms.len() as u64,
                _ => 0,
            };
            self.mux_bits += words * u64::from(signal.width);
            self.gates += module.gates_of(signal);
        }
        for RegisterInfo { signal, enable, gated, .. } in module.registers() {
            let bits = u64::from(module.signal(*signal).width);
            self.register_bits += bits;
            self.gated_bits += if *gated { bits } else { 0 };
            self.mux_bits += if enable.is_some() && !gated { bits } else { 0 };
        }
        for instance in module.instances() {
            match is_unit(&instance.module) {
                true => *self.units.entry(instance.module.name().to_string()).or_default() += 1,
                false => self.add(&instance.module),
            }
        }
    }
}
