//! Synthesises a block of a design into cells of a library.

use crate::design::{Block, RegisterKind};
use crate::library::Library;
use crate::names::RegisterNames;
use crate::netlist::{Net, Netlist, YosysDesign};
use crate::recipe;
use crate::{Bench, Error, clock_gates};
use raypath_tools::{Key, MAX_RESULT_BYTES, ToolError, read_within, temporary_folder, write};
use serde::de::DeserializeOwned;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::AtomicBool;

impl Bench {
    /// The cache key of a block's netlist.
    pub(crate) fn netlist_key(&self, block: &Block) -> Key {
        let Self { library, yosys, .. } = self;
        let abc = recipe::abc(self.period_of(block));
        let recipe = recipe::yosys(block, library) + &abc + &recipe::constraints(library);
        let source = recipe::source(block, library);
        let fan_out = clock_gates::MAX_FAN_OUT.to_string();
        let mut parts = vec![source.as_str(), &recipe, &library.digest, &yosys.version];
        parts.extend(block.has_clock_gates.then_some(fan_out.as_str()));
        Key::new("gates", &parts)
    }

    /// The period for which the gates of a block are chosen.
    fn period_of(&self, block: &Block) -> f64 {
        match self.unit_period {
            Some(unit_period) if block.is_unit => unit_period,
            Some(unit_period) => self.period - unit_period,
            None => self.period,
        }
    }

    /// Synthesises a block. `registers` are those that it may have.
    pub(crate) fn synthesise(
        &self,
        block: &Block,
        registers: &BTreeMap<String, RegisterKind>,
        stop: &AtomicBool,
    ) -> Result<Netlist, Error> {
        let folder = temporary_folder()?;
        let folder = folder.path();
        write(&folder.join(recipe::DESIGN), &recipe::source(block, &self.library))?;
        write(&folder.join(recipe::LIBRARY), &self.library.text)?;
        write(&folder.join(recipe::SCRIPT), &recipe::yosys(block, &self.library))?;
        write(&folder.join(recipe::ABC_SCRIPT), &recipe::abc(self.period_of(block)))?;
        write(&folder.join(recipe::ABC_CONSTRAINTS), &recipe::constraints(&self.library))?;
        self.yosys.run(folder, recipe::SCRIPT, &block.module, stop)?;

        let bytes = |name: &str| read_within(&folder.join(name), MAX_RESULT_BYTES);
        let names = match block.is_unit {
            true => RegisterNames::default(),
            false => RegisterNames::new(json(&bytes(recipe::NAMES)?)?, &block.module, registers, &block.words),
        };
        let mut netlist = netlist(&bytes(recipe::NETLIST)?, &block.module, &names, &self.library)?;
        let statistics = bytes(recipe::STATISTICS).unwrap_or_default();
        self.check_netlist(block, &netlist, &String::from_utf8_lossy(&statistics))?;
        clock_gates::divide(&mut netlist, &self.library);
        Ok(netlist)
    }

    /// Checks that every cell is a library cell or a unit, that units have no registers, and that the areas add up to
    /// Yosys's total.
    fn check_netlist(&self, block: &Block, netlist: &Netlist, statistics: &str) -> Result<(), Error> {
        let mut sum = 0.0;
        for instance in &netlist.cells {
            match self.library.cell(&instance.cell) {
                Some(cell) if block.is_unit && cell.is_flip_flop => {
                    let found = format!("a flip-flop in {}", block.module);
                    return Err(ToolError::unexpected("yosys", found, "units without registers").into());
                }
                Some(cell) => sum += cell.area,
                None if instance.cell.starts_with('$') => {
                    let found = format!("{} in {} not mapped", instance.cell, block.module);
                    return Err(ToolError::unexpected("yosys", found, "a library with a cell for it").into());
                }
                None => {}
            }
        }
        match chip_area(statistics) {
            Some(area) if (area - sum).abs() <= 1e-4 * sum + 0.01 => Ok(()),
            // Yosys prints no area for a block of wires alone.
            None if sum == 0.0 => Ok(()),
            found => {
                let found = found.map_or("no area".to_string(), |area| format!("an area of {area}"));
                Err(ToolError::unexpected("yosys", format!("{found} for {}", block.module), format!("{sum}")).into())
            }
        }
    }
}

/// Parses a module of Yosys's JSON, and names its flip-flops after their registers.
pub fn netlist(text: &[u8], module: &str, names: &RegisterNames, library: &Library) -> Result<Netlist, Error> {
    let (mut netlist, net_names) = json::<YosysDesign>(text)?.take(module)?;
    let mut names_of: HashMap<Net, Vec<String>> = HashMap::new();
    for (name, net) in &net_names {
        for (position, bit) in net.bits.iter().enumerate() {
            let is_vector = net.bits.len() > 1;
            let name =
                if is_vector { format!("{name}[{}]", net.offset.saturating_add(position)) } else { name.clone() };
            names_of.entry(*bit).or_default().push(name);
        }
    }
    for instance in &mut netlist.cells {
        let Some(cell) = library.cell(&instance.cell) else { continue };
        let outputs = cell.outputs.iter().filter_map(|pin| instance.connections.get(pin)).flatten();
        let mut driven = outputs.filter_map(|net| names_of.get(net)).flatten().map(String::as_str);
        instance.name = match cell.is_flip_flop {
            true => driven.clone().find_map(|net| names.register(net)).or(driven.next()).unwrap_or("?").to_string(),
            false => String::new(),
        };
    }
    Ok(netlist)
}

/// The area in the output of Yosys's `stat`. Units, which the library does not have, are not in it.
pub fn chip_area(statistics: &str) -> Option<f64> {
    let (_, area) =
        statistics.lines().rev().find_map(|line| line.trim().strip_prefix("Chip area for ")?.split_once(": "))?;
    area.trim().parse().ok()
}

pub fn json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ToolError> {
    serde_json::from_slice(bytes).map_err(|problem| ToolError::unexpected("yosys", problem.to_string(), "its JSON"))
}

#[cfg(test)]
mod tests {
    use super::chip_area;

    /// Recorded output: a flip-flop with a reset (176), two without (96 each), a gate (24); another gate (16) in a
    /// module.
    #[test]
    fn recorded_areas() {
        for statistics in
            [include_str!("../tests/data/yosys-0.23-stat.txt"), include_str!("../tests/data/pyosys-0.70-stat.txt")]
        {
            assert_eq!(chip_area(statistics), Some(408.0));
            let top_only = statistics.split("=== unit ===").next().unwrap_or_default();
            assert_eq!(chip_area(top_only), Some(392.0));
        }
        assert_eq!(chip_area("ERROR: no such module"), None);
    }
}
