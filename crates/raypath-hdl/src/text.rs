//! Differences between the printed text of a module and its netlist.
//!
//! The netlist has words of at most 64 bits, and a module for every set of ports. The text groups ports into packed
//! structures, which a package declares, and holds registers of all widths in one module with a parameter.

use crate::Error;
use crate::netlist::{Label, Module, Signal, SignalId, changed};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Declarations that the modules of a design share. They are printed before the modules.
#[derive(Debug, Clone, PartialEq)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// The lines of its head comment.
    pub doc: Vec<String>,
    /// Names for the values of words, such as opcodes, and for bits of words.
    pub enumerations: Vec<Enumeration>,
    /// Packed structures; a structure comes after those that it contains.
    pub structures: Vec<Structure>,
}

/// An enumeration. Cases that use its labels refer to the package; they declare no labels of their own. A constant with
/// the name of a label as its [hint](crate::Wire::hint) is printed by that name, and so is the place of one bit of a
/// word: of that label's value.
#[derive(Debug, Clone, PartialEq)]
pub struct Enumeration {
    /// The name of its type.
    pub name: String,
    /// The comment above it.
    pub doc: Option<String>,
    /// Its width in bits.
    pub width: u32,
    /// Names and values.
    pub labels: Vec<Label>,
}

/// A packed structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// The name of its type.
    pub name: String,
    /// The comment above it.
    pub doc: Option<String>,
    /// Types and names of its fields, the most significant first.
    pub fields: Vec<(String, String)>,
}

/// Ports that are printed as one port of a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct PortGroup {
    /// The port's name: `data_i`.
    pub name: String,
    /// The structure's type: `raypath_pkg::stage_2_t`.
    pub structure: String,
    /// Names of ports and what selects each in the structure, such as `.num[3]`; the most significant first.
    pub members: Vec<(String, String)>,
}

/// An input port that the module reads as an enumeration. The text converts it through a structure with one field,
/// because a cast to a type of a package is beyond Yosys 0.23.
#[derive(Debug, Clone, PartialEq)]
pub struct EnumeratedInput {
    /// The port.
    pub port: String,
    /// The name of the structure's variable.
    pub variable: String,
    /// The structure's type.
    pub structure: String,
    /// Its field.
    pub field: String,
}

/// Registers that are printed in an instance of another module. The netlist has them in the module itself.
#[derive(Debug, Clone)]
pub struct Bank {
    /// The instance's name.
    pub name: String,
    /// The module that the text instantiates, with the ports `data_i` and `data_o` of [`PAYLOAD`] bits.
    pub module: Arc<Module>,
    /// The position of the instance in the netlist that it replaces, which has the same name.
    pub replaces: Option<usize>,
    /// The registers in it, by position in [`Module::registers`].
    pub registers: Vec<usize>,
    /// Its other ports and the signals at them.
    pub ports: Vec<(String, SignalId)>,
    /// The signals that it stores, in the order of the members of `output`.
    pub next: Vec<SignalId>,
    /// The output ports that show the stored values.
    pub output: PortGroup,
}

/// A text with parameters that many modules have: they differ in the values of the parameters. Instances are of this
/// text; where a module is printed by itself, its text is that of its netlist.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    /// The name of the module in the text.
    pub module: String,
    /// The comment at its head.
    pub doc: String,
    /// Its text, from `module` on.
    pub text: String,
    /// Parameters, and their values for this module.
    pub parameters: Vec<(&'static str, u32)>,
    /// The ports of the text besides clock and reset, and the ports of the netlist that are at each, the most
    /// significant first.
    pub ports: Vec<(String, Vec<String>)>,
}

/// The width that stands for the parameter `Width` in the text of a module with [`Text::has_width_parameter`]. Names of
/// signals of this width begin with `data` or `tag` there.
pub const PAYLOAD: u32 = 64;

/// A port of a text: of a module or of several of its ports as one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextPort {
    /// Its name.
    pub name: String,
    /// Its width in bits.
    pub width: u32,
    /// Whether it is an input.
    pub is_input: bool,
}

/// How a module is printed. By default, ports and registers are printed as they are in the netlist.
#[derive(Debug, Clone, Default)]
pub struct Text {
    /// The declarations that it refers to.
    pub package: Option<Arc<Package>>,
    /// Input ports in structures.
    pub inputs: Vec<PortGroup>,
    /// An input port as an enumeration.
    pub enumerated: Option<EnumeratedInput>,
    /// Registers that are printed in another module, and output ports in a structure.
    pub bank: Option<Bank>,
    /// Output ports in a structure, in a module without a bank.
    pub output: Option<PortGroup>,
    /// The ports whose names begin so, under a comment each.
    pub channels: Vec<(String, String)>,
    /// The text that instances have.
    pub template: Option<Template>,
    /// Its own text, from `module` on, in place of that of its netlist, and the name, the comment and the text of modules
    /// that it instantiates and the netlist does not have, in the order of compilation.
    pub verbatim: Option<(String, Vec<[String; 3]>)>,
    /// Whether the text has a parameter `Width` instead of words of [`PAYLOAD`] bits.
    pub has_width_parameter: bool,
}

/// `module` and all below it, printed as they are in the netlist: ports and registers of words, without a package and
/// its structures, for tools that do not read types of packages, such as Icarus Verilog 11. It behaves the same.
pub fn plain(module: &Arc<Module>) -> Arc<Module> {
    changed(module, |module| module.text = Text::default())
}

/// The same module with a text of its own, from `module` on. Its netlist must be what the text is with the defaults of its
/// parameters. `below` has the name, the comment and the text of modules that the text instantiates besides those of the
/// netlist.
pub fn verbatim(module: &Module, text: String, below: Vec<[String; 3]>) -> Arc<Module> {
    let mut module = module.clone();
    module.text.verbatim = Some((text, below));
    Arc::new(module)
}

/// The same module, where it and those below have these texts by their names ([`verbatim`]), or by those of their
/// templates. Those that refer to a package of this name refer to this one.
pub fn with_texts(module: &Arc<Module>, texts: &BTreeMap<String, String>, package: &Arc<Package>) -> Arc<Module> {
    changed(module, |module| {
        let of_name = module.text.package.as_mut().filter(|known| known.name == package.name);
        of_name.into_iter().for_each(|known| known.clone_from(package));
        if let Some(text) = texts.get(&module.name) {
            module.text.verbatim = Some((text.clone(), Vec::new()));
        }
        if let Some(template) = &mut module.text.template {
            texts.get(&template.module).into_iter().for_each(|text| template.text.clone_from(text));
        }
    })
}

impl Package {
    /// The name by which modules refer to a label, if the package has it.
    pub(crate) fn label(&self, name: &str) -> Option<String> {
        self.enumeration_of(name).map(|_| format!("{}::{name}", self.name))
    }

    /// The enumeration that has a label.
    pub(crate) fn enumeration_of(&self, name: &str) -> Option<&Enumeration> {
        self.enumerations.iter().find(|enumeration| enumeration.value(name).is_some())
    }
}

impl Enumeration {
    fn value(&self, name: &str) -> Option<u64> {
        self.labels.iter().find(|label| label.name == name).map(|label| label.value)
    }
}

impl Text {
    /// The structure of output ports.
    pub(crate) fn output(&self) -> Option<&PortGroup> {
        self.bank.as_ref().map(|bank| &bank.output).or(self.output.as_ref())
    }
}

impl TextPort {
    /// Its name without the usual suffix of its direction.
    pub fn stem(&self) -> &str {
        stem(&self.name)
    }
}

/// The name of a port without the suffix of its direction.
fn stem(name: &str) -> &str {
    name.strip_suffix("_i").or_else(|| name.strip_suffix("_o")).unwrap_or(name)
}

impl PortGroup {
    /// Its name without the suffix of its direction.
    pub(crate) fn stem(&self) -> &str {
        stem(&self.name)
    }

    /// Whether this port is a member.
    pub fn contains(&self, port: &str) -> bool {
        self.select(port).is_some()
    }

    /// Whether this port is the first member: the text has the group in its place.
    pub(crate) fn begins_with(&self, port: &str) -> bool {
        self.members[0].0 == port
    }

    /// What selects a port in the structure.
    pub fn select(&self, port: &str) -> Option<&str> {
        self.members.iter().find(|(name, _)| name == port).map(|(_, select)| select.as_str())
    }
}

impl Bank {
    /// Whether this port of its module is an input.
    pub(crate) fn is_input(&self, port: &str) -> bool {
        self.module.inputs().iter().any(|input| input.name == port)
    }
}

impl Module {
    /// How it is printed.
    pub fn text(&self) -> &Text {
        &self.text
    }

    /// The label of the package that a signal has as its hint, if the label has this value and, of a constant, this
    /// width.
    pub(crate) fn hinted_label(&self, signal: &Signal, value: u64, width: Option<u32>) -> Option<String> {
        let (package, name) = (self.text.package.as_ref()?, signal.hint.as_ref()?);
        let enumeration = package.enumeration_of(name)?;
        let fits = enumeration.value(name) == Some(value) && width.is_none_or(|width| width == enumeration.width);
        fits.then(|| format!("{}::{name}", package.name))
    }

    /// How its text refers to one of its ports: `data_i.num[3]` for a port in a structure, otherwise its name.
    pub fn port_text(&self, port: &str) -> String {
        let groups = self.text.inputs.iter().chain(self.text.output());
        let mut found = groups.filter_map(|group| group.select(port).map(|select| format!("{}{select}", group.name)));
        found.next().unwrap_or_else(|| port.to_string())
    }

    /// The ports of its text besides clock and reset, the inputs first.
    pub fn text_ports(&self) -> Vec<TextPort> {
        let mut ports: Vec<TextPort> = Vec::new();
        for (is_input, list) in [(true, &self.inputs), (false, &self.outputs)] {
            for port in list {
                let (text, width) = (self.port_text(&port.name), self.signal(port.signal).width);
                let name = text.split(['[', '.']).next().unwrap_or_default();
                match ports.iter_mut().find(|known| known.name == name) {
                    Some(known) => known.width += width,
                    None => ports.push(TextPort { name: name.to_string(), width, is_input }),
                }
            }
        }
        ports
    }

    /// An error where the text would print another signal than the payload with the width of the payload.
    pub(crate) fn expect_payload_only(&self) -> Result<(), Error> {
        let is_payload = |name: &String| name.starts_with("data") || name.starts_with("tag");
        let other = |signal: &Signal| signal.name.clone().filter(|name| signal.width == PAYLOAD && !is_payload(name));
        match self.signals.iter().find_map(other).filter(|_| self.text.has_width_parameter) {
            None => Ok(()),
            Some(signal) => {
                let problem = format!("{PAYLOAD} bits stand for the parameter Width, expected fewer");
                Err(Error::Width { module: self.name.clone(), signal, problem })
            }
        }
    }

    /// The width in bits of what its text stores in another module; 0 if it stores nothing there.
    pub fn bank_width(&self) -> u32 {
        let members = self.text.bank.iter().flat_map(|bank| &bank.output.members);
        members.filter_map(|(port, _)| self.port_width(port)).sum()
    }

    /// The registers that its text holds in another module: the name there, as in `u_skid.data_q`, and the names and
    /// widths of the registers, the most significant first.
    pub fn banked_registers(&self) -> Vec<(String, Vec<(String, u32)>)> {
        let Some(bank) = &self.text.bank else { return Vec::new() };
        let words = bank.module.registers().iter().filter_map(|register| {
            let word = bank.module.signal(register.signal);
            word.name.as_ref().map(|name| (name, word.width))
        });
        words
            // If the netlist has the control in an instance of this name, its registers have equal names.
            .filter(|(_, width)| *width == PAYLOAD || bank.replaces.is_none())
            .map(|(word, width)| {
                if width != PAYLOAD {
                    return (format!("{}.{word}", bank.name), vec![(word.clone(), width)]);
                }
                let suffix = word.strip_prefix("data").unwrap_or(word);
                let member = |(port, _): &(String, String)| {
                    let stem = port.strip_suffix("_o").unwrap_or(port);
                    (format!("{stem}{suffix}"), self.port_width(port).unwrap_or(0))
                };
                (format!("{}.{word}", bank.name), bank.output.members.iter().map(member).collect())
            })
            .collect()
    }
}
