//! Structural checks of the netlist: the steps form a chain, in each step all data registers load with the opcode's,
//! and no handshake and no opcode depends on data.

use raypath_hdl::{Driver, MemoryInfo, Module, RegisterInfo, SignalId, depends_combinationally, influences};
use raypath_rtl::{Config, Control, DatapathNetlist};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The faults in a datapath's structure; empty if it is as required.
///
/// # Errors
/// The netlist has a combinational loop.
pub fn structural_faults(datapath: &DatapathNetlist, config: Config) -> Result<Vec<String>, raypath_hdl::Error> {
    let mut faults = Vec::new();
    // In a folded pipeline, data and opcode load in different rounds; lockstep with the models shows that they agree.
    if datapath.interval() == 1 {
        faults.extend(chain_faults(datapath, config));
        for step in 0..datapath.steps().count() {
            if let Some(module) = datapath.module(step) {
                faults.extend(together(module));
            }
        }
    }
    faults.extend(data_faults(datapath.top())?);
    for output in CONTROL_OUTPUTS {
        if depends_combinationally(datapath.top(), output, "output_ready_i")? {
            faults.push(format!("{output} depends on output_ready_i in the same cycle"));
        }
    }
    Ok(faults)
}

/// The control's outputs of a datapath.
const CONTROL_OUTPUTS: [&str; 3] = ["input_ready_o", "output_valid_o", "opcode_o"];

/// Checks that no handshake and no opcode of a datapath depends on data, in any cycle.
///
/// # Errors
/// A port of the control is missing; the netlist has a combinational loop.
pub fn data_faults(top: &Arc<Module>) -> Result<Vec<String>, raypath_hdl::Error> {
    let control = ["input_valid_i", "opcode_i", "output_ready_i"];
    let data = influences(top, &CONTROL_OUTPUTS)?.into_iter().filter(|input| !control.contains(input));
    Ok(data.map(|input| format!("the control depends on {input}")).collect())
}

/// Checks that every step takes valid, opcode and data from the step before, and ready from the step after.
fn chain_faults(datapath: &DatapathNetlist, config: Config) -> Vec<String> {
    let top = datapath.top();
    let position = |name: &str| top.instances().iter().position(|instance| instance.module.name() == name);
    let steps: Vec<&str> =
        (0..datapath.steps().count()).filter_map(|step| datapath.module(step).map(|module| module.name())).collect();
    let mut faults = Vec::new();
    for (step, name) in steps.iter().enumerate() {
        let Some(instance) = position(name).map(|position| &top.instances()[position]) else {
            faults.push(format!("{name} is not in the pipeline"));
            continue;
        };
        let before = step.checked_sub(1).and_then(|before| position(steps[before]));
        let after = steps.get(step + 1).and_then(|after| position(after));
        for (port, &wire) in instance.module.inputs().iter().zip(&instance.inputs) {
            let expected = match (port.stem(), before) {
                ("ready", _) => after.map(|after| (after, "ready")),
                ("valid", None) if config.microarchitecture.control == Control::Credit => {
                    position("raypath_credit").map(|credit| (credit, "valid"))
                }
                (stem, _) if stem.ends_with("_state") || stem.ends_with("_written") => continue,
                (stem, Some(before)) => Some((before, stem)),
                (_, None) => None,
            };
            let source = source(top, wire);
            let as_expected = match (expected, &top.signal(source).driver) {
                (Some((position, stem)), &Driver::Instance { instance, output }) => {
                    instance == position && top.instances()[instance].module.outputs()[output].stem() == stem
                }
                (None, Driver::Input) => true,
                _ => false,
            };
            if !as_expected {
                faults.push(format!("{name}: {} is not driven by the neighbouring step", port.name));
            }
        }
    }
    faults
}

/// The signal behind its aliases.
fn source(module: &Module, mut signal: SignalId) -> SignalId {
    while let Driver::Alias(other) = module.signal(signal).driver {
        signal = other;
    }
    signal
}

/// Checks that the registers of a step load together: in what is shown of a word, each register (without reset), and
/// each column of the memory that opcodes wait in, stands where one of the opcode's does, and takes what arrives of the
/// word when that one takes the opcode.
pub fn together(module: &Module) -> Vec<String> {
    let outputs = module.outputs();
    let opcode = outputs.iter().find(|port| port.stem() == "opcode").map(|port| port.signal);
    let mut loaded = HashSet::new();
    for output in outputs {
        let mut word = Counterparts { module, of: HashMap::new() };
        if opcode.is_some_and(|opcode| word.agree(output.signal, opcode)) {
            loaded.extend(word.of.into_values());
        }
    }
    let waits = |memory: &&MemoryInfo| memory.columns.iter().any(|column| loaded.contains(&column.read));
    let columns = module.memories().iter().filter(waits).flat_map(|memory| &memory.columns).map(|column| column.read);
    let data = module.registers().iter().filter(|register| register.reset.is_none()).map(|register| register.signal);
    let name = |signal| module.signal(signal).name.clone().unwrap_or_default();
    let fault = |signal| format!("{}: {} does not load with the opcode", module.name(), name(signal));
    data.chain(columns).filter(|signal| !loaded.contains(signal)).map(fault).collect()
}

/// A word's signals beside the opcode's.
struct Counterparts<'m> {
    module: &'m Module,
    /// For each signal behind the opcode that is shown, the word's.
    of: HashMap<SignalId, SignalId>,
}

impl Counterparts<'_> {
    /// Whether the logic behind a signal of the word is that behind the opcode's. Behind the opcode that arrives, an
    /// input, the word has whatever computes it, the same wherever it is taken.
    fn agree(&mut self, own: SignalId, opcode: SignalId) -> bool {
        let (own, opcode) = (source(self.module, own), source(self.module, opcode));
        if let Some(&known) = self.of.get(&opcode) {
            return known == own;
        }
        self.of.insert(opcode, own);
        match (&self.module.signal(own).driver, &self.module.signal(opcode).driver) {
            (_, Driver::Input) => true,
            (&Driver::Register(own), &Driver::Register(opcode)) => {
                let [own, opcode] = [own, opcode].map(|register| &self.module.registers()[register]);
                loads_with(self.module, own, opcode) && self.agree(own.next, opcode.next)
            }
            (&Driver::Memory { memory, column }, &Driver::Memory { memory: same, column: other }) => {
                let columns = &self.module.memories()[memory].columns;
                memory == same && self.agree(columns[column].written, columns[other].written)
            }
            (
                &Driver::Mux { select, if_true, if_false },
                &Driver::Mux { select: same, if_true: opcode_true, if_false: opcode_false },
            ) => {
                bit(self.module, Some(select)) == bit(self.module, Some(same))
                    && self.agree(if_true, opcode_true)
                    && self.agree(if_false, opcode_false)
            }
            (&Driver::Or(a, b), &Driver::Or(opcode_a, opcode_b)) => self.agree(a, opcode_a) && self.agree(b, opcode_b),
            (&Driver::And(word, mask), &Driver::And(opcode, same)) => {
                self.mask(mask).is_some_and(|bit| self.mask(same) == Some(bit)) && self.agree(word, opcode)
            }
            _ => false,
        }
    }

    /// The bit that a mask repeats.
    fn mask(&self, mask: SignalId) -> Option<(SignalId, u32)> {
        let mask = source(self.module, mask);
        match &self.module.signal(mask).driver {
            Driver::Concat(parts) => {
                let first = parts.first()?;
                parts.iter().all(|part| part == first).then(|| bit(self.module, Some(*first)))?
            }
            _ => bit(self.module, Some(mask)),
        }
    }
}

/// Whether a register loads with the opcode's. Behind a clock gate it may load less often: the conjunction of the
/// opcode's enable with a condition. That the condition holds for each job that uses the register is a claim about
/// data, which the comparisons with the models check.
fn loads_with(module: &Module, register: &RegisterInfo, opcode: &RegisterInfo) -> bool {
    let enable = bit(module, opcode.enable);
    let is_same = |signal| bit(module, Some(signal)) == enable;
    let gated = register.enable.filter(|_| register.gated).map(|enable| &module.signal(source(module, enable)).driver);
    bit(module, register.enable) == enable || matches!(gated, Some(Driver::And(a, _)) if is_same(*a))
}

/// A one-bit signal, identified by the word and bit that it is taken from.
fn bit(module: &Module, signal: Option<SignalId>) -> Option<(SignalId, u32)> {
    let signal = source(module, signal?);
    match module.signal(signal).driver {
        Driver::Slice { source: whole, low } => Some((source(module, whole), low)),
        _ => Some((signal, 0)),
    }
}
