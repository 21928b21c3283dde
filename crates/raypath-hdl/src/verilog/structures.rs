//! Ports and signals that are parts of structures in the text.

use crate::netlist::{Driver, Module, SignalId};
use crate::text::PortGroup;
use std::collections::{BTreeMap, HashMap};

/// The structures that a module's text refers to.
pub struct Structures {
    /// How the text refers to signals that are parts of structures.
    members: HashMap<SignalId, String>,
    /// Structures by name: their types.
    variables: HashMap<String, String>,
    /// The variables that instances drive.
    instances: BTreeMap<usize, String>,
    /// The variable that a bank of registers stores.
    next: String,
}

impl Structures {
    /// Names the variables with `fresh`, which makes names unique.
    pub fn new(module: &Module, mut fresh: impl FnMut(&str) -> String) -> Self {
        let (members, variables, instances) = (HashMap::new(), HashMap::new(), BTreeMap::new());
        let mut found = Self { members, variables, instances, next: String::new() };
        let text = module.text();
        for input in &text.inputs {
            found.add(&input.name, input, |port| {
                let port = module.inputs().iter().find(|input| input.name == port)?;
                Some(port.signal)
            });
        }
        if let Some(input) = &text.enumerated
            && let Some(port) = module.inputs().iter().find(|port| port.name == input.port)
        {
            found.members.insert(port.signal, format!("{}.{}", input.variable, input.field));
        }
        if let Some(bank) = &text.bank {
            found.next = fresh(&format!("{}_d", bank.output.stem()));
            for ((_, select), &id) in bank.output.members.iter().zip(&bank.next) {
                found.members.insert(id, format!("{}{select}", found.next));
            }
        }
        let is_printed = |index: usize| text.bank.as_ref().is_none_or(|bank| bank.replaces != Some(index));
        for (index, instance) in module.instances().iter().enumerate().filter(|(index, _)| is_printed(*index)) {
            let Some(output) = instance.module.text().output() else { continue };
            let variable = fresh(&format!("{}_{}", instance.stem(), output.stem()));
            found.add(&variable, output, |port| {
                let position = instance.module.outputs().iter().position(|output| output.name == port)?;
                Some(instance.outputs[position])
            });
            found.instances.insert(index, variable);
        }
        found
    }

    fn add(&mut self, variable: &str, group: &PortGroup, signal: impl Fn(&str) -> Option<SignalId>) {
        for (port, select) in &group.members {
            if let Some(signal) = signal(port) {
                self.members.insert(signal, format!("{variable}{select}"));
            }
        }
        self.variables.insert(variable.to_string(), group.structure.clone());
    }

    /// How the text refers to a signal that is part of a structure.
    pub fn member(&self, id: SignalId) -> Option<&str> {
        self.members.get(&id).map(String::as_str)
    }

    /// The variable that an instance drives, if its outputs are a structure.
    pub fn of_instance(&self, instance: usize) -> Option<&str> {
        self.instances.get(&instance).map(String::as_str)
    }

    /// The variable that a bank of registers stores.
    pub fn next(&self) -> &str {
        &self.next
    }

    /// The one variable whose parts these signals are, in the order of the group's members.
    pub fn whole(&self, module: &Module, group: &PortGroup, signals: &[SignalId]) -> Option<String> {
        let mut variable = None;
        for ((_, select), &id) in group.members.iter().zip(signals) {
            let own = self.member(source(module, id))?.strip_suffix(select.as_str())?;
            if *variable.get_or_insert(own) != own {
                return None;
            }
        }
        let variable = variable?;
        (self.variables.get(variable)? == &group.structure).then(|| variable.to_string())
    }
}

/// The signal behind nameless aliases.
fn source(module: &Module, mut id: SignalId) -> SignalId {
    while let (Driver::Alias(other), None) = (&module.signal(id).driver, &module.signal(id).name) {
        id = *other;
    }
    id
}
