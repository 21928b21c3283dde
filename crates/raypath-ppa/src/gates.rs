//! A synthesised design as gates and flip-flops on the nets of one flat netlist.

use crate::library::Library;
use crate::logic::{Logic, Output};
use crate::netlist::{Constant, Direction, Instance, Net, Netlist};
use crate::structural;
use raypath_tools::ToolError;
use std::collections::{BTreeMap, HashMap};

/// The number of a net in [`Gates`].
pub type NetId = u32;

/// The net that is always 0.
pub const ZERO: NetId = 0;
/// The net that is always 1.
pub const ONE: NetId = 1;

/// The gates of a design, with the units in place of their instances.
pub struct Gates {
    /// The number of nets.
    pub nets: usize,
    /// The library cells, first those of the top module.
    pub cells: Vec<Cell>,
    /// The cells in an order in which each comes after those that its outputs depend on without a clock edge.
    pub order: Vec<u32>,
    /// The ports of the top module: name, direction and nets, lowest bit first.
    pub ports: Vec<(String, Direction, Vec<NetId>)>,
    /// The distinct behaviours of cells.
    pub logic: Vec<Logic>,
}

/// A library cell.
#[derive(Debug, Clone)]
pub struct Cell {
    /// The cell of the top module that it is, or the unit that it is in.
    pub top: usize,
    /// Its number in the unit.
    pub inner: Option<usize>,
    /// The index in [`Gates::logic`].
    pub logic: u32,
    /// The nets at the inputs, in the order of the logic's.
    pub inputs: Vec<NetId>,
    /// The nets at the outputs, in the order of the logic's.
    pub outputs: Vec<NetId>,
}

impl Gates {
    /// Puts the gates of `units` in place of the instances in `top`.
    ///
    /// # Errors
    /// A cell that is neither a gate nor a flip-flop on a rising edge; a combinational loop.
    pub fn new(top: &Netlist, units: &BTreeMap<String, Netlist>, library: &Library) -> Result<Self, ToolError> {
        let mut flat = Flattener { library, joined: vec![ZERO, ONE], logic: Vec::new(), known: HashMap::new() };
        let mut nets = HashMap::new();
        let (mut cells, mut inner) = (Vec::new(), Vec::new());
        for (index, instance) in top.cells.iter().enumerate() {
            match units.get(&instance.cell) {
                None => cells.push(flat.cell(instance, index, None, &mut nets)?),
                Some(unit) => {
                    let mut own = HashMap::new();
                    for (port, outside) in &instance.connections {
                        let inside = unit.ports.get(port).map(|port| port.bits.as_slice()).unwrap_or_default();
                        for (inside, outside) in inside.iter().zip(outside) {
                            let (inside, outside) = (flat.net(*inside, &mut own), flat.net(*outside, &mut nets));
                            flat.join(inside, outside);
                        }
                    }
                    for (number, gate) in unit.cells.iter().enumerate() {
                        inner.push(flat.cell(gate, index, Some(number), &mut own)?);
                    }
                }
            }
        }
        cells.extend(inner);
        let mut ports = Vec::new();
        for (name, port) in &top.ports {
            let bits = port.bits.iter().map(|net| flat.net(*net, &mut nets)).collect();
            ports.push((name.clone(), port.direction, bits));
        }
        flat.numbered(cells, ports)
    }

    /// The path of a cell in the structural netlist.
    pub fn name(&self, cell: &Cell, name_of: &dyn Fn(usize) -> String) -> String {
        match cell.inner {
            Some(inner) => format!("{}/{}", name_of(cell.top), structural::inner_name(inner)),
            None => name_of(cell.top),
        }
    }

    /// The lowest bit of an input port.
    pub fn input(&self, name: &str) -> Option<NetId> {
        let port = self.ports.iter().find(|(known, of, _)| known == name && *of == Direction::Input);
        port.and_then(|(_, _, nets)| nets.first().copied())
    }

    /// The behaviour of a cell.
    pub fn logic(&self, cell: &Cell) -> &Logic {
        &self.logic[cell.logic as usize]
    }
}

struct Flattener<'l> {
    library: &'l Library,
    /// For each net the one that it is joined with, or itself.
    joined: Vec<NetId>,
    logic: Vec<Logic>,
    /// The index of the logic of each cell of the library.
    known: HashMap<String, u32>,
}

impl Flattener<'_> {
    fn fresh(&mut self) -> NetId {
        let number = self.joined.len() as NetId;
        self.joined.push(number);
        number
    }

    fn net(&mut self, net: Net, known: &mut HashMap<u32, NetId>) -> NetId {
        match net {
            // An open input is 0, as in the text for OpenSTA.
            Net::Constant(Constant::Zero | Constant::Open) => ZERO,
            Net::Constant(Constant::One) => ONE,
            Net::Wire(number) => *known.entry(number).or_insert_with(|| self.fresh()),
        }
    }

    fn root(&self, mut net: NetId) -> NetId {
        while self.joined[net as usize] != net {
            net = self.joined[net as usize];
        }
        net
    }

    /// Makes two nets one. Constants have the lowest numbers, which are kept.
    fn join(&mut self, a: NetId, b: NetId) {
        let (a, b) = (self.root(a), self.root(b));
        self.joined[a.max(b) as usize] = a.min(b);
    }

    fn cell(
        &mut self,
        instance: &Instance,
        top: usize,
        inner: Option<usize>,
        nets: &mut HashMap<u32, NetId>,
    ) -> Result<Cell, ToolError> {
        let logic = match self.known.get(&instance.cell) {
            Some(logic) => *logic,
            None => {
                let found = self.library.cell(&instance.cell).and_then(|cell| cell.logic.clone());
                let found = found.ok_or_else(|| {
                    let expected = "gates, and flip-flops on the rising edge, with at most six inputs";
                    ToolError::unexpected("yosys", format!("a cell {}", instance.cell), expected)
                })?;
                self.logic.push(found);
                self.known.insert(instance.cell.clone(), self.logic.len() as u32 - 1);
                self.logic.len() as u32 - 1
            }
        };
        let of = |pin: &String| instance.connections.get(pin).and_then(|nets| nets.first()).copied();
        let Logic { inputs, outputs, .. } = self.logic[logic as usize].clone();
        let open = Net::Constant(Constant::Open);
        let inputs = inputs.iter().map(|pin| self.net(of(pin).unwrap_or(open), nets)).collect();
        let output = |(pin, _): &(String, Output)| match of(pin) {
            Some(Net::Wire(number)) => self.net(Net::Wire(number), nets),
            _ => self.fresh(),
        };
        Ok(Cell { top, inner, logic, inputs, outputs: outputs.iter().map(output).collect() })
    }

    /// Gives joined nets one number, and sorts the cells.
    fn numbered(
        self,
        mut cells: Vec<Cell>,
        mut ports: Vec<(String, Direction, Vec<NetId>)>,
    ) -> Result<Gates, ToolError> {
        let mut numbers = vec![NetId::MAX; self.joined.len()];
        (numbers[0], numbers[1]) = (ZERO, ONE);
        let mut nets = 2;
        let mut number = |net: &mut NetId| {
            let place = &mut numbers[self.root(*net) as usize];
            if *place == NetId::MAX {
                *place = nets;
                nets += 1;
            }
            *net = *place;
        };
        cells.iter_mut().flat_map(|cell| cell.inputs.iter_mut().chain(&mut cell.outputs)).for_each(&mut number);
        ports.iter_mut().flat_map(|(_, _, nets)| nets).for_each(&mut number);
        let nets = nets as usize;
        let order = order(&cells, &self.logic, nets)?;
        Ok(Gates { nets, cells, order, ports, logic: self.logic })
    }
}

/// The cells in an order for evaluation.
fn order(cells: &[Cell], logic: &[Logic], nets: usize) -> Result<Vec<u32>, ToolError> {
    let mut readers: Vec<Vec<u32>> = vec![Vec::new(); nets];
    let mut waits_for: Vec<usize> = vec![0; cells.len()];
    let mut is_driven = vec![false; nets];
    for net in cells.iter().flat_map(|cell| &cell.outputs) {
        is_driven[*net as usize] = true;
    }
    for (index, cell) in cells.iter().enumerate() {
        for (position, net) in cell.inputs.iter().enumerate() {
            if is_driven[*net as usize] && acts_at_once(&logic[cell.logic as usize], position) {
                readers[*net as usize].push(index as u32);
                waits_for[index] += 1;
            }
        }
    }
    let mut order: Vec<u32> = (0..cells.len() as u32).filter(|cell| waits_for[*cell as usize] == 0).collect();
    let mut next = 0;
    while next < order.len() {
        for net in &cells[order[next] as usize].outputs {
            for reader in std::mem::take(&mut readers[*net as usize]) {
                waits_for[reader as usize] -= 1;
                if waits_for[reader as usize] == 0 {
                    order.push(reader);
                }
            }
        }
        next += 1;
    }
    match order.len() == cells.len() {
        true => Ok(order),
        false => Err(ToolError::unexpected("yosys", "a combinational loop", "gates without one")),
    }
}

/// Whether an input acts on the outputs without a clock edge.
fn acts_at_once(logic: &Logic, input: usize) -> bool {
    let Some(state) = &logic.state else { return true };
    let changes = |table: u64| {
        let positions = 1_u64 << logic.inputs.len();
        (0..positions).any(|position| table >> position & 1 != table >> (position ^ 1 << input) & 1)
    };
    changes(state.clear) || changes(state.preset)
}
