//! The sections of a module's text and their statements, in order.

use crate::netlist::{Driver, Item, Label, Module, SignalId};
use crate::text::Bank;
use std::collections::HashSet;

/// A section of the text.
pub struct Section<'m> {
    /// The comment over it.
    pub title: Option<&'m str>,
    /// Its statements; registers last.
    pub entries: Vec<Entry<'m>>,
}

/// A statement.
#[derive(Clone)]
pub enum Entry<'m> {
    /// The assignment of a signal.
    Signal(SignalId),
    /// Cases with one selector and the same labels, in one block.
    Cases(Vec<SignalId>),
    /// An instance.
    Instance(usize),
    /// A memory.
    Memory(usize),
    /// Registers with one enable or gated clock, with or without reset, in one block.
    Registers(Vec<usize>),
    /// Signals without a reader, and their common name.
    Unused(&'m str, &'m [SignalId]),
    /// The values that a bank of registers stores, and its instance.
    Bank(&'m Bank, Vec<Entry<'m>>),
    /// The assignment of an output port.
    Output(usize),
}

/// Where a signal is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reader<'m> {
    /// In the expression that drives another.
    Signal(SignalId),
    /// As the next value of a register.
    Next(usize),
    /// As the enable of this and perhaps other registers.
    Enable(usize),
    /// At an instance's input.
    Port(usize, usize),
    /// At an input of a memory.
    Memory(usize, usize),
    /// In the signal of this name, which marks it as unused.
    Unused(&'m str),
    /// At a bank of registers: its instance, and the port.
    Bank(&'m str, &'m str),
    /// At an output port.
    Output(usize),
}

/// The sections of a module; `operands` are those of each of its signals.
pub fn sections<'m>(module: &'m Module, operands: &[Vec<SignalId>]) -> Vec<Section<'m>> {
    let mut sections = vec![Section { title: None, entries: Vec::new() }];
    let mut registers: Vec<Entry<'m>> = Vec::new();
    let bank = module.text.bank.as_ref();
    let mut open_bank = bank;
    for item in module.items() {
        let last = sections.len() - 1;
        let entries = &mut sections[last].entries;
        match item {
            Item::Section(title) => {
                entries.append(&mut registers);
                sections.push(Section { title: Some(title), entries: Vec::new() });
            }
            Item::Signal(id) if bank.is_some_and(|bank| bank.next.contains(id)) => {}
            Item::Signal(id) => add_signal(module, operands, entries, *id),
            Item::Instance(instance) if bank.is_some_and(|bank| bank.replaces == Some(*instance)) => {
                entries.extend(open_bank.take().map(|bank| bank_entry(module, operands, bank)));
            }
            Item::Instance(instance) => entries.push(Entry::Instance(*instance)),
            Item::Memory(memory) => entries.push(Entry::Memory(*memory)),
            Item::Register(register) if bank.is_some_and(|bank| bank.registers.contains(register)) => {
                entries.extend(open_bank.take().map(|bank| bank_entry(module, operands, bank)));
            }
            Item::Register(register) => add_register(module, &mut registers, *register),
            Item::Unused(name, signals) => entries.push(Entry::Unused(name, signals)),
            Item::Parameter(..) => {}
        }
    }
    if let Some(last) = sections.last_mut() {
        last.entries.append(&mut registers);
    }
    let is_banked = |port: &str| bank.is_some_and(|bank| bank.output.contains(port));
    let outputs = (0..module.outputs().len()).filter(|&port| !is_banked(&module.outputs()[port].name));
    let title = (sections.len() > 1).then_some("Outputs");
    sections.push(Section { title, entries: outputs.map(Entry::Output).collect() });
    sections
}

fn add_signal<'m>(module: &'m Module, operands: &[Vec<SignalId>], entries: &mut Vec<Entry<'m>>, id: SignalId) {
    if !is_case(module, id) {
        return entries.push(Entry::Signal(id));
    }
    match entries.last_mut() {
        Some(Entry::Cases(group)) if belongs(module, operands, group, id) => group.push(id),
        _ => entries.push(Entry::Cases(vec![id])),
    }
}

/// Assignments first, then cases: all of them are in one block.
fn bank_entry<'m>(module: &'m Module, operands: &[Vec<SignalId>], bank: &'m Bank) -> Entry<'m> {
    let (cases, others): (Vec<SignalId>, Vec<SignalId>) = bank.next.iter().partition(|&&id| is_case(module, id));
    let mut entries: Vec<Entry<'m>> = others.into_iter().map(Entry::Signal).collect();
    for id in cases {
        let of_same_labels = entries.iter_mut().find_map(|entry| match entry {
            Entry::Cases(group) if belongs(module, operands, group, id) => Some(group),
            _ => None,
        });
        match of_same_labels {
            Some(group) => group.push(id),
            None => entries.push(Entry::Cases(vec![id])),
        }
    }
    Entry::Bank(bank, entries)
}

/// Whether a case drives the signal.
pub fn is_case(module: &Module, id: SignalId) -> bool {
    matches!(module.signal(id).driver, Driver::Case { .. })
}

impl<'m> Entry<'m> {
    /// The signals that it reads. An operand that a block prints once is listed once.
    pub fn reads(&self, module: &'m Module, operands: &[Vec<SignalId>]) -> Vec<(SignalId, Reader<'m>)> {
        let of = |id: SignalId| operands[id.index()].iter().map(move |&operand| (operand, Reader::Signal(id)));
        match self {
            Self::Signal(id) => of(*id).collect(),
            Self::Cases(group) => {
                let rest = group[1..].iter().flat_map(|&id| of(id).skip(1));
                of(group[0]).chain(rest).collect()
            }
            Self::Instance(instance) => {
                let inputs = module.instances()[*instance].inputs.iter().enumerate();
                inputs.map(|(input, &id)| (id, Reader::Port(*instance, input))).collect()
            }
            Self::Memory(memory) => {
                let inputs = module.memories()[*memory].inputs().into_iter().enumerate();
                inputs.map(|(input, &id)| (id, Reader::Memory(*memory, input))).collect()
            }
            Self::Registers(group) => {
                let enable = module.registers()[group[0]].enable.map(|id| (id, Reader::Enable(group[0])));
                let next = group.iter().map(|&register| (module.registers()[register].next, Reader::Next(register)));
                enable.into_iter().chain(next).collect()
            }
            Self::Unused(name, ids) => ids.iter().map(|&id| (id, Reader::Unused(name))).collect(),
            Self::Output(port) => vec![(module.outputs()[*port].signal, Reader::Output(*port))],
            Self::Bank(bank, next) => {
                let inputs = bank.ports.iter().filter(|(port, _)| bank.is_input(port));
                let inputs = inputs.map(|(port, id)| (*id, Reader::Bank(&bank.name, port)));
                next.iter().flat_map(|entry| entry.reads(module, operands)).chain(inputs).collect()
            }
        }
    }

    /// The signals that it drives, if they are not ports.
    pub fn defines(&self, module: &Module) -> Vec<SignalId> {
        match self {
            Self::Signal(id) => vec![*id],
            Self::Cases(group) => group.clone(),
            Self::Instance(instance) => module.instances()[*instance].outputs.clone(),
            Self::Memory(memory) => module.memories()[*memory].columns.iter().map(|column| column.read).collect(),
            Self::Registers(group) => group.iter().map(|&register| module.registers()[register].signal).collect(),
            Self::Unused(..) | Self::Output(_) => Vec::new(),
            Self::Bank(bank, _) => {
                let outputs = bank.ports.iter().filter(|(port, _)| !bank.is_input(port));
                outputs.map(|(_, id)| *id).collect()
            }
        }
    }
}

fn add_register(module: &Module, blocks: &mut Vec<Entry<'_>>, register: usize) {
    let kind = |register: usize| {
        let info = &module.registers()[register];
        (info.enable, info.gated, info.reset.is_some())
    };
    for block in blocks.iter_mut() {
        if let Entry::Registers(group) = block
            && kind(group[0]) == kind(register)
        {
            return group.push(register);
        }
    }
    blocks.push(Entry::Registers(vec![register]));
}

/// Whether a case may join a block: selector and labels are the same, and within this module it depends on no case of
/// the block, and none of them on it. A tool that takes the block as a whole would report a combinational loop.
fn belongs(module: &Module, operands: &[Vec<SignalId>], group: &[SignalId], new: SignalId) -> bool {
    alternatives(module, group[0]) == alternatives(module, new)
        && !reaches(module, operands, &[new], group)
        && !reaches(module, operands, group, &[new])
}

fn alternatives(module: &Module, id: SignalId) -> Option<(SignalId, Vec<&Label>)> {
    match &module.signal(id).driver {
        Driver::Case { selector, arms, .. } => Some((*selector, arms.iter().map(|arm| &arm.label).collect())),
        _ => None,
    }
}

/// Whether one of `from` depends on one of `targets` within a cycle, if all outputs of an instance depend on all of its
/// inputs.
fn reaches(module: &Module, operands: &[Vec<SignalId>], from: &[SignalId], targets: &[SignalId]) -> bool {
    let mut seen = HashSet::new();
    let mut seen_instances = HashSet::new();
    let mut open: Vec<SignalId> = from.iter().flat_map(|id| &operands[id.index()]).copied().collect();
    while let Some(id) = open.pop() {
        if targets.contains(&id) {
            return true;
        }
        if !seen.insert(id) {
            continue;
        }
        match module.signal(id).driver {
            Driver::Instance { instance, .. } if seen_instances.insert(instance) => {
                open.extend(&module.instances()[instance].inputs);
            }
            _ => open.extend(&operands[id.index()]),
        }
    }
    false
}
