//! Lemmas: statements about some signals of a module's text, for any values of others, proved by SAT.
//!
//! Yosys cuts the signals that a lemma takes from their drivers (`expose -input`), so that they may have any value, and
//! makes outputs of those that it gives. What is proved for any values holds for those that the drivers give: a proved
//! lemma is true of the whole module, whatever was cut.

use super::claim::depends;
use raypath_tools::ToolError;
use raypath_verify::Error;
use raypath_verify::sat::{Miter, SOURCE};
use std::collections::BTreeMap;

/// A signal of a module, or an input of a miter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signal {
    /// Its name in the text.
    pub name: String,
    /// Its bits.
    pub width: u32,
}

impl Signal {
    /// A signal with this name and width.
    pub fn new(name: &str, width: u32) -> Self {
        Self { name: name.to_string(), width }
    }

    fn declaration(&self) -> String {
        format!("[{}:0] {}", self.width - 1, self.name)
    }
}

/// The text of a module, with the widths of its signals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Text {
    /// The module's name.
    pub module: String,
    text: String,
    widths: BTreeMap<String, u32>,
}

impl Text {
    /// The text of a module as `generate` writes it.
    pub fn new(module: &str, text: String) -> Self {
        let widths = text.lines().filter_map(declared).collect();
        Self { module: module.to_string(), text, widths }
    }

    /// A declared signal.
    ///
    /// # Errors
    /// The text does not declare it.
    pub fn signal(&self, name: &str) -> Result<Signal, Error> {
        let width = self.widths.get(name).copied();
        let width = width.ok_or_else(|| self.unexpected(&format!("no signal {name}"), "it declared"))?;
        Ok(Signal::new(name, width))
    }

    /// The names of the input ports.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.ports("input")
    }

    /// The names of the output ports.
    pub fn outputs(&self) -> impl Iterator<Item = &str> {
        self.ports("output")
    }

    fn ports(&self, direction: &'static str) -> impl Iterator<Item = &str> {
        let lines = self.text.lines().map(str::trim).filter(move |line| line.starts_with(direction));
        lines.filter_map(|line| line.trim_end_matches(',').split_whitespace().last())
    }

    /// The text with the first of the faults that it has a place for.
    fn with(&self, faults: &[Fault]) -> Result<String, Error> {
        let changed = faults.iter().find_map(|fault| fault.apply(&self.text));
        changed.ok_or_else(|| self.unexpected(&format!("none of {faults:?}"), "the place of a deliberate fault"))
    }

    fn unexpected(&self, found: &str, expected: &str) -> Error {
        ToolError::unexpected("raypath", format!("{}: found {found}", self.module), expected).into()
    }
}

/// The name and width in a line such as `  logic [9:0] exponent_sum;` or `  input  logic [32:0] a_i,`.
fn declared(line: &str) -> Option<(String, u32)> {
    let words: Vec<&str> = line.trim().trim_end_matches([',', ';']).split_whitespace().collect();
    let (width, name) = match words[..] {
        ["logic", name] | ["input" | "output", "logic", name] => (1, name),
        ["logic", range, name] | ["input" | "output", "logic", range, name] => {
            (range.strip_prefix('[')?.strip_suffix(":0]")?.parse::<u32>().ok()? + 1, name)
        }
        _ => return None,
    };
    Some((name.to_string(), width))
}

/// A deliberate fault: in the driver of a signal, the first occurrence of a piece of text is replaced.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The signal.
    pub signal: String,
    /// The piece of its driver.
    pub from: &'static str,
    /// What replaces it.
    pub to: &'static str,
}

impl Fault {
    /// A fault in the driver of a signal.
    pub fn new(signal: impl Into<String>, from: &'static str, to: &'static str) -> Self {
        Self { signal: signal.into(), from, to }
    }

    /// The changed text; none if it has no such place.
    fn apply(&self, text: &str) -> Option<String> {
        let begin = text.find(&format!("assign {} ", self.signal))?;
        let end = begin + text[begin..].find(';')?;
        let driver = &text[begin..end];
        let place = driver.find('=')? + 1;
        let place = place + driver[place..].find(self.from)?;
        let (before, after) = (&text[..begin + place], &text[begin + place + self.from.len()..]);
        Some(format!("{before}{}{after}", self.to))
    }
}

/// A statement about signals of a module, for all values of the cut signals and of the free inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lemma {
    /// What it states, for messages.
    pub name: String,
    /// The module.
    pub unit: Text,
    /// Input ports of the module, and signals that are cut from their drivers.
    pub takes: Vec<Signal>,
    /// The signals of which the lemma states something.
    pub gives: Vec<Signal>,
    /// The free inputs of the miter. Signals that the lemma takes and that are not among them are driven by the
    /// statement.
    pub free: Vec<Signal>,
    /// Commands that create the reference, and the texts of further modules.
    pub reference: Vec<String>,
    /// SystemVerilog that drives `differ`, which is 1 where the statement is wrong.
    pub statement: String,
    /// Texts of modules that the statement instantiates.
    pub rest: String,
    /// Faults of which the first with a place in the text must refute the lemma.
    pub faults: Vec<Fault>,
}

impl Lemma {
    /// The circuit whose output is 1 where the lemma is wrong, for the module or for the one with its fault.
    ///
    /// # Errors
    /// The text has no place for the fault.
    pub fn miter(&self, theorem: &str, with_fault: bool) -> Result<Miter, Error> {
        let module = &self.unit.module;
        let unit = if with_fault { self.unit.with(&self.faults)? } else { self.unit.text.clone() };
        let mut commands = self.reference.clone();
        commands.push(format!("read_verilog -sv {SOURCE}unit.sv"));
        for (option, signals) in [("-input ", &self.takes), ("", &self.gives)] {
            let names: Vec<String> = signals.iter().map(|signal| format!("{module}/w:{}", signal.name)).collect();
            commands.push(format!("select -assert-count {} {}", names.len(), names.join(" ")));
            commands.push(format!("expose {option}{}", names.join(" ")));
        }
        commands.extend(["rest.sv", "miter.sv"].map(|file| format!("read_verilog -sv {SOURCE}{file}")));
        commands.extend(["hierarchy -check -top miter", "proc"].map(String::from));
        commands.extend(self.gives.iter().chain(&self.takes).map(|signal| depends("differ", &signal.name)));
        // Without what the lemma does not need, the conversion to gates is faster.
        commands.extend(["flatten", "opt_clean"].map(String::from));
        let sources = [("unit.sv", unit), ("rest.sv", self.rest.clone()), ("miter.sv", self.text())];
        Ok(Miter {
            name: format!("{theorem}: {}", self.name),
            sources: sources.map(|(name, text)| (name.to_string(), text)).into(),
            commands,
            inputs: self.free.iter().map(|input| (input.name.clone(), input.width)).collect(),
        })
    }

    /// The text of the miter.
    fn text(&self) -> String {
        let inputs: Vec<String> = self.free.iter().map(|input| format!("input {}", input.declaration())).collect();
        let driven = self.takes.iter().filter(|signal| !self.free.contains(signal));
        let wires: String =
            driven.chain(&self.gives).map(|signal| format!("wire {};\n", signal.declaration())).collect();
        let connected = self.takes.iter().chain(&self.gives).map(|signal| format!(".{0}({0})", signal.name));
        format!(
            "module miter ({}, output differ);\n{wires}{} u_unit ({});\n{}\nendmodule\n",
            inputs.join(", "),
            self.unit.module,
            connected.collect::<Vec<_>>().join(", "),
            self.statement,
        )
    }
}

/// Checks that each signal that a lemma about the module takes is an input or was given by a lemma before, that each is
/// given once, and that the last lemma gives the outputs.
pub fn is_chain(lemmas: &[Lemma], text: &Text) -> Result<(), String> {
    let mut given: Vec<&str> = text.inputs().collect();
    for lemma in lemmas.iter().filter(|lemma| lemma.unit == *text) {
        if let Some(unknown) = lemma.takes.iter().find(|signal| !given.contains(&signal.name.as_str())) {
            return Err(format!("{} takes {}, which no lemma gives", lemma.name, unknown.name));
        }
        if let Some(twice) = lemma.gives.iter().find(|signal| given.contains(&signal.name.as_str())) {
            return Err(format!("{} gives {} again", lemma.name, twice.name));
        }
        given.extend(lemma.gives.iter().map(|signal| signal.name.as_str()));
    }
    match text.outputs().find(|output| !given.contains(output)) {
        Some(output) => Err(format!("no lemma gives {output}")),
        None => Ok(()),
    }
}
