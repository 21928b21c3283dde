//! Claims that two circuits with the same inputs give the same words, and the miters that would show them wrong.

use raypath_hdl::Module;
use raypath_hdl::verilog::text;
use raypath_tools::ToolError;
use raypath_verify::Error;
use raypath_verify::sat::{Miter, SOURCE};
use std::sync::Arc;

/// A claim that the wires `ours` and `expected` are equal wherever `valid` is 1.
#[derive(Debug, Clone, Default)]
pub struct Claim {
    /// Its name in messages.
    pub name: String,
    /// The text of the modules that it is about.
    pub unit: String,
    /// The texts of other modules.
    pub rest: String,
    /// The free inputs, with their widths.
    pub inputs: Vec<(String, u32)>,
    /// The bits of `ours` and `expected`.
    pub width: u32,
    /// SystemVerilog that drives `ours`, `expected` and `valid`.
    pub body: String,
    /// Options of Yosys's command `symfpu`, if the body has an instance of the module `symfpu`.
    pub reference: Option<String>,
    /// Whether both sides may be equal before any proof, because they are units of ours from one description.
    pub is_alike: bool,
    /// The deliberate fault that must refute the claim: a piece of the unit's text, which must occur exactly once, and
    /// its replacement. Like real defects, it shows for few operands: in a rounding, at the end of a range, or for
    /// zeros.
    pub fault: (&'static str, &'static str),
}

/// Fewer cells than the smallest reference has: several hundred, at (3,3). An empty reference would prove anything.
const MIN_CELLS: u32 = 100;

/// What begins the names of inputs for the first values of registers, on which a result need not depend.
const STATE: &str = "state_";

impl Claim {
    /// The miter, whose output is 1 for inputs for which the claim is wrong; with the deliberate fault or without it.
    ///
    /// # Errors
    /// The fault's text is not exactly once in the unit's.
    pub fn miter(&self, with_fault: bool) -> Result<Miter, Error> {
        let mut unit = self.unit.clone();
        if with_fault {
            let (from, to) = self.fault;
            let times = unit.matches(from).count();
            if times != 1 {
                let found = format!("{}: found '{from}' {times} times in the unit's text", self.name);
                let expected = "it once, as the place of the deliberate fault";
                return Err(ToolError::unexpected("raypath", found, expected).into());
            }
            unit = unit.replace(from, to);
        }
        let mut commands = Vec::new();
        if let Some(options) = &self.reference {
            commands.push(format!("symfpu {options}"));
            // Its assertions would become outputs.
            commands.push("chformal -remove".to_string());
            commands.push(format!("select -assert-min {MIN_CELLS} symfpu/c:*"));
        }
        commands.extend(["unit.sv", "rest.sv", "miter.sv"].map(|file| format!("read_verilog -sv {SOURCE}{file}")));
        commands.extend(["hierarchy -check -top miter", "proc"].map(String::from));
        if self.reference.is_some() {
            commands.push("select -assert-count 1 miter/t:symfpu".to_string());
        }
        for (input, _) in self.inputs.iter().filter(|(input, _)| !input.starts_with(STATE)) {
            commands.extend(["ours", "expected"].map(|side| depends(side, input)));
        }
        let inputs: Vec<String> =
            self.inputs.iter().map(|(name, width)| format!("input [{}:0] {name}", width - 1)).collect();
        let miter = format!(
            "module miter ({}, output differ);\nwire [{}:0] ours, expected; wire valid;\n{}\n\
             assign differ = valid && (ours != expected);\nendmodule\n",
            inputs.join(", "),
            self.width - 1,
            self.body
        );
        let sources = [("unit.sv", unit), ("rest.sv", self.rest.clone()), ("miter.sv", miter)];
        Ok(Miter {
            name: self.name.clone(),
            sources: sources.map(|(name, text)| (name.to_string(), text)).into(),
            commands,
            inputs: self.inputs.clone(),
        })
    }
}

/// The command that checks that a wire of the miter depends on another.
pub fn depends(wire: &str, on: &str) -> String {
    format!("select -assert-min 1 miter/w:{wire} %ci* miter/w:{on} %i")
}

/// The texts of modules.
pub fn texts<'a>(modules: impl IntoIterator<Item = &'a Arc<Module>>) -> Result<String, raypath_hdl::Error> {
    modules.into_iter().map(text).collect()
}

/// An instance of a module in a miter; `wire` gives what a port is connected to.
pub fn instance(module: &Module, name: &str, wire: impl Fn(&str) -> String) -> String {
    let ports = module.inputs().iter().chain(module.outputs());
    let connected: Vec<String> = ports.map(|port| format!(".{}({})", port.name, wire(&port.name))).collect();
    format!("{} {name} ({});\n", module.name(), connected.join(", "))
}
