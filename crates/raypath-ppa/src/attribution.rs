//! Attributes each cell of a flattened design to a stage and a purpose.
//!
//! Synthesis keeps the names of registers and units, and drops those of gates. A gate is attributed to the stage of the
//! registers, units and ports that its output reaches; as every stage ends in registers, these are nearly always in one
//! stage. The area of a gate that reaches several stages, such as a buffer of the opcode, is divided equally.

use crate::design::{RegisterKind, UnitKind};
use crate::library::Library;
use crate::netlist::{Direction, Net, Netlist};
use crate::report::Area;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The kind of a cell of the top module, and the group (stage) that it belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CellRole {
    Unit {
        group: usize,
        kind: UnitKind,
    },
    Register {
        group: usize,
        is_control: bool,
    },
    /// A clock gate, of the group of the registers behind it.
    ClockGate {
        group: usize,
    },
    Gate,
}

/// What a cell is counted as in a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    Unit(UnitKind),
    Registers,
    OperandMuxes,
    RegisterMuxes,
    SharedLogic,
    OutputGates,
    Control,
}

/// A group and kind that a cell, or a part of it, is counted in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Share {
    pub group: usize,
    pub kind: Kind,
}

/// A flattened design whose cells are attributed to groups: the instances in the top module, and the top module.
pub struct Attribution<'a> {
    netlist: &'a Netlist,
    /// The role of each cell.
    pub roles: Vec<CellRole>,
    /// The cells that read each net.
    readers: HashMap<Net, Vec<usize>>,
    /// The nets at output ports.
    output_nets: BTreeSet<Net>,
    groups: usize,
}

/// What a gate's output reaches through other gates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Sink {
    Unit,
    DataRegister,
    ControlRegister,
    Port,
}

/// Groups and what is reached in each.
type Sinks = BTreeSet<(usize, Sink)>;

/// The state of the depth-first search for a gate's sinks.
#[derive(Debug, Clone)]
enum Search {
    New,
    Open,
    Done(Sinks),
}

impl Kind {
    /// Its name in tables.
    pub fn name(&self) -> String {
        match self {
            Self::Unit(kind) => kind.to_string(),
            Self::Registers => "registers".to_string(),
            Self::OperandMuxes => "operand muxes".to_string(),
            Self::RegisterMuxes => "register muxes".to_string(),
            Self::SharedLogic => "shared logic".to_string(),
            Self::OutputGates => "output gates".to_string(),
            Self::Control => "control".to_string(),
        }
    }
}

impl<'a> Attribution<'a> {
    /// Finds the role of each cell. `groups` are the names of the instances in the top module, then the top module's.
    pub fn new(
        netlist: &'a Netlist,
        units: &BTreeMap<String, Netlist>,
        library: &Library,
        groups: &[String],
        registers: &BTreeMap<String, RegisterKind>,
    ) -> Self {
        let group_of = |name: &str| {
            let instance = name.split('.').next().unwrap_or_default();
            groups.iter().position(|group| group == instance).unwrap_or(groups.len() - 1)
        };
        let mut roles = Vec::with_capacity(netlist.cells.len());
        let mut readers: HashMap<Net, Vec<usize>> = HashMap::new();
        for (index, instance) in netlist.cells.iter().enumerate() {
            let cell = library.cell(&instance.cell);
            roles.push(match UnitKind::of(&instance.cell) {
                Some(kind) => CellRole::Unit { group: group_of(&instance.name), kind },
                None if cell.is_some_and(|cell| cell.is_flip_flop) => {
                    let known = registers.get(instance.name.split('[').next().unwrap_or_default());
                    let group = known.map_or_else(|| group_of(&instance.name), |register| register.group);
                    CellRole::Register { group, is_control: known.is_some_and(|register| register.is_control) }
                }
                None if cell.is_some_and(|cell| cell.is_clock_gate) => {
                    CellRole::ClockGate { group: group_of(&instance.name) }
                }
                None => CellRole::Gate,
            });
            let unit = units.get(&instance.cell);
            let is_output = |pin: &String| match (cell, unit) {
                (Some(cell), _) => cell.outputs.contains(pin),
                (None, Some(unit)) => unit.ports.get(pin).is_some_and(|port| port.direction == Direction::Output),
                (None, None) => false,
            };
            for net in instance.connections.iter().filter(|(pin, _)| !is_output(pin)).flat_map(|(_, nets)| nets) {
                readers.entry(*net).or_default().push(index);
            }
        }
        let outputs = netlist.ports.values().filter(|port| port.direction == Direction::Output);
        let output_nets = outputs.flat_map(|port| &port.bits).copied().collect();
        Self { netlist, roles, readers, output_nets, groups: groups.len() }
    }

    /// The group of the output ports: the last instance in the top module.
    pub fn port_group(&self) -> usize {
        self.groups.saturating_sub(2)
    }

    /// The groups and kinds that each cell belongs to. A gate that reaches several groups has a share for each of them,
    /// all of the same size.
    pub fn shares(&self, library: &Library) -> Vec<Vec<Share>> {
        let mut searches = vec![Search::New; self.roles.len()];
        let whole = |group: &usize, kind| vec![Share { group: *group, kind }];
        let shares = self.roles.iter().enumerate().map(|(index, role)| match role {
            CellRole::Unit { group, kind } => whole(group, Kind::Unit(kind.clone())),
            CellRole::Register { group, is_control: true } => whole(group, Kind::Control),
            CellRole::Register { group, .. } | CellRole::ClockGate { group } => whole(group, Kind::Registers),
            CellRole::Gate => {
                let sinks = self.sinks(index, library, &mut searches);
                let groups: BTreeSet<usize> = sinks.iter().map(|(group, _)| *group).collect();
                if groups.is_empty() {
                    return whole(&(self.groups - 1), Kind::SharedLogic);
                }
                let share = |group: usize| {
                    let kinds: Vec<Sink> = sinks.iter().filter(|(of, _)| *of == group).map(|(_, sink)| *sink).collect();
                    Share { group, kind: kind_by_sinks(&kinds) }
                };
                groups.into_iter().map(share).collect()
            }
        });
        shares.collect()
    }

    /// The area of each group, by kind.
    pub fn areas(&self, units: &BTreeMap<String, Netlist>, library: &Library) -> Vec<Area> {
        let unit_areas: HashMap<&String, f64> =
            units.iter().map(|(name, unit)| (name, cell_area(unit, library))).collect();
        let mut areas = vec![Area::default(); self.groups];
        for (instance, shares) in self.netlist.cells.iter().zip(self.shares(library)) {
            let own = library.cell(&instance.cell).map_or(0.0, |cell| cell.area) / shares.len() as f64;
            for Share { group, kind } in &shares {
                let area = &mut areas[*group];
                match kind {
                    Kind::Unit(kind) => {
                        let units = area.units.entry(kind.to_string()).or_default();
                        units.count += 1;
                        units.area += unit_areas.get(&instance.cell).copied().unwrap_or(0.0);
                    }
                    Kind::Registers => area.registers += own,
                    Kind::OperandMuxes => area.operand_muxes += own,
                    Kind::RegisterMuxes => area.register_muxes += own,
                    Kind::SharedLogic => area.shared_logic += own,
                    Kind::OutputGates => area.output_gates += own,
                    Kind::Control => area.control += own,
                }
            }
        }
        let rounded = |exact: &Area| {
            let mut area = Area::default();
            area.add(exact);
            area
        };
        areas.iter().map(rounded).collect()
    }

    /// The number of flip-flops of each group.
    pub fn flip_flops(&self) -> Vec<u64> {
        let mut counts = vec![0; self.groups];
        for role in &self.roles {
            if let CellRole::Register { group, .. } = role {
                counts[*group] += 1;
            }
        }
        counts
    }

    /// The sinks of a gate, by a depth-first search. It does not recurse, because chains of gates are long enough to
    /// overflow a thread's stack.
    fn sinks(&self, gate: usize, library: &Library, searches: &mut [Search]) -> Sinks {
        let mut open = vec![gate];
        while let Some(&index) = open.last() {
            if matches!(searches[index], Search::Done(_)) {
                open.pop();
                continue;
            }
            searches[index] = Search::Open;
            let (mut sinks, before) = (Sinks::new(), open.len());
            for net in self.driven(index, library) {
                if self.output_nets.contains(net) {
                    sinks.insert((self.port_group(), Sink::Port));
                }
                for &reader in self.readers.get(net).into_iter().flatten() {
                    match (&self.roles[reader], &searches[reader]) {
                        (CellRole::Unit { group, .. }, _) => _ = sinks.insert((*group, Sink::Unit)),
                        (CellRole::Register { group, is_control: true }, _) => {
                            _ = sinks.insert((*group, Sink::ControlRegister))
                        }
                        (CellRole::Register { group, .. } | CellRole::ClockGate { group }, _) => {
                            _ = sinks.insert((*group, Sink::DataRegister))
                        }
                        (CellRole::Gate, Search::Done(further)) => sinks.extend(further),
                        (CellRole::Gate, Search::New) => open.push(reader),
                        // A combinational loop, which no design here has: an open gate adds nothing.
                        (CellRole::Gate, Search::Open) => {}
                    }
                }
            }
            if open.len() == before {
                searches[index] = Search::Done(sinks);
                open.pop();
            }
        }
        match &searches[gate] {
            Search::Done(sinks) => sinks.clone(),
            Search::New | Search::Open => Sinks::new(),
        }
    }

    fn driven(&self, index: usize, library: &Library) -> impl Iterator<Item = &Net> {
        let instance = &self.netlist.cells[index];
        let pins = library.cell(&instance.cell).map(|cell| cell.outputs.clone()).unwrap_or_default();
        pins.into_iter().filter_map(|pin| instance.connections.get(&pin)).flatten()
    }
}

/// The area of all library cells of a module.
pub fn cell_area(netlist: &Netlist, library: &Library) -> f64 {
    netlist.cells.iter().filter_map(|instance| library.cell(&instance.cell)).map(|cell| cell.area).sum()
}

/// The kind that a gate with these sinks counts as.
fn kind_by_sinks(sinks: &[Sink]) -> Kind {
    match sinks {
        [Sink::Unit] => Kind::OperandMuxes,
        [Sink::ControlRegister] => Kind::Control,
        [Sink::Port] => Kind::OutputGates,
        [Sink::DataRegister] | [Sink::DataRegister, Sink::ControlRegister] => Kind::RegisterMuxes,
        _ => Kind::SharedLogic,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::netlist::YosysDesign;
    use std::path::Path;

    const LIBRARY: &str = r#"library (l) {
        cell (INV) { area : 1; pin (A) { direction : input; } pin (Y) { direction : output; function : "!A"; } }
        cell (BUF) { area : 2; pin (A) { direction : input; } pin (Y) { direction : output; function : "A"; } }
        cell (NAND2) { area : 4; pin (A) { direction : input; } pin (B) { direction : input; }
            pin (Y) { direction : output; function : "!(A B)"; } }
        cell (DFF) { area : 16; ff (I, J) { next_state : "D"; } pin (D) { direction : input; }
            pin (Q) { direction : output; function : "I"; } }
    }"#;

    /// Two stages and an output: a register and a control register each, a unit in the second.
    const NETLIST: &str = r#"{"modules": {
        "raypath_fp_add": {
            "ports": {"a_i": {"direction": "input", "bits": [2]}, "s_o": {"direction": "output", "bits": [3]}},
            "cells": {"x": {"type": "NAND2", "connections": {"A": [2], "B": [2], "Y": [4]}},
                      "y": {"type": "INV", "connections": {"A": [4], "Y": [3]}}}},
        "raypath": {
            "ports": {"a_i": {"direction": "input", "bits": [2]}, "b_o": {"direction": "output", "bits": [30]}},
            "cells": {
                "u_a.num_q[0]": {"type": "DFF", "connections": {"D": [2], "Q": [10]}},
                "u_a.valid_q": {"type": "DFF", "connections": {"D": [18], "Q": [11]}},
                "u_b.num_q[0]": {"type": "DFF", "connections": {"D": [16], "Q": [20]}},
                "u_b.valid_q": {"type": "DFF", "connections": {"D": [19], "Q": [21]}},
                "u_b.u_add_0": {"type": "raypath_fp_add", "connections": {"a_i": [13], "s_o": [15]}},
                "c0": {"type": "INV", "connections": {"A": [10], "Y": [12]}},
                "c1": {"type": "NAND2", "connections": {"A": [12], "B": [14], "Y": [13]}},
                "c2": {"type": "INV", "connections": {"A": [11], "Y": [14]}},
                "c3": {"type": "NAND2", "connections": {"A": [15], "B": [14], "Y": [16]}},
                "c4": {"type": "BUF", "connections": {"A": [21], "Y": [17]}},
                "c5": {"type": "INV", "connections": {"A": [17], "Y": [18]}},
                "c6": {"type": "INV", "connections": {"A": [17], "Y": [19]}},
                "c7": {"type": "INV", "connections": {"A": [20], "Y": [30]}}}}}}"#;

    #[test]
    fn gates_are_attributed_to_their_sinks() {
        let library = Library::of(LIBRARY.to_string(), Path::new("l.lib")).expect("a library");
        let mut design: YosysDesign = serde_json::from_str(NETLIST).expect("JSON");
        let (unit, _) = design.take("raypath_fp_add").expect("a unit");
        let (top, _) = design.take("raypath").expect("a module");
        let units = BTreeMap::from([(unit.module.clone(), unit)]);
        let groups = ["u_a", "u_b", "u_out", "raypath"].map(str::to_string);
        let register = |name: &str, group, is_control| (name.to_string(), RegisterKind { group, is_control });
        let registers = BTreeMap::from([
            register("u_a.num_q", 0, false),
            register("u_a.valid_q", 0, true),
            register("u_b.num_q", 1, false),
            register("u_b.valid_q", 1, true),
        ]);
        let attribution = Attribution::new(&top, &units, &library, &groups, &registers);
        assert_eq!(attribution.flip_flops(), [2, 2, 0, 0]);
        let areas = attribution.areas(&units, &library);
        let add = BTreeMap::from([("add".to_string(), crate::report::Units { count: 1, area: 5.0 })]);
        // c4 reaches control registers of both stages and is divided; c5 and c6 reach one each.
        let first = Area { registers: 16.0, control: 16.0 + 1.0 + 1.0, total: 34.0, ..Area::default() };
        // c0 and c1 reach the unit, c3 the register, c2 both.
        let second = Area {
            units: add,
            registers: 16.0,
            operand_muxes: 5.0,
            register_muxes: 4.0,
            shared_logic: 1.0,
            control: 16.0 + 1.0 + 1.0,
            total: 49.0,
            ..Area::default()
        };
        let output = Area { output_gates: 1.0, total: 1.0, ..Area::default() };
        assert_eq!(areas, [first, second, output, Area::default()]);
    }
}
