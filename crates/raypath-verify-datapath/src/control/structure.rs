//! Structural checks of the netlist: the steps form a chain, in each step all data registers load with the opcode's,
//! and no handshake and no opcode depends on data.

use raypath_hdl::{Driver, Module, RegisterInfo, SignalId, depends_combinationally, influences};
use raypath_rtl::{Config, Control, DatapathNetlist};
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

/// Checks that the registers of a step load together: every data register (without reset) has a counterpart among the
/// opcode's registers, loads when that one loads, and takes the counterpart of the value that that one takes.
pub fn together(module: &Module) -> Vec<String> {
    let name = |register: &RegisterInfo| module.signal(register.signal).name.clone().unwrap_or_default();
    let data: Vec<(&RegisterInfo, String)> = module
        .registers()
        .iter()
        .filter(|register| register.reset.is_none())
        .map(|register| (register, name(register)))
        .collect();
    let mut faults = Vec::new();
    for (register, own) in &data {
        let suffix = suffix(own);
        let stem = own.strip_suffix(&suffix).unwrap_or(own);
        let find = |name: String| data.iter().find(|(_, other)| *other == name).map(|(register, _)| *register);
        let matches = find(format!("opcode{suffix}")).is_some_and(|opcode| {
            let sibling = |other: &str| find(format!("{stem}{other}")).zip(find(format!("opcode{other}")));
            loads_with(module, register, opcode) && same_load(module, register, opcode, &sibling)
        });
        if !matches {
            faults.push(format!("{}: {own} does not load with the opcode", module.name()));
        }
    }
    faults
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

/// A register name's suffix: `_spare_q`, `_store_3_q` or `_q`.
fn suffix(name: &str) -> String {
    if name.ends_with("_spare_q") {
        return "_spare_q".to_string();
    }
    match name.rfind("_store_") {
        Some(begin) => name[begin..].to_string(),
        None => "_q".to_string(),
    }
}

/// Whether two registers select alike between the arriving word and the waiting word.
fn same_load<'m>(
    module: &'m Module,
    register: &RegisterInfo,
    opcode: &RegisterInfo,
    sibling: &dyn Fn(&str) -> Option<(&'m RegisterInfo, &'m RegisterInfo)>,
) -> bool {
    let driver = |signal| &module.signal(source(module, signal)).driver;
    // The arriving word is the next value of the first register behind the front.
    let arrives = |other: &str, wire: SignalId| {
        sibling(other).is_some_and(|(own, _)| source(module, own.next) == source(module, wire))
    };
    let spare = sibling("_spare_q");
    let store = sibling("_store_0_q");
    let is_front = suffix(&module.signal(register.signal).name.clone().unwrap_or_default()) == "_q";
    match (driver(register.next), driver(opcode.next)) {
        (
            Driver::Mux { select, if_true, if_false },
            Driver::Mux { select: opcode_select, if_false: opcode_false, .. },
        ) if is_front && (spare.is_some() || store.is_some()) => {
            let same_select = select == opcode_select;
            match (spare, store) {
                (Some((own, others)), _) => {
                    same_select
                        && arrives("_spare_q", *if_true)
                        && source(module, *if_false) == own.signal
                        && source(module, *opcode_false) == others.signal
                }
                (None, _) => {
                    same_select && arrives("_store_0_q", *if_false) && same_oldest(module, *if_true, opcode.next)
                }
            }
        }
        // Behind the front every register takes the arriving word, and so does that of a step without waiting words.
        _ if is_front => spare.is_none() && store.is_none(),
        _ => store.is_none_or(|(own, _)| source(module, own.next) == source(module, register.next)),
    }
}

/// Whether a word is the OR of stored words, each masked by the same bit as the opcode's stored word.
fn same_oldest(module: &Module, oldest: SignalId, opcode_next: SignalId) -> bool {
    let Driver::Mux { if_true, .. } = module.signal(source(module, opcode_next)).driver else { return false };
    let (own, opcode) = (masked(module, oldest), masked(module, if_true));
    own.is_some() && own == opcode
}

/// The stored words of an OR of masked words, each with its mask's pointer and bit, in the order of their names.
fn masked(module: &Module, word: SignalId) -> Option<Vec<(String, SignalId, u32)>> {
    let signal = source(module, word);
    match module.signal(signal).driver {
        Driver::Or(a, b) => {
            let mut all = masked(module, a)?;
            all.extend(masked(module, b)?);
            all.sort();
            Some(all)
        }
        Driver::And(stored, mask) => {
            let place = suffix(module.signal(source(module, stored)).name.as_deref()?);
            let mut mask = source(module, mask);
            if let Driver::Concat(parts) = &module.signal(mask).driver {
                let first = *parts.first()?;
                mask = source(module, first);
                if parts.iter().any(|&part| part != first) {
                    return None;
                }
            }
            let Driver::Slice { source: pointer, low } = module.signal(mask).driver else { return None };
            Some(vec![(place, source(module, pointer), low)])
        }
        _ => None,
    }
}
