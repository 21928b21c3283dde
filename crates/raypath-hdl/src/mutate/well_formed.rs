//! Checks the widths of a finished module by the rules of [`crate::Builder`].

use crate::Error;
use crate::builder::describe;
use crate::netlist::{Driver, Module, SignalId, fits};

/// An error if widths do not match.
pub fn check(module: &Module) -> Result<(), Error> {
    let width = |id: SignalId| module.signals.get(id.index()).map(|signal| signal.width);
    for (place, signal) in module.signals.iter().enumerate() {
        if !has_width(module, &signal.driver, signal.width) {
            return Err(problem(module, SignalId(place as u32), "its driver does not fit its width"));
        }
    }
    for register in &module.registers {
        let own = width(register.signal);
        let loads = register.enable.is_none_or(|enable| width(enable) == Some(1));
        let resets = register.reset.is_none_or(|reset| own.is_some_and(|own| fits(own, reset)));
        if width(register.next) != own || !loads || !resets {
            return Err(problem(module, register.signal, "its next value, enable or reset value does not fit it"));
        }
    }
    for memory in &module.memories {
        let address = Some(memory.address_width());
        let widths = [Some(1), address, Some(1), address].into_iter();
        let widths = widths.chain(memory.columns.iter().map(|column| width(column.read)));
        for ((input, &id), expected) in memory.inputs().into_iter().enumerate().zip(widths) {
            if width(id) != expected {
                return Err(problem(module, id, &format!("does not fit {}.{}", memory.name, memory.input_name(input))));
            }
        }
    }
    for instance in &module.instances {
        for (port, &id) in instance.module.inputs.iter().zip(&instance.inputs) {
            if width(id) != Some(instance.module.signal(port.signal).width) {
                return Err(problem(module, id, &format!("does not fit {}.{}", instance.name, port.name)));
            }
        }
    }
    Ok(())
}

/// Whether a driver's operands exist, match, and give a word of this width.
fn has_width(module: &Module, driver: &Driver, own: u32) -> bool {
    if driver.operands().any(|id| id.index() >= module.signals.len()) {
        return false;
    }
    let width = |id: &SignalId| module.signals[id.index()].width;
    match driver {
        Driver::Input | Driver::Register(_) | Driver::Instance { .. } | Driver::Memory { .. } => true,
        Driver::Constant(value) => fits(own, *value),
        Driver::Not(a) | Driver::Alias(a) | Driver::ShiftLeft(a, _) | Driver::ShiftRight(a, _) => width(a) == own,
        Driver::And(a, b) | Driver::Or(a, b) | Driver::Xor(a, b) | Driver::Add(a, b) | Driver::Sub(a, b) => {
            width(a) == own && width(b) == own
        }
        Driver::Mul(a, b) => width(a) + width(b) == own,
        Driver::Equal(a, b) | Driver::Less(a, b) => own == 1 && width(a) == width(b),
        Driver::Any(_) | Driver::All(_) => own == 1,
        Driver::Mux { select, if_true, if_false } => {
            width(select) == 1 && width(if_true) == own && width(if_false) == own
        }
        Driver::Case { selector, arms, default } => {
            let arm_fits = |arm: &crate::Arm| width(&arm.value) == own && fits(width(selector), arm.label.value);
            width(default) == own && arms.iter().all(arm_fits)
        }
        Driver::Concat(parts) => parts.iter().map(width).sum::<u32>() == own,
        Driver::Slice { source, low } => low + own <= width(source),
    }
}

fn problem(module: &Module, id: SignalId, problem: &str) -> Error {
    Error::Width { module: module.name.clone(), signal: describe(module, id), problem: problem.to_string() }
}
