//! A synthesised module: library cells and units on nets, parsed from Yosys's JSON.

use raypath_tools::ToolError;
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::{BTreeMap, HashMap};
use std::fmt;

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

/// A net of one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Net {
    Zero,
    One,
    /// Not driven, or not connected.
    Open,
    Wire(u32),
}

/// A design in Yosys's JSON.
#[derive(Debug, Deserialize)]
pub struct YosysDesign {
    modules: HashMap<String, YosysModule>,
}

#[derive(Debug, Deserialize)]
struct YosysModule {
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

/// In the JSON form, as Yosys writes it, a wire is a number and a constant is a string.
impl Serialize for Net {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Zero => serializer.serialize_str("0"),
            Self::One => serializer.serialize_str("1"),
            Self::Open => serializer.serialize_str("x"),
            Self::Wire(number) => serializer.serialize_u32(*number),
        }
    }
}

impl<'de> Deserialize<'de> for Net {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NetVisitor)
    }
}

struct NetVisitor;

impl Visitor<'_> for NetVisitor {
    type Value = Net;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the number of a net, or \"0\", \"1\", \"x\" or \"z\"")
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Net, E> {
        u32::try_from(number).map(Net::Wire).map_err(|_| E::invalid_value(de::Unexpected::Unsigned(number), &self))
    }

    fn visit_str<E: de::Error>(self, constant: &str) -> Result<Net, E> {
        match constant {
            "0" => Ok(Net::Zero),
            "1" => Ok(Net::One),
            "x" | "z" => Ok(Net::Open),
            _ => Err(E::invalid_value(de::Unexpected::Str(constant), &self)),
        }
    }
}
