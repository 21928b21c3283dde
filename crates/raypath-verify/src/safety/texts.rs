//! The text of a design for the model checker, in which units and prepared steps have free outputs.

use crate::Error;
use raypath_hdl::Module;
use raypath_hdl::verilog::{self, Source};
use std::collections::HashMap;
use std::sync::Arc;

/// A deliberate fault: a text in a module, and its replacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextFault {
    /// The module's name.
    pub module: &'static str,
    /// The original text.
    pub from: &'static str,
    /// The faulty text.
    pub to: &'static str,
}

/// The modules of a datapath as text, with empty units.
#[derive(Debug, Clone)]
pub struct ModuleTexts {
    modules: Vec<(String, String)>,
}

impl ModuleTexts {
    /// Prints a datapath.
    ///
    /// # Errors
    /// It cannot be printed.
    pub fn new(top: &Arc<Module>) -> Result<Self, Error> {
        let modules = verilog::modules(top)?;
        let units = modules.iter().filter(|module| is_free(module.name()));
        let shells: HashMap<&str, String> = units.map(|unit| (unit.name(), shell(unit))).collect();
        let text = |source: Source| {
            let text = shells.get(source.name.as_str()).cloned().unwrap_or(source.text);
            (source.name, text)
        };
        Ok(Self { modules: verilog::sources(top, &[])?.into_iter().map(text).collect() })
    }

    /// The names and texts of modules that are written by hand.
    pub fn of(modules: impl IntoIterator<Item = (String, String)>) -> Self {
        Self { modules: modules.into_iter().collect() }
    }

    /// Inserts a fault. Returns false if its original text does not occur. The spaces that align lines do not count.
    pub fn insert(&mut self, fault: TextFault) -> bool {
        let Some((_, text)) = self.modules.iter_mut().find(|(name, _)| name == fault.module) else { return false };
        let (from, aligned) = (without_alignment(fault.from), without_alignment(text));
        let is_there = aligned.contains(&from);
        *text = aligned.replace(&from, fault.to);
        is_there
    }

    /// Replaces the text of a module, if it is there.
    pub fn replace(&mut self, name: &str, text: &str) {
        self.modules.iter_mut().filter(|(own, _)| own == name).for_each(|(_, own)| *own = text.to_string());
    }

    /// Inserts a text before the end of a module, if it is there.
    pub fn append(&mut self, name: &str, inside: &str) {
        for (_, text) in self.modules.iter_mut().filter(|(own, _)| own == name) {
            if let Some((head, _)) = text.rsplit_once("endmodule") {
                *text = format!("{head}{inside}\nendmodule\n");
            }
        }
    }

    /// A module with `inside` before its end, and the modules below it. There is no other text, so that equal modules
    /// of different datapaths have equal texts.
    pub fn with(&self, module: &str, inside: &str) -> String {
        let mut below = vec![module];
        let mut next = 0;
        while let Some(&name) = below.get(next) {
            next += 1;
            let Some((_, text)) = self.modules.iter().find(|(other, _)| other == name) else { continue };
            let is_new = |other: &&str| !below.contains(other) && text.contains(&format!("  {other} "));
            let new: Vec<&str> = self.modules.iter().map(|(name, _)| name.as_str()).filter(is_new).collect();
            below.extend(new);
        }
        let is_needed = |name: &str, text: &str| below.contains(&name) || text.contains("\nendpackage");
        let needed = self.modules.iter().filter(|(name, text)| is_needed(name, text)).cloned();
        let mut needed = Self { modules: needed.collect() };
        needed.append(module, inside);
        needed.modules.into_iter().map(|(_, text)| text).collect()
    }
}

/// Whether the outputs of a module are free in every cycle: a floating-point unit, a rounding to fewer bits, or what a
/// step of the traversal unit prepares.
fn is_free(module: &str) -> bool {
    module.starts_with("raypath_fp_") || module.starts_with("raypath_narrow_") || module == "raypath_unit_prepare"
}

/// A unit's ports without its logic.
fn shell(module: &Module) -> String {
    let port = |direction: &str, name: &str, width: u32| format!("{direction} logic [{}:0] {name}", width - 1);
    let clock = [("clk_i", module.is_clocked()), ("rst_ni", module.has_reset())];
    let clock = clock.iter().filter(|(_, there)| *there).map(|(name, _)| port("input", name, 1));
    let width = |port: &raypath_hdl::Port| module.signal(port.signal).width;
    let inputs = module.inputs().iter().map(|p| port("input", &p.name, width(p)));
    let outputs = module.outputs().iter().map(|p| port("output", &p.name, width(p)));
    let ports: Vec<String> = clock.chain(inputs).chain(outputs).collect();
    format!("(* blackbox *)\nmodule {} (\n  {}\n);\nendmodule\n", module.name(), ports.join(",\n  "))
}

/// Reset in the first cycle; later cycles are free to reset.
pub const RESET: &str = "  initial assume (!rst_ni);\n";

/// A text with one space in the place of several that are not at the beginning of a line.
fn without_alignment(text: &str) -> String {
    let (mut last, mut is_indent) = ('\n', true);
    let keeps = |next: &char| {
        is_indent = last == '\n' || (is_indent && last == ' ');
        std::mem::replace(&mut last, *next) != ' ' || *next != ' ' || is_indent
    };
    text.chars().filter(keeps).collect()
}
