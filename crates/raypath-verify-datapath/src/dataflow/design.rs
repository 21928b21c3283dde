//! A design as Yosys reads it, in the format BTOR2 (Niemetz et al. 2018), and the units that were taken out of it.

use raypath_hdl::{Module, combinational_inputs, verilog};
use raypath_tools::ToolError;
use raypath_verify::Error;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

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

/// The ports of a unit, by name without the direction, with their widths, in the order of the names.
#[derive(Debug, Default, Clone)]
pub(super) struct UnitModule {
    pub inputs: Vec<(String, u32)>,
    pub outputs: Vec<(String, u32)>,
    /// The inputs that multipliers with registers read, which no other output follows from.
    pub factors: BTreeSet<String>,
    /// The outputs that these multipliers show, [`MULTIPLIER_CYCLES`] later.
    pub products: BTreeSet<String>,
}

/// The cycles of a multiplier with registers of its own: before and behind the product.
pub(super) const MULTIPLIER_CYCLES: u32 = 2;

impl UnitModule {
    /// The inputs that an output follows from.
    pub fn operands(&self, output: &str) -> impl Iterator<Item = &str> {
        let is_product = self.products.contains(output);
        let inputs = self.inputs.iter().map(|(name, _)| name.as_str());
        inputs.filter(move |name| self.factors.contains(*name) == is_product)
    }
}

/// What is read of a netlist in Yosys's JSON, which has a number for each bit of each cell.
#[derive(Deserialize)]
struct Netlist {
    modules: BTreeMap<String, ModuleOfNetlist>,
}

#[derive(Deserialize)]
struct ModuleOfNetlist {
    attributes: Attributes,
    ports: BTreeMap<String, PortOfNetlist>,
    cells: BTreeMap<String, CellOfNetlist>,
}

#[derive(Deserialize)]
struct Attributes {
    blackbox: Option<IgnoredAny>,
}

#[derive(Deserialize)]
struct PortOfNetlist {
    direction: String,
    bits: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
struct CellOfNetlist {
    #[serde(rename = "type")]
    kind: String,
}

impl Design {
    /// Reads a design from Yosys's files: BTOR2 without the units, and JSON of the flat design with them.
    pub fn read(btor: &str, json: &str, top: &Arc<Module>) -> Result<Self, Error> {
        let mut design = Self::default();
        let mut widths: HashMap<Id, u32> = HashMap::new();
        for line in btor.lines() {
            let line = line.split_once(';').map_or(line, |(code, _)| code);
            let words: Vec<&str> = line.split_whitespace().collect();
            if !words.is_empty() {
                design.add(&words, &mut widths).ok_or_else(|| unexpected(line, "a line of BTOR2"))?;
            }
        }
        design.add_units(json, top.name())?;
        design.add_multipliers(top)?;
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
        let Netlist { modules } =
            serde_json::from_str(json).map_err(|problem| unexpected(&problem.to_string(), "a netlist in JSON"))?;
        for (name, module) in modules.iter().filter(|(_, module)| module.attributes.blackbox.is_some()) {
            let mut unit = UnitModule::default();
            for (port, PortOfNetlist { direction, bits }) in module.ports.iter().filter(|(port, _)| *port != "clk_i") {
                let stem = port.rsplit_once('_').map_or(port.as_str(), |(stem, _)| stem).to_string();
                let side = if direction == "input" { &mut unit.inputs } else { &mut unit.outputs };
                side.push((stem, bits.len() as u32));
            }
            self.modules.insert(name.clone(), unit);
        }
        for (cell, CellOfNetlist { kind }) in
            modules.into_iter().filter(|(name, _)| name == top).flat_map(|(_, it)| it.cells)
        {
            if self.modules.contains_key(&kind) {
                self.units.insert(cell, kind);
            }
        }
        Ok(())
    }

    /// Adds which ports of the units below a module are those of multipliers with registers.
    fn add_multipliers(&mut self, top: &Arc<Module>) -> Result<(), Error> {
        for module in verilog::modules(top)?.iter().filter(|module| module.is_clocked()) {
            let Some(unit) = self.modules.get_mut(module.name()) else { continue };
            unit.factors = unit.inputs.iter().map(|(name, _)| name.clone()).collect();
            for port in module.outputs() {
                let inputs = combinational_inputs(module, &[&port.name])?;
                if inputs.is_empty() {
                    unit.products.insert(port.stem().to_string());
                }
                for input in module.inputs().iter().filter(|input| inputs.contains(&input.name.as_str())) {
                    unit.factors.remove(input.stem());
                }
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
