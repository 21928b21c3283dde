//! Where each cell of a flat design belongs, and what it is for.
//!
//! Synthesis keeps the names of registers and units, and forgets those of gates. But a gate belongs to the registers,
//! units and ports that its output leads to, and since every stage ends in registers those nearly always stand in one
//! stage. What leads to several (a buffer behind an opcode that its own stage also holds) is shared equally.

use crate::design::{RegisterKind, UnitKind};
use crate::library::Library;
use crate::netlist::{Direction, Net, Netlist};
use crate::report::Area;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What a cell is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    Unit { group: usize, kind: UnitKind },
    Register { group: usize, is_control: bool },
    Gate,
}

/// A design with everything in its place.
pub struct Placed<'a> {
    netlist: &'a Netlist,
    /// Of each cell.
    pub roles: Vec<Role>,
    /// For each net the cells that read it.
    readers: HashMap<Net, Vec<usize>>,
    /// Nets at output ports.
    leaving: BTreeSet<Net>,
    groups: usize,
}

/// What gates lead to, in the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Goal {
    Unit,
    Data,
    Control,
    Port,
}

type Goals = BTreeSet<(usize, Goal)>;

/// How far the search for a gate's goals has come.
#[derive(Debug, Clone)]
enum Search {
    New,
    Open,
    Done(Goals),
}

impl<'a> Placed<'a> {
    /// Finds the role of each cell. `groups` are the instances in the top module by name, and its own.
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
                Some(kind) => Role::Unit { group: group_of(&instance.name), kind },
                None if cell.is_some_and(|cell| cell.is_flip_flop) => {
                    let known = registers.get(instance.name.split('[').next().unwrap_or_default());
                    let group = known.map_or_else(|| group_of(&instance.name), |register| register.group);
                    Role::Register { group, is_control: known.is_some_and(|register| register.is_control) }
                }
                None => Role::Gate,
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
        let leaving = outputs.flat_map(|port| &port.bits).copied().collect();
        Self { netlist, roles, readers, leaving, groups: groups.len() }
    }

    /// The group that output ports belong to: the last instance in the top module.
    pub fn port_group(&self) -> usize {
        self.groups.saturating_sub(2)
    }

    /// Area of each group.
    pub fn areas(&self, units: &BTreeMap<String, Netlist>, library: &Library) -> Vec<Area> {
        let unit_areas: HashMap<&String, f64> =
            units.iter().map(|(name, unit)| (name, cell_area(unit, library))).collect();
        let mut areas = vec![Area::default(); self.groups];
        let mut known = vec![Search::New; self.roles.len()];
        for (index, instance) in self.netlist.cells.iter().enumerate() {
            let own = library.cell(&instance.cell).map_or(0.0, |cell| cell.area);
            match &self.roles[index] {
                Role::Unit { group, kind } => {
                    let units = areas[*group].units.entry(kind.to_string()).or_default();
                    units.count += 1;
                    units.area += unit_areas.get(&instance.cell).copied().unwrap_or(0.0);
                }
                Role::Register { group, is_control: true } => areas[*group].control += own,
                Role::Register { group, .. } => areas[*group].registers += own,
                Role::Gate => {
                    let goals = self.goals(index, library, &mut known);
                    let groups: BTreeSet<usize> = goals.iter().map(|(group, _)| *group).collect();
                    for group in &groups {
                        let kinds: Vec<Goal> =
                            goals.iter().filter(|(of, _)| of == group).map(|(_, goal)| *goal).collect();
                        *kind_of_gate(&mut areas[*group], &kinds) += own / groups.len() as f64;
                    }
                    if groups.is_empty() {
                        areas[self.groups - 1].shared_logic += own;
                    }
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

    /// Flip-flops of each group.
    pub fn flip_flops(&self) -> Vec<u64> {
        let mut counts = vec![0; self.groups];
        for role in &self.roles {
            if let Role::Register { group, .. } = role {
                counts[*group] += 1;
            }
        }
        counts
    }

    /// What a gate leads to: depth first, without recursion, since chains of gates are longer than a thread's stack
    /// likes.
    fn goals(&self, gate: usize, library: &Library, known: &mut [Search]) -> Goals {
        let mut open = vec![gate];
        while let Some(&index) = open.last() {
            if matches!(known[index], Search::Done(_)) {
                open.pop();
                continue;
            }
            known[index] = Search::Open;
            let (mut goals, before) = (Goals::new(), open.len());
            for net in self.driven(index, library) {
                if self.leaving.contains(net) {
                    goals.insert((self.port_group(), Goal::Port));
                }
                for &reader in self.readers.get(net).into_iter().flatten() {
                    match (&self.roles[reader], &known[reader]) {
                        (Role::Unit { group, .. }, _) => _ = goals.insert((*group, Goal::Unit)),
                        (Role::Register { group, is_control: true }, _) => _ = goals.insert((*group, Goal::Control)),
                        (Role::Register { group, .. }, _) => _ = goals.insert((*group, Goal::Data)),
                        (Role::Gate, Search::Done(further)) => goals.extend(further),
                        (Role::Gate, Search::New) => open.push(reader),
                        // A loop of gates, which no design here has: the part already open adds nothing.
                        (Role::Gate, Search::Open) => {}
                    }
                }
            }
            if open.len() == before {
                known[index] = Search::Done(goals);
                open.pop();
            }
        }
        match &known[gate] {
            Search::Done(goals) => goals.clone(),
            Search::New | Search::Open => Goals::new(),
        }
    }

    fn driven(&self, index: usize, library: &Library) -> impl Iterator<Item = &Net> {
        let instance = &self.netlist.cells[index];
        let pins = library.cell(&instance.cell).map(|cell| cell.outputs.clone()).unwrap_or_default();
        pins.into_iter().filter_map(|pin| instance.connections.get(&pin)).flatten()
    }
}

/// The area of all cells of a module.
pub fn cell_area(netlist: &Netlist, library: &Library) -> f64 {
    netlist.cells.iter().filter_map(|instance| library.cell(&instance.cell)).map(|cell| cell.area).sum()
}

fn kind_of_gate<'a>(area: &'a mut Area, goals: &[Goal]) -> &'a mut f64 {
    match goals {
        [Goal::Unit] => &mut area.operand_muxes,
        [Goal::Control] => &mut area.control,
        [Goal::Port] => &mut area.output_gates,
        [Goal::Data] | [Goal::Data, Goal::Control] => &mut area.register_muxes,
        _ => &mut area.shared_logic,
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
    fn gates_belong_to_what_they_lead_to() {
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
        let placed = Placed::new(&top, &units, &library, &groups, &registers);
        assert_eq!(placed.flip_flops(), [2, 2, 0, 0]);
        let areas = placed.areas(&units, &library);
        let add = BTreeMap::from([("add".to_string(), crate::report::Units { count: 1, area: 5.0 })]);
        // c4 leads to control of both and is shared; c5 and c6 to one each.
        let first = Area { registers: 16.0, control: 16.0 + 1.0 + 1.0, total: 34.0, ..Area::default() };
        // c0 and c1 lead to the unit, c3 to the register, c2 to both.
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
