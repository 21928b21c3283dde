//! Modules without state, for proofs about next values of registers.

use crate::netlist::{Driver, Instance, Item, Module, Port, Signal, SignalId};
use crate::text::Text;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// `module` with every register, in it and inside its instances, replaced by ports. The register `x_q` becomes an input
/// port `x_q`. The output ports `next_x_q`, `reset_x_q` and `has_reset_x_q` show its value after the next edge (its own
/// value if it is not enabled), its reset value, and whether it has one. For a register in an instance `u_y`, the
/// port's names begin with `y_`. A name that is taken gets a number. Two modules with the same names of registers and
/// ports behave the same in every cycle if the results are equivalent.
pub fn expose_registers(module: &Arc<Module>) -> Arc<Module> {
    Exposed::default().expose(module)
}

/// Finished modules. Instances of the same module keep sharing it.
#[derive(Default)]
struct Exposed(HashMap<*const Module, Arc<Module>>);

impl Exposed {
    fn expose(&mut self, module: &Arc<Module>) -> Arc<Module> {
        if let Some(done) = self.0.get(&Arc::as_ptr(module)) {
            return done.clone();
        }
        let mut open = Open { module: (**module).clone(), taken: names(module) };
        open.module.text = Text::default();
        open.registers();
        for index in 0..open.module.instances.len() {
            let inside = self.expose(&open.module.instances[index].module);
            open.instance(index, inside);
        }
        let result = Arc::new(open.module);
        self.0.insert(Arc::as_ptr(module), result.clone());
        result
    }
}

/// A module that is being opened.
struct Open {
    module: Module,
    taken: HashSet<String>,
}

impl Open {
    fn registers(&mut self) {
        self.module.items.retain(|item| !matches!(item, Item::Register(_)));
        for register in std::mem::take(&mut self.module.registers) {
            let held = register.signal;
            let Signal { name, width, .. } = self.module.signal(held).clone();
            let name = name.unwrap_or_else(|| format!("register_{}", held.0));
            let next = match register.enable {
                Some(select) => self.add(width, Driver::Mux { select, if_true: register.next, if_false: held }),
                None => register.next,
            };
            // A port shows a signal of its own.
            let next = self.add(width, Driver::Alias(next));
            let reset = self.add(width, Driver::Constant(register.reset.unwrap_or(0)));
            let has_reset = self.add(1, Driver::Constant(register.reset.is_some().into()));
            self.module.signals[held.index()].driver = Driver::Input;
            self.module.inputs.push(Port { name: name.clone(), signal: held });
            for (prefix, signal) in [("next", next), ("reset", reset), ("has_reset", has_reset)] {
                let name = self.fresh(format!("{prefix}_{name}"));
                self.module.outputs.push(Port { name, signal });
            }
        }
    }

    /// Replaces the instance's module by the opened one, and connects its new ports to ports of this module.
    fn instance(&mut self, index: usize, inside: Arc<Module>) {
        let Instance { inputs, outputs, .. } = &self.module.instances[index];
        let (inputs, outputs) = (inputs.len(), outputs.len());
        let stem = self.module.instances[index].stem().to_string();
        for port in &inside.inputs[inputs..] {
            let name = self.fresh(format!("{stem}_{}", port.name));
            let signal = self.add(inside.signal(port.signal).width, Driver::Input);
            self.module.signals[signal.index()].name = Some(name.clone());
            self.module.inputs.push(Port { name, signal });
            self.module.instances[index].inputs.push(signal);
        }
        for (output, port) in inside.outputs.iter().enumerate().skip(outputs) {
            let name = self.fresh(format!("{stem}_{}", port.name));
            let wire = self.fresh(format!("{name}_inside"));
            let signal = self.add(inside.signal(port.signal).width, Driver::Instance { instance: index, output });
            self.module.signals[signal.index()].name = Some(wire);
            self.module.outputs.push(Port { name, signal });
            self.module.instances[index].outputs.push(signal);
        }
        self.module.instances[index].module = inside;
    }

    fn add(&mut self, width: u32, driver: Driver) -> SignalId {
        let id = SignalId(self.module.signals.len() as u32);
        self.module.signals.push(Signal { name: None, width, driver, comment: None });
        id
    }

    fn fresh(&mut self, name: String) -> String {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        names.find(|name| self.taken.insert(name.clone())).unwrap_or(name)
    }
}

/// All names in a module.
fn names(module: &Module) -> HashSet<String> {
    let labels = module.signals.iter().flat_map(|signal| match &signal.driver {
        Driver::Case { arms, .. } => arms.iter().map(|arm| arm.label.name.clone()).collect(),
        _ => Vec::new(),
    });
    module.names().chain(labels).collect()
}
