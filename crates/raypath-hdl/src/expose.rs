//! Modules without state, for proofs about next values of registers.

use crate::names::fresh;
use crate::netlist::{Driver, Item, Module, Port, Signal, SignalId, changed, remade};
use crate::text::Text;
use std::collections::HashSet;
use std::convert::Infallible;
use std::sync::Arc;

/// `module` with every register, in it and inside its instances, replaced by ports. The register `x_q` becomes an input
/// port `x_q`. The output ports `next_x_q`, `reset_x_q` and `has_reset_x_q` show its value after the next edge (its own
/// value if it is not enabled), its reset value, and whether it has one. For a register in an instance `u_y`, the
/// port's names begin with `y_`. A name that is taken gets a number. Two modules with the same names of registers and
/// ports behave the same in every cycle if the results are equivalent.
///
/// A memory is replaced by ports too: its columns become input ports `stack_node`, and output ports `stack_depth`,
/// `stack_latency`, `stack_write_enable`, `stack_write_address`, `stack_write_node`, `stack_read_enable` and
/// `stack_read_address` show what it would do at the next edge. What an enable of 0 makes irrelevant is shown as 0.
pub fn expose_registers(module: &Arc<Module>) -> Arc<Module> {
    exposed(module, true)
}

/// `module` with enables instead of clock gates in its text and in that of its instances: for tools with one clock.
pub fn with_enables(module: &Arc<Module>) -> Arc<Module> {
    changed(module, |module| module.registers.iter_mut().for_each(|register| register.gated = false))
}

/// `module` with every memory, in it and inside its instances, replaced by ports, as for [`expose_registers`], but
/// without depth and latency, and with the signals at the memory as they are. Registers stay. It shows what is around
/// memories.
pub fn expose_memories(module: &Arc<Module>) -> Arc<Module> {
    exposed(module, false)
}

fn exposed(top: &Arc<Module>, with_registers: bool) -> Arc<Module> {
    let Ok(exposed) = remade(top, |module, copy| {
        if !with_registers && module.memory_bits() == 0 {
            return Ok(module.clone());
        }
        let mut open = Open::new(copy);
        (open.module.text.template, open.module.text.verbatim) = (None, None);
        if with_registers {
            open.module.text = Text::default();
            open.registers();
        }
        open.memories(with_registers);
        (0..open.module.instances.len()).for_each(|index| open.connect_new_ports(index));
        Ok::<_, Infallible>(Arc::new(open.module))
    });
    exposed
}

/// A module that is being changed.
pub(crate) struct Open {
    pub module: Module,
    taken: HashSet<String>,
}

impl Open {
    /// Begins with this module.
    pub fn new(module: Module) -> Self {
        Self { taken: names(&module), module }
    }

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

    fn memories(&mut self, for_proofs: bool) {
        self.module.items.retain(|item| !matches!(item, Item::Memory(_)));
        for memory in std::mem::take(&mut self.module.memories) {
            for (place, column) in memory.columns.iter().enumerate() {
                let name = self.module.signal(column.read).name.clone();
                let name = name.unwrap_or_else(|| format!("{}_column_{place}", memory.stem()));
                self.module.signals[column.read.index()].driver = Driver::Input;
                self.module.inputs.push(Port { name, signal: column.read });
            }
            let mut shown = Vec::new();
            if for_proofs {
                for (name, value) in [("depth", memory.depth), ("latency", memory.latency)] {
                    shown.push((name.to_string(), self.add(32, Driver::Constant(value.into()))));
                }
            }
            for (input, &signal) in memory.inputs().into_iter().enumerate() {
                let width = self.module.signal(signal).width;
                let enable = if input == 3 { memory.read_enable } else { memory.write_enable };
                let driver = match input {
                    1 | 3.. if for_proofs => {
                        let zero = self.add(width, Driver::Constant(0));
                        Driver::Mux { select: enable, if_true: signal, if_false: zero }
                    }
                    _ => Driver::Alias(signal),
                };
                shown.push((memory.input_name(input), self.add(width, driver)));
            }
            for (name, signal) in shown {
                let name = self.fresh(format!("{}_{name}", memory.stem()));
                self.module.outputs.push(Port { name, signal });
            }
        }
    }

    /// Connects the new ports of the instance's module, which was opened, to ports of this module.
    fn connect_new_ports(&mut self, index: usize) {
        let instance = &self.module.instances[index];
        let (inputs, outputs, inside) = (instance.inputs.len(), instance.outputs.len(), instance.module.clone());
        let stem = instance.stem().to_string();
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
    }

    /// Adds a nameless signal.
    pub fn add(&mut self, width: u32, driver: Driver) -> SignalId {
        let id = SignalId(self.module.signals.len() as u32);
        self.module.signals.push(Signal::unnamed(width, driver));
        id
    }

    /// Reserves and returns `name`, or `name_2` and so on if it is taken.
    pub fn fresh(&mut self, name: String) -> String {
        fresh(&mut self.taken, &name)
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
