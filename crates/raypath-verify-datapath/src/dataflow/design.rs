//! A design as Yosys reads it, in the format BTOR2 (Niemetz et al. 2018), and the units that were taken out of it.

use raypath_tools::ToolError;
use raypath_verify::Error;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};

/// The number of a node in a BTOR2 file.
pub(super) type Id = u64;

/// A design without its units: their outputs are inputs of the design, and their operands its outputs.
#[derive(Debug, Default)]
pub(super) struct Design {
    /// The nodes, by number.
    pub nodes: HashMap<Id, Node>,
    /// The inputs, by name.
    pub inputs: BTreeMap<String, Id>,
    /// The outputs, by name.
    pub outputs: BTreeMap<String, Id>,
    /// Further nodes with names.
    pub names: BTreeMap<String, Id>,
    /// The units, by instance.
    pub units: BTreeMap<String, String>,
    /// The ports of each module of a unit.
    pub modules: BTreeMap<String, UnitModule>,
}

/// A node of a design.
#[derive(Debug)]
pub(super) struct Node {
    pub width: u32,
    pub kind: NodeKind,
}

/// How the value of a node comes about.
#[derive(Debug)]
pub(super) enum NodeKind {
    /// Any value, in each cycle; or the output of a unit, which the name tells.
    Input(Option<String>),
    /// A register: any value at first, then the value of `next` in the cycle before.
    State { next: Option<Id> },
    /// A constant in binary.
    Constant(String),
    /// An operator of BTOR2 with its operands and numbers.
    Operator { name: String, operands: Vec<Id>, numbers: Vec<u32> },
}

/// The ports of a unit, by name without the direction, with their widths, in the order of their declaration.
#[derive(Debug, Default, Clone)]
pub(super) struct UnitModule {
    pub inputs: Vec<(String, u32)>,
    pub outputs: Vec<(String, u32)>,
}

impl Design {
    /// Reads a design from Yosys's files: BTOR2 without the units, and JSON of the flat design with them.
    pub fn read(btor: &str, json: &str, top: &str) -> Result<Self, Error> {
        let mut design = Self::default();
        let mut widths: HashMap<Id, u32> = HashMap::new();
        for line in btor.lines() {
            let line = line.split_once(';').map_or(line, |(code, _)| code);
            let words: Vec<&str> = line.split_whitespace().collect();
            if !words.is_empty() {
                design.add(&words, &mut widths).ok_or_else(|| unexpected(line, "a line of BTOR2"))?;
            }
        }
        design.add_units(json, top)?;
        Ok(design)
    }

    /// Adds a line of a BTOR2 file.
    fn add(&mut self, words: &[&str], widths: &mut HashMap<Id, u32>) -> Option<()> {
        let (id, kind, rest) = (words[0].parse::<Id>().ok()?, *words.get(1)?, &words[2..]);
        let number = |index: usize| rest.get(index)?.parse::<Id>().ok();
        if kind == "sort" {
            // Yosys replaced memories by registers, so that there are no arrays.
            widths.insert(id, number(1).filter(|_| rest[0] == "bitvec")? as u32);
            return Some(());
        }
        if kind == "output" {
            self.outputs.insert(rest.get(1)?.to_string(), number(0)?);
            return Some(());
        }
        let width = *widths.get(&number(0)?)?;
        if kind == "next" {
            let value = number(2)?;
            let NodeKind::State { next } = &mut self.nodes.get_mut(&number(1)?)?.kind else { return None };
            *next = Some(value);
            return Some(());
        }
        let kind = match kind {
            "input" => {
                let name = rest.get(1).map(|name| name.to_string());
                self.inputs.extend(name.clone().map(|name| (name, id)));
                NodeKind::Input(name)
            }
            "state" => {
                self.names.extend(rest.get(1).map(|name| (name.to_string(), id)));
                NodeKind::State { next: None }
            }
            "const" => NodeKind::Constant(rest.get(1)?.to_string()),
            "zero" => NodeKind::Constant("0".repeat(width as usize)),
            "one" => NodeKind::Constant(format!("{:0>1$}", 1, width as usize)),
            "ones" => NodeKind::Constant("1".repeat(width as usize)),
            operator => {
                let (operands, numbers) = match operator {
                    "slice" => (1, 2),
                    "uext" | "sext" => (1, 1),
                    "not" | "redor" | "redand" | "redxor" | "neg" => (1, 0),
                    "ite" => (3, 0),
                    _ => (2, 0),
                };
                let found = (1..=operands + numbers).map(&number).collect::<Option<Vec<Id>>>()?;
                let (operands, numbers) = found.split_at(operands);
                self.names.extend(rest.get(found.len() + 1).map(|name| (name.to_string(), id)));
                let numbers = numbers.iter().map(|&number| number as u32).collect();
                NodeKind::Operator { name: operator.to_string(), operands: operands.to_vec(), numbers }
            }
        };
        self.nodes.insert(id, Node { width, kind });
        Some(())
    }

    /// Adds the units: the cells of modules that Yosys knows by their ports alone.
    fn add_units(&mut self, json: &str, top: &str) -> Result<(), Error> {
        let json: Value = serde_json::from_str(json).map_err(|problem| unexpected(&problem.to_string(), "JSON"))?;
        let objects = |value: &Value| value.as_object().cloned().unwrap_or_default();
        for (name, module) in objects(&json["modules"]) {
            if module["attributes"]["blackbox"].is_null() {
                continue;
            }
            let mut unit = UnitModule::default();
            for (port, contents) in objects(&module["ports"]) {
                let width = contents["bits"].as_array().map_or(0, Vec::len) as u32;
                let stem = port.rsplit_once('_').map_or(port.as_str(), |(stem, _)| stem).to_string();
                let side = if contents["direction"] == "input" { &mut unit.inputs } else { &mut unit.outputs };
                side.push((stem, width));
            }
            self.modules.insert(name, unit);
        }
        for (cell, contents) in objects(&json["modules"][top]["cells"]) {
            let module = contents["type"].as_str().unwrap_or_default();
            if self.modules.contains_key(module) {
                self.units.insert(cell, module.to_string());
            }
        }
        Ok(())
    }

    /// The register of a name, which may be one of several. Yosys puts a selection of the reset's value behind a
    /// register with an asynchronous reset, and gives the name to what is selected.
    pub fn register(&self, name: &str) -> Option<Id> {
        let mut id = *self.names.get(name)?;
        loop {
            match &self.nodes.get(&id)?.kind {
                NodeKind::State { .. } => return Some(id),
                NodeKind::Operator { name, operands, .. } if name == "uext" => id = operands[0],
                NodeKind::Operator { name, operands, .. } if name == "ite" => {
                    let is_register =
                        |id: &&Id| matches!(self.nodes.get(*id).map(|node| &node.kind), Some(NodeKind::State { .. }));
                    id = *operands[1..].iter().find(is_register)?;
                }
                _ => return None,
            }
        }
    }

    /// The module and port of a unit's output by the name of the design's input.
    pub fn unit_output<'a>(&'a self, input: &'a str) -> Option<(&'a str, &'a str, &'a str)> {
        let (instance, port) = input.rsplit_once('.')?;
        let module = self.units.get(instance)?;
        Some((instance, module, port.strip_suffix("_o")?))
    }
}

fn unexpected(found: &str, expected: &str) -> Error {
    ToolError::unexpected("yosys", found.to_string(), expected.to_string()).into()
}
