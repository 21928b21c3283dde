//! A netlist as structural Verilog, which OpenSTA reads. Cell names are made of numbers, so that paths can be read back
//! without escaping rules: `g3_r17` is a register of group 3, cell 17 of the netlist.

use crate::attribution::CellRole;
use crate::netlist::{Constant, Direction, Net, Netlist};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write;

const OPEN: Net = Net::Constant(Constant::Open);

/// The name of a cell of the top module.
pub fn cell_name(index: usize, role: &CellRole) -> String {
    match role {
        // A path to the enable of a clock gate is one to the registers behind it.
        CellRole::Register { group, .. } | CellRole::ClockGate { group } => format!("g{group}_r{index}"),
        CellRole::Unit { group, .. } => format!("g{group}_u{index}"),
        CellRole::Gate => format!("x{index}"),
    }
}

/// The name of a cell of a unit.
pub fn inner_name(index: usize) -> String {
    format!("x{index}")
}

/// The index of the cell with this name.
pub fn cell_index(name: &str) -> Option<usize> {
    let number = name.strip_prefix('x').or_else(|| name.split_once("_r").or(name.split_once("_u")).map(|(_, n)| n))?;
    number.parse().ok()
}

/// A name pattern that matches the registers of a group.
pub fn registers(group: usize) -> String {
    format!("g{group}_r*")
}

/// The name of a net that is at no port.
pub fn wire_name(number: u32) -> String {
    format!("n{number}")
}

/// The names of the nets at ports.
pub fn net_names(netlist: &Netlist) -> HashMap<Net, String> {
    port_nets(netlist).0
}

/// Prints a design as Verilog: its units, and the top module with cells named by `name_of` their indices.
pub fn design(top: &Netlist, units: &BTreeMap<String, Netlist>, name_of: impl Fn(usize) -> String) -> String {
    let units: String = units.values().map(|unit| module(unit, inner_name)).collect();
    units + &module(top, name_of)
}

/// Prints a module as Verilog, its cells named by `name_of` their indices.
pub fn module(netlist: &Netlist, name_of: impl Fn(usize) -> String) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_module(&mut text, netlist, name_of);
    text
}

fn write_module(text: &mut String, netlist: &Netlist, name_of: impl Fn(usize) -> String) -> std::fmt::Result {
    let ports: Vec<&str> = netlist.ports.keys().map(String::as_str).collect();
    writeln!(text, "module {} ({});", netlist.module, ports.join(", "))?;
    for (direction, word) in DIRECTIONS {
        for (name, port) in netlist.ports.iter().filter(|(_, port)| port.direction == direction) {
            let high = port.bits.len().saturating_sub(1);
            let range = if high > 0 { format!("[{high}:0] ") } else { String::new() };
            writeln!(text, "  {word} {range}{name};")?;
        }
    }
    let (names, assigned) = port_nets(netlist);
    let connected = netlist.cells.iter().flat_map(|instance| instance.connections.values().flatten());
    let inner: BTreeSet<&Net> = connected.filter(|net| !names.contains_key(net)).collect();
    for net in inner {
        if let Net::Wire(number) = net {
            writeln!(text, "  wire {};", wire_name(*number))?;
        }
    }
    let value = |net: &Net| match net {
        Net::Constant(Constant::Zero | Constant::Open) => "1'b0".to_string(),
        Net::Constant(Constant::One) => "1'b1".to_string(),
        Net::Wire(number) => names.get(net).cloned().unwrap_or_else(|| wire_name(*number)),
    };
    for (port, net) in assigned {
        writeln!(text, "  assign {port} = {};", value(&net))?;
    }
    for (index, instance) in netlist.cells.iter().enumerate() {
        let connected = instance.connections.iter().filter(|(_, nets)| nets.iter().any(|net| *net != OPEN));
        let pins = connected.map(|(pin, nets)| match nets.as_slice() {
            [net] => format!(".{pin}({})", value(net)),
            nets => format!(".{pin}({{{}}})", nets.iter().rev().map(value).collect::<Vec<_>>().join(", ")),
        });
        let pins: Vec<String> = pins.collect();
        writeln!(text, "  {} {} ({});", instance.cell, name_of(index), pins.join(", "))?;
    }
    writeln!(text, "endmodule")
}

/// The directions of ports in the order of declaration.
const DIRECTIONS: [(Direction, &str); 3] =
    [(Direction::Input, "input"), (Direction::Inout, "inout"), (Direction::Output, "output")];

/// The names of nets at ports, and the bits of ports to assign a net to. A net at a port has the port's name. If it is
/// at several ports, the others are assigned.
fn port_nets(netlist: &Netlist) -> (HashMap<Net, String>, Vec<(String, Net)>) {
    let (mut names, mut assigned) = (HashMap::new(), Vec::new());
    for (direction, _) in DIRECTIONS {
        for (name, port) in netlist.ports.iter().filter(|(_, port)| port.direction == direction) {
            for (position, net) in port.bits.iter().enumerate() {
                let bit = if port.bits.len() > 1 { format!("{name}[{position}]") } else { name.clone() };
                if matches!(net, Net::Wire(_)) && !names.contains_key(net) {
                    names.insert(*net, bit);
                } else if *net != OPEN {
                    assigned.push((bit, *net));
                }
            }
        }
    }
    (names, assigned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::netlist::YosysDesign;

    #[test]
    fn ports_wires_constants_and_buses() {
        let json = r#"{"modules": {"top": {
            "ports": {
                "a_i": {"direction": "input", "bits": [2, 3]},
                "b_o": {"direction": "output", "bits": [4]},
                "c_o": {"direction": "output", "bits": [4, 2, "1"]}},
            "cells": {
                "$1": {"type": "NAND2", "connections": {"A": [2], "B": [5], "Y": [4]}},
                "u_0": {"type": "raypath_fp_add", "connections": {"a_i": [3, "0"], "s_o": [5], "open_o": ["x"]}}},
            "netnames": {}}}}"#;
        let mut design: YosysDesign = serde_json::from_str(json).expect("JSON");
        let (netlist, _) = design.take("top").expect("a module");
        let text = module(&netlist, |index| format!("x{index}"));
        let expected = "\
module top (a_i, b_o, c_o);
  input [1:0] a_i;
  output b_o;
  output [2:0] c_o;
  wire n5;
  assign c_o[0] = b_o;
  assign c_o[1] = a_i[0];
  assign c_o[2] = 1'b1;
  NAND2 x0 (.A(a_i[0]), .B(n5), .Y(b_o));
  raypath_fp_add x1 (.a_i({1'b0, a_i[1]}), .s_o(n5));
endmodule
";
        assert_eq!(text, expected);
        assert!(design.take("top").is_err());
    }

    #[test]
    fn names_give_cell_indices() {
        let roles = [CellRole::Gate, CellRole::Register { group: 12, is_control: false }];
        for (index, role) in roles.iter().enumerate() {
            assert_eq!(cell_index(&cell_name(index, role)), Some(index));
        }
        assert_eq!(cell_index("g3_u41"), Some(41));
        assert_eq!(cell_index("opcode_i"), None);
    }
}
