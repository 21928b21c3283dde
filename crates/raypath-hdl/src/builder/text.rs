//! Settings of how a module is printed.

use super::{Builder, Register, Wire};
use crate::netlist::{Label, Module};
use crate::text::{Bank, EnumeratedInput, Package, PortGroup, Template};
use std::sync::Arc;

impl Builder {
    /// Refers to the declarations of a package.
    pub fn package(&self, package: &Arc<Package>) {
        self.state.borrow_mut().module.text.package = Some(package.clone());
    }

    /// Prints input ports as one port of a structure.
    pub fn group_inputs(&self, group: PortGroup) {
        self.expect_members(&group, |module| module.inputs());
        self.state.borrow_mut().module.text.inputs.push(group);
    }

    /// Prints output ports as one port of a structure.
    pub fn group_outputs(&self, group: PortGroup) {
        self.expect_members(&group, |module| module.outputs());
        self.state.borrow_mut().module.text.output = Some(group);
    }

    /// Prints an input port as a variable of an enumeration.
    pub fn enumerate_input(&self, input: EnumeratedInput) {
        self.claim(&input.variable);
        self.state.borrow_mut().module.text.enumerated = Some(input);
    }

    /// Prints registers in an instance of `module`. `ports` are its ports other than `data_i` and `data_o`, `next` what
    /// it stores, in the order of the members of `output`. If the netlist has an instance of this name, the text has
    /// that of `module` in its place.
    pub fn bank(
        &self,
        name: &str,
        module: &Arc<Module>,
        ports: &[(&str, Wire<'_>)],
        next: &[Wire<'_>],
        registers: &[Register<'_>],
        output: PortGroup,
    ) {
        self.expect_members(&output, |module| module.outputs());
        let replaces = self.state.borrow().module.instances.iter().position(|instance| instance.name == name);
        if replaces.is_none() {
            self.claim(name);
        }
        let bank = Bank {
            name: name.to_string(),
            module: module.clone(),
            replaces,
            registers: registers.iter().map(|register| register.index).collect(),
            ports: ports.iter().map(|(port, wire)| (port.to_string(), self.own(*wire))).collect(),
            next: self.own_all(next),
            output,
        };
        if bank.next.len() != bank.output.members.len() {
            let (stored, shown) = (bank.next.len(), bank.output.members.len());
            self.fail_drive(name, &format!("stores {stored} words, expected the {shown} of {}", bank.output.name));
        }
        self.state.borrow_mut().module.text.bank = Some(bank);
    }

    /// Prints words of [`PAYLOAD`](crate::text::PAYLOAD) bits as words of a parameter's width.
    pub fn parameterise_width(&self) {
        self.state.borrow_mut().module.text.has_width_parameter = true;
    }

    /// Ports whose names begin so follow each other under a comment, in this order.
    pub fn channel(&self, prefix: &str, comment: &str) {
        self.state.borrow_mut().module.text.channels.push((prefix.to_string(), comment.to_string()));
    }

    /// Instances of the module have this text.
    pub fn template(&self, template: Template) {
        self.state.borrow_mut().module.text.template = Some(template);
    }

    /// The value of a label, under its name.
    pub fn label(&self, label: &Label, width: u32) -> Wire<'_> {
        if let Some(known) = self.named_constant(&label.name, label.value) {
            return known;
        }
        self.claim_label(label, width);
        let wire = self.constant(width, label.value);
        self.name(wire, &label.name);
        wire
    }

    /// The members of a group are ports.
    fn expect_members(&self, group: &PortGroup, ports: impl Fn(&Module) -> &[crate::Port]) {
        let missing = {
            let state = self.state.borrow();
            let is_port = |name: &String| ports(&state.module).iter().any(|port| port.name == *name);
            group.members.iter().find(|(name, _)| !is_port(name)).map(|(name, _)| name.clone())
        };
        if let Some(name) = missing {
            self.fail_name(&name, &format!("is a member of {}, expected a port", group.name));
        }
        self.claim(&group.name);
    }
}
