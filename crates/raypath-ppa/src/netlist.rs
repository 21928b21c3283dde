//! A synthesised module: library cells and units on nets, parsed from Yosys's JSON.

use raypath_tools::ToolError;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// A module after synthesis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Netlist {
    pub module: String,
    pub ports: BTreeMap<String, Port>,
    pub cells: Vec<Instance>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    pub direction: Direction,
    /// The nets, lowest bit first.
    pub bits: Vec<Net>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    Input,
    Output,
    Inout,
}

/// An instance of a library cell or a unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Instance {
    /// The library's cell, or the unit's module.
    #[serde(rename = "of")]
    pub cell: String,
    /// The instance name of a unit, the register bit of a flip-flop; empty for gates.
    pub name: String,
    pub connections: BTreeMap<String, Vec<Net>>,
}

/// A net of one bit. In Yosys's JSON, a wire is a number and a constant is a string.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected the number of a net, or \"0\", \"1\", \"x\" or \"z\"")]
pub enum Net {
    Wire(u32),
    Constant(Constant),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Constant {
    #[serde(rename = "0")]
    Zero,
    #[serde(rename = "1")]
    One,
    /// Not driven, or not connected.
    #[serde(rename = "x", alias = "z")]
    Open,
}

/// A design in Yosys's JSON.
#[derive(Debug, Deserialize)]
pub struct YosysDesign {
    modules: HashMap<String, YosysModule>,
}

#[derive(Debug, Deserialize)]
struct YosysModule {
    #[serde(default)]
    ports: BTreeMap<String, Port>,
    #[serde(default)]
    cells: BTreeMap<String, YosysCell>,
    #[serde(default)]
    netnames: BTreeMap<String, NamedNet>,
}

#[derive(Debug, Deserialize)]
struct YosysCell {
    #[serde(rename = "type")]
    cell: String,
    connections: BTreeMap<String, Vec<Net>>,
}

/// A signal and its nets, lowest bit first.
#[derive(Debug, Deserialize)]
pub struct NamedNet {
    pub bits: Vec<Net>,
    /// The index of the lowest bit.
    #[serde(default)]
    pub offset: usize,
}

impl YosysDesign {
    /// Removes and returns a module, and the names of its nets.
    pub fn take(&mut self, module: &str) -> Result<(Netlist, BTreeMap<String, NamedNet>), ToolError> {
        let found = self.modules.remove(module);
        let found = found.ok_or_else(|| ToolError::unexpected("yosys", "other modules", format!("module {module}")))?;
        let cells = found.cells.into_iter();
        let cells = cells.map(|(name, cell)| Instance { cell: cell.cell, name, connections: cell.connections });
        Ok((Netlist { module: module.to_string(), ports: found.ports, cells: cells.collect() }, found.netnames))
    }
}
