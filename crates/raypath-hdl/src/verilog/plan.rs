//! Decides which signals have a name in the text, and which are part of an expression.

use super::entries::{self, Entry, Reader, Section, is_case};
use super::expression::{Expression, render, repetitions, slice_root};
use super::labels::Labels;
use super::structures::Structures;
use crate::netlist::{Driver, Module, SignalId};
use std::collections::{BTreeSet, HashSet};

/// The greatest lengths of a text inside another expression, as a register's next value, and at an instance's port.
const INSIDE: usize = 120;
const INSIDE_LEVELS: u32 = 5;
const NEXT: usize = 90;
const PORT: usize = 60;

/// The text of a signal in an expression that reads it.
#[derive(Debug, Clone)]
pub enum Rendering {
    /// Nothing reads it.
    Unread,
    /// Under its own name, its output port's, or one made for it.
    Name(String),
    /// As an expression.
    Inline(Expression),
}

/// The content of a module's text, without its layout.
pub struct Plan<'m> {
    module: &'m Module,
    operands: Vec<Vec<SignalId>>,
    sections: Vec<Section<'m>>,
    labels: Labels<'m>,
    uses: Vec<Uses<'m>>,
    renderings: Vec<Rendering>,
    structures: Structures,
    /// Signals that have no declaration of their own: ports, parts of structures, constants.
    undeclared: HashSet<SignalId>,
}

#[derive(Clone, Default)]
struct Uses<'m> {
    count: u32,
    /// One of its readers.
    reader: Option<Reader<'m>>,
}

/// The first reader of a signal without a name. If the signal gets a name, it is assigned before this reader.
#[derive(Clone)]
struct Owner {
    section: usize,
    entry: usize,
    /// The most descriptive name, if there is one.
    role: Option<String>,
    /// The named signal or port that it is a part of.
    whole: String,
}

impl<'m> Plan<'m> {
    /// Plans the text of a module.
    pub fn new(module: &'m Module) -> Self {
        let operands: Vec<Vec<SignalId>> = module.signals().iter().map(|signal| operands(&signal.driver)).collect();
        let mut sections = entries::sections(module, &operands);
        let mut uses = uses(module, &operands, &sections);
        // Signals that only banked registers read are not printed.
        while module.text().bank.is_some() && drop_unread(&mut sections, &uses) {
            uses = self::uses(module, &operands, &sections);
        }
        let mut names: HashSet<String> = module.names().collect();
        let is_wire = |id: SignalId| {
            let signal = module.signal(id);
            signal.name.is_some() && !matches!(signal.driver, Driver::Constant(_))
        };
        let labels = Labels::new(module, |id| is_wire(id) || uses[id.index()].count > 0, &mut names);
        let structures = Structures::new(module, |name| fresh(&mut names, name));
        let renderings = vec![Rendering::Unread; operands.len()];
        let undeclared = HashSet::new();
        let mut plan = Self { module, operands, sections, labels, uses, renderings, structures, undeclared };
        plan.render_named(&mut names);
        plan.render_unnamed(&mut names);
        plan
    }

    /// The module.
    pub fn module(&self) -> &'m Module {
        self.module
    }

    /// The text's sections.
    pub fn sections(&self) -> &[Section<'m>] {
        &self.sections
    }

    /// The labels that it uses.
    pub fn labels(&self) -> &Labels<'m> {
        &self.labels
    }

    /// The text of a signal for its readers.
    pub fn read(&self, id: SignalId) -> &str {
        match &self.renderings[id.index()] {
            Rendering::Unread => "",
            Rendering::Name(name) => name,
            Rendering::Inline(expression) => &expression.text,
        }
    }

    /// The expression that drives a signal.
    pub fn expression(&self, id: SignalId) -> String {
        render(self.module, &self.renderings, self.driven_by(id)).text
    }

    /// The signal itself, or the nameless signal whose only reader it is as an alias.
    pub fn driven_by(&self, id: SignalId) -> SignalId {
        match self.module.signal(id).driver {
            Driver::Alias(source) if self.is_renamed(source) => source,
            _ => id,
        }
    }

    /// Whether a signal takes the name of its only reader, an alias or an output port.
    pub fn is_renamed(&self, id: SignalId) -> bool {
        let Uses { count, reader } = &self.uses[id.index()];
        let by_alias = |reader: SignalId| matches!(self.module.signal(reader).driver, Driver::Alias(_));
        self.module.signal(id).name.is_none()
            && *count == 1
            && match reader {
                Some(Reader::Output(_)) => true,
                Some(Reader::Signal(reader)) => by_alias(*reader),
                _ => false,
            }
    }

    /// The structures of the text.
    pub fn structures(&self) -> &Structures {
        &self.structures
    }

    /// The name under which a signal has to be declared.
    pub fn declaration(&self, id: SignalId) -> Option<&str> {
        let is_port = matches!(self.module.signal(id).driver, Driver::Input) || self.is_renamed(id);
        let is_port = is_port || self.undeclared.contains(&id);
        match &self.renderings[id.index()] {
            Rendering::Name(name) if !is_port => Some(name),
            _ => None,
        }
    }

    /// The signals that an entry defines or reads by name.
    pub fn mentioned(&self, entry: &Entry<'m>) -> BTreeSet<SignalId> {
        let mut found: BTreeSet<SignalId> = entry.defines(self.module).into_iter().collect();
        let reads = entry.reads(self.module, &self.operands);
        let mut open: Vec<SignalId> = reads.into_iter().map(|(id, _)| id).collect();
        while let Some(id) = open.pop() {
            match self.renderings[id.index()] {
                Rendering::Name(_) if !self.is_renamed(id) => {
                    found.insert(id);
                }
                _ => open.extend(&self.operands[id.index()]),
            }
        }
        found
    }

    fn render_named(&mut self, names: &mut HashSet<String>) {
        for (index, signal) in self.module.signals().iter().enumerate() {
            let id = SignalId(index as u32);
            let Some(name) = &signal.name else { continue };
            let elsewhere = self.structures.member(id).map(str::to_string).or_else(|| self.port_shown(id));
            let elsewhere = elsewhere.or_else(|| self.labels.has(id).then(|| self.labels.read(name)));
            if let Some(name) = elsewhere {
                self.undeclared.insert(id);
                self.renderings[index] = Rendering::Name(name);
                continue;
            }
            self.renderings[index] = Rendering::Name(match signal.driver {
                Driver::Instance { instance, output } if self.uses[index].count == 0 => {
                    let name = self.module.instances()[instance].output_name(output);
                    fresh(names, &format!("unused_{name}"))
                }
                Driver::Memory { .. } if self.uses[index].count == 0 => fresh(names, &format!("unused_{name}")),
                _ => name.clone(),
            });
        }
    }

    /// The output port that is the only reader of an instance's output. The instance is connected to the port itself.
    fn port_shown(&self, id: SignalId) -> Option<String> {
        let Uses { count: 1, reader: Some(Reader::Output(port)) } = &self.uses[id.index()] else { return None };
        let signal = self.module.signal(id);
        let is_output = match signal.driver {
            Driver::Instance { instance, output } => {
                signal.name.as_deref() == Some(&self.module.instances()[instance].output_name(output))
            }
            Driver::Register(register) => {
                self.module.text().bank.as_ref().is_some_and(|bank| bank.registers.contains(&register))
            }
            _ => false,
        };
        is_output.then(|| self.module.outputs()[*port].name.clone())
    }

    /// Whether an output port is connected to an instance, so that nothing is assigned to it.
    pub fn is_connected(&self, output: usize) -> bool {
        let port = &self.module.outputs()[output];
        self.undeclared.contains(&port.signal) && self.read(port.signal) == port.name
    }

    fn render_unnamed(&mut self, names: &mut HashSet<String>) {
        let owners = self.owners();
        let mut needs_name = vec![false; self.renderings.len()];
        for (index, signal) in self.module.signals().iter().enumerate() {
            if let (true, Driver::Slice { source, low }) = (self.uses[index].count > 0, &signal.driver) {
                let (root, _) = slice_root(self.module, *source, *low);
                needs_name[root.index()] = !matches!(self.module.signal(root).driver, Driver::Constant(_));
            }
        }
        let mut assigned: Vec<(usize, usize, SignalId)> = Vec::new();
        for (index, owner) in owners.into_iter().enumerate() {
            let Some(owner) = owner else { continue };
            let id = SignalId(index as u32);
            if self.is_renamed(id) {
                self.renderings[index] = Rendering::Name(owner.whole);
                continue;
            }
            let expression = render(self.module, &self.renderings, id);
            self.renderings[index] = if !needs_name[index] && self.is_inline(id, &expression) {
                Rendering::Inline(expression)
            } else {
                assigned.push((owner.section, owner.entry, id));
                Rendering::Name(match self.module.signal(id).hint.as_ref().or(owner.role.as_ref()) {
                    Some(name) => fresh(names, name),
                    None => numbered(names, &owner.whole),
                })
            };
        }
        // From the last to the first, so that positions stay valid.
        assigned.sort_by_key(|&assignment| std::cmp::Reverse(assignment));
        for (section, entry, id) in assigned {
            let assignment = if is_case(self.module, id) { Entry::Cases(vec![id]) } else { Entry::Signal(id) };
            self.sections[section].entries.insert(entry, assignment);
        }
    }

    fn is_inline(&self, id: SignalId, expression: &Expression) -> bool {
        let signal = self.module.signal(id);
        if signal.comment.is_some() || is_case(self.module, id) {
            return false;
        }
        match signal.driver {
            Driver::Constant(_) | Driver::Slice { .. } | Driver::Alias(_) => return true,
            Driver::Not(_) if expression.depth == 0 => return true,
            _ => {}
        }
        let Uses { count: 1, reader } = &self.uses[id.index()] else { return false };
        match reader {
            Some(Reader::Next(_)) => expression.text.len() <= NEXT,
            Some(Reader::Port(..) | Reader::Memory(..)) => expression.text.len() <= PORT,
            _ => expression.text.len() <= INSIDE && expression.depth <= INSIDE_LEVELS,
        }
    }

    /// The owners of the signals without a name that have a reader.
    fn owners(&self) -> Vec<Option<Owner>> {
        let mut owners: Vec<Option<Owner>> = vec![None; self.renderings.len()];
        for (section, list) in self.sections.iter().enumerate() {
            for (entry, reading) in list.entries.iter().enumerate() {
                for (id, reader) in reading.reads(self.module, &self.operands) {
                    let (whole, role) = self.describe(reader);
                    let mut open = vec![(id, role)];
                    while let Some((id, role)) = open.pop() {
                        if self.module.signal(id).name.is_none() && owners[id.index()].is_none() {
                            owners[id.index()] = Some(Owner { section, entry, role, whole: whole.clone() });
                            open.extend(self.operands[id.index()].iter().map(|&operand| (operand, None)));
                        }
                    }
                }
            }
        }
        owners
    }

    /// The reader's name, and the suffix for the signal that it reads.
    fn describe(&self, reader: Reader<'_>) -> (String, Option<String>) {
        let register = |index: usize| {
            let name = self.module.signal(self.module.registers()[index].signal).name.as_deref();
            stem(name.unwrap_or_default(), "_q").to_string()
        };
        match reader {
            Reader::Signal(id) => (self.module.signal(id).name.clone().unwrap_or_default(), None),
            Reader::Next(index) => (register(index), Some(format!("{}_d", register(index)))),
            Reader::Enable(index) => (register(index), Some(format!("{}_en", register(index)))),
            Reader::Port(instance, input) => {
                let instance = &self.module.instances()[instance];
                (instance.stem().to_string(), Some(instance.input_name(input)))
            }
            Reader::Memory(memory, input) => {
                let memory = &self.module.memories()[memory];
                (memory.stem().to_string(), Some(format!("{}_{}", memory.stem(), memory.input_name(input))))
            }
            Reader::Unused(name) => (name.to_string(), None),
            Reader::Bank(name, port) => (name.to_string(), Some(stem(port, "_i").to_string())),
            Reader::Output(port) => {
                let name = &self.module.outputs()[port].name;
                (name.clone(), Some(stem(name, "_o").to_string()))
            }
        }
    }
}

/// The operands of a driver as printed: a repeated part of a concatenation once, and a value of several arms of a case
/// once.
fn operands(driver: &Driver) -> Vec<SignalId> {
    match driver {
        Driver::Concat(parts) => repetitions(parts).into_iter().map(|(part, _)| part).collect(),
        Driver::Case { .. } => {
            let mut found = Vec::new();
            driver.operands().for_each(|id| {
                if !found.contains(&id) {
                    found.push(id)
                }
            });
            found
        }
        _ => driver.operands().collect(),
    }
}

/// Removes assignments of signals without a reader. Returns whether there were any.
fn drop_unread(sections: &mut [Section<'_>], uses: &[Uses<'_>]) -> bool {
    let mut found = false;
    for section in sections {
        section.entries.retain(|entry| {
            let ids: &[SignalId] = match entry {
                Entry::Signal(id) => std::slice::from_ref(id),
                Entry::Cases(ids) => ids,
                _ => return true,
            };
            let is_read = ids.iter().any(|id| uses[id.index()].count > 0);
            found |= !is_read;
            is_read
        });
    }
    found
}

/// Counts the readers that are printed. Signals follow their operands, so the count runs backwards and meets every
/// reader before its operands.
fn uses<'m>(module: &'m Module, operands: &[Vec<SignalId>], sections: &[Section<'m>]) -> Vec<Uses<'m>> {
    let mut uses = vec![Uses::default(); operands.len()];
    let note = |uses: &mut Vec<Uses<'m>>, id: SignalId, reader| {
        uses[id.index()].count += 1;
        uses[id.index()].reader = Some(reader);
    };
    for (id, reader) in
        sections.iter().flat_map(|section| &section.entries).flat_map(|entry| entry.reads(module, operands))
    {
        note(&mut uses, id, reader);
    }
    for (index, signal) in module.signals().iter().enumerate().rev() {
        if signal.name.is_none() && uses[index].count > 0 {
            for &operand in &operands[index] {
                note(&mut uses, operand, Reader::Signal(SignalId(index as u32)));
            }
        }
    }
    uses
}

/// Reserves and returns `name`, or `name_2` and so on if it is taken.
fn fresh(names: &mut HashSet<String>, name: &str) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    first_free(names, std::iter::once(name.to_string()).chain(numbered))
}

/// Reserves and returns the first free name of `whole_t1`, `whole_t2` and so on.
fn numbered(names: &mut HashSet<String>, whole: &str) -> String {
    let whole = stem(whole, "_o");
    first_free(names, (1..).map(|number| format!("{whole}_t{number}")))
}

/// Reserves and returns the first candidate that is valid and free. Joined names may have two underscores in a row,
/// which are not valid.
fn first_free(names: &mut HashSet<String>, candidates: impl Iterator<Item = String>) -> String {
    let single = |mut name: String| {
        while name.contains("__") {
            name = name.replace("__", "_");
        }
        name
    };
    let mut candidates = candidates.map(single);
    let is_free = |name: &String| crate::names::problem(name).is_none() && names.insert(name.clone());
    candidates.find(is_free).unwrap_or_default()
}

fn stem<'a>(name: &'a str, suffix: &str) -> &'a str {
    name.strip_suffix(suffix).unwrap_or(name)
}
