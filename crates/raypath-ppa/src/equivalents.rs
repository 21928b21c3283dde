//! The gates of units as modules of the netlist layer, for proofs that they compute what the units' text says.

use crate::gates::{Cell, Gates, ONE, ZERO};
use crate::logic::Output;
use crate::{Bench, Design, Error};
use raypath_hdl::{Builder, Module, Wire, verilog};
use raypath_tools::{Cache, ToolError};
use raypath_work::pool::Progress;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A unit and the gates that synthesis made of it.
pub struct SynthesisedUnit {
    /// The unit, before synthesis.
    pub unit: Arc<Module>,
    gates: Gates,
}

impl Bench {
    /// Each kind of unit in a design with its gates, by the recipe of [`Bench::measure`]; from the cache if it has
    /// them.
    ///
    /// # Errors
    /// Those of [`Bench::measure`]; a library with other cells than gates.
    pub fn units(
        &self,
        design: &Design,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Vec<SynthesisedUnit>, Error> {
        let (cache, plan) = (Cache::new(&self.cache), self.plan(design)?);
        let modules = verilog::modules(design.netlist())?;
        let of = |block: usize| modules.iter().find(|module| module.name() == plan.blocks[block].0.module);
        let units = (0..plan.blocks.len()).filter(|&block| plan.blocks[block].0.is_unit);
        let units: Vec<(usize, Arc<Module>)> = units.filter_map(|block| Some((block, of(block)?.clone()))).collect();
        self.each(&units, proceed, |(block, unit), stop| {
            let netlist = self.netlist(&plan, *block, &cache, stop)?;
            let gates = Gates::new(&netlist, &BTreeMap::new(), &self.library)?;
            Ok(SynthesisedUnit { unit: unit.clone(), gates })
        })
    }
}

impl SynthesisedUnit {
    /// The number of gates.
    pub fn count(&self) -> usize {
        self.gates.cells.len()
    }

    /// The gates that drive output ports.
    pub fn at_ports(&self) -> Vec<usize> {
        let outputs = self.unit.outputs().iter().filter_map(|output| self.port(&output.name));
        let nets: Vec<u32> = outputs.flatten().copied().collect();
        let drives = |cell: &Cell| cell.outputs.iter().any(|net| nets.contains(net));
        (0..self.count()).filter(|&cell| drives(&self.gates.cells[cell])).collect()
    }

    /// The gates as a module with the unit's name and ports. `inverted` is the number of a gate whose outputs are
    /// inverted, for negative controls.
    ///
    /// # Errors
    /// A flip-flop, or a port that the gates lack.
    pub fn module(&self, inverted: Option<usize>) -> Result<Arc<Module>, Error> {
        let m = Builder::new(self.unit.name());
        let missing = |name: &str| ToolError::unexpected("yosys", format!("no net {name}"), "the nets of the unit");
        let mut wires: Vec<Option<Wire<'_>>> = vec![None; self.gates.nets];
        wires[ZERO as usize] = Some(m.constant(1, 0));
        wires[ONE as usize] = Some(m.constant(1, 1));
        for port in self.unit.inputs() {
            let wire = m.input(&port.name, self.unit.signal(port.signal).width);
            for (bit, net) in (0..).zip(self.port(&port.name).ok_or_else(|| missing(&port.name))?) {
                wires[*net as usize] = Some(wire.bit(bit));
            }
        }
        for &index in &self.gates.order {
            let cell = &self.gates.cells[index as usize];
            let inputs = cell.inputs.iter().map(|net| wires[*net as usize].ok_or_else(|| missing("at a gate")));
            let inputs: Vec<Wire<'_>> = inputs.collect::<Result<_, _>>()?;
            for ((_, output), net) in self.gates.logic(cell).outputs.iter().zip(&cell.outputs) {
                let Output::Table(table) = output else {
                    return Err(ToolError::unexpected("yosys", "a flip-flop in a unit", "gates").into());
                };
                let value = by_table(&m, *table, &inputs);
                wires[*net as usize] = Some(if inverted == Some(index as usize) { !value } else { value });
            }
        }
        for port in self.unit.outputs() {
            let nets = self.port(&port.name).ok_or_else(|| missing(&port.name))?.iter().rev();
            let bits = nets.map(|net| wires[*net as usize].ok_or_else(|| missing(&port.name)));
            m.output(&port.name, m.concat(&bits.collect::<Result<Vec<_>, _>>()?));
        }
        Ok(m.finish()?)
    }

    /// The nets of a port, lowest bit first.
    fn port(&self, name: &str) -> Option<&[u32]> {
        self.gates.ports.iter().find(|(known, ..)| known == name).map(|(_, _, nets)| nets.as_slice())
    }
}

/// A truth table of at most six inputs as multiplexers; bit i of a position in the table is input i.
fn by_table<'m>(m: &'m Builder, table: u64, inputs: &[Wire<'m>]) -> Wire<'m> {
    let Some((last, others)) = inputs.split_last() else { return m.constant(1, table & 1) };
    let half = 1_u32 << others.len();
    let mask = (1_u64 << half) - 1;
    let (low, high) = (table & mask, table >> half & mask);
    let [if_one, if_zero] = [high, low].map(|table| by_table(m, table, others));
    if low == high { if_zero } else { last.mux(if_one, if_zero) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_hdl::Simulator;

    /// Each table of three inputs, at each position.
    #[test]
    fn tables_become_multiplexers() {
        let m = Builder::new("tables");
        let word = m.input("word_i", 3);
        let inputs = [0, 1, 2].map(|bit| word.bit(bit));
        for table in 0..256 {
            m.output(&format!("table_{table}_o"), by_table(&m, table, &inputs));
        }
        let mut simulator = Simulator::new(&m.finish().expect("a module")).expect("a simulator");
        for position in 0..8 {
            for (table, &output) in (0..256_u64).zip(simulator.evaluate([position])) {
                assert_eq!(output, table >> position & 1, "table {table:08b} at {position}");
            }
        }
    }
}
