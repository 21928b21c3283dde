//! Applying a change.

use super::Change;
use crate::netlist::{Driver, Item, MemoryInfo, Module, RegisterInfo, Signal, SignalId, mask};
use crate::text::Text;

/// The module with the change; `None` if the change does not apply to it.
pub fn changed(module: &Module, change: &Change) -> Option<Module> {
    let mut new = module.clone();
    // Registers and ports are printed as in the netlist, so that the change is visible in the text.
    new.text = Text::default();
    match change {
        Change::Driver { signal, was, becomes, .. } => {
            let changed = new.signals.get_mut(signal.index()).filter(|found| found.driver == *was)?;
            changed.driver = becomes.clone();
        }
        Change::Inverted { signal } => {
            let Signal { width, driver, .. } = new.signals.get(signal.index())?.clone();
            let (inside, outside) = insert(&mut new, *signal, width, driver);
            new.signals[outside.index()].driver = Driver::Not(inside);
        }
        Change::Operand { signal, operand, becomes } => substitute(&mut new, *signal, *operand, becomes.clone())?,
        Change::ShiftedMore { signal } => {
            let Signal { width, driver, .. } = new.signals.get(signal.index())?.clone();
            let is_left = matches!(driver, Driver::ShiftLeft(..));
            if !is_left && !matches!(driver, Driver::ShiftRight(..)) {
                return None;
            }
            let (inside, outside) = insert(&mut new, *signal, width, driver);
            let (one, outside) = insert(&mut new, outside, 1, Driver::Constant(1));
            new.signals[outside.index()].driver =
                if is_left { Driver::ShiftLeft(inside, one) } else { Driver::ShiftRight(inside, one) };
        }
        Change::NoReset { register } => {
            new.registers.get_mut(*register)?.reset.take()?;
        }
        Change::PortConstant { instance, input, value } => {
            let port = *new.instances.get(*instance)?.inputs.get(*input)?;
            let width = new.signals[port.index()].width;
            let (constant, _) = insert(&mut new, SignalId(0), width, Driver::Constant(*value));
            new.instances[*instance].inputs[*input] = constant;
        }
        Change::PortsExchanged { instance, inputs: [a, b] } => {
            let inputs = &mut new.instances.get_mut(*instance)?.inputs;
            if inputs.len() <= *a.max(b) {
                return None;
            }
            inputs.swap(*a, *b);
        }
        Change::OutputsExchanged { instance, outputs: [a, b] } => {
            let outputs = &mut new.instances.get_mut(*instance)?.outputs;
            let signals = [*outputs.get(*a)?, *outputs.get(*b)?];
            outputs.swap(*a, *b);
            let [first, second] = signals.map(SignalId::index);
            let driver = new.signals[first].driver.clone();
            new.signals[first].driver = std::mem::replace(&mut new.signals[second].driver, driver);
        }
        Change::AlwaysLoads { register } => {
            new.registers.get_mut(*register)?.enable.take()?;
        }
        Change::NeverLoads { register } => {
            new.registers.get(*register)?;
            let (zero, _) = insert(&mut new, SignalId(0), 1, Driver::Constant(0));
            new.registers[*register].enable = Some(zero);
        }
        Change::Reset { register, was, becomes } => {
            new.registers.get_mut(*register)?.reset.as_mut().filter(|reset| **reset == *was)?.clone_from(becomes);
        }
        Change::MemoryMasked { memory, input, mask: kept } => {
            let whole = *memory_input(&mut new, *memory, *input)?;
            let width = new.signals.get(whole.index())?.width;
            let driver = Driver::Constant(*kept & mask(width));
            let (bits, _) = insert(&mut new, SignalId(0), width, driver);
            let whole = *memory_input(&mut new, *memory, *input)?;
            *memory_input(&mut new, *memory, *input)? = match kept {
                0 => bits,
                _ => add(&mut new, width, Driver::And(whole, bits)),
            };
        }
        Change::MemoryAlways { memory, input } => {
            let (one, _) = insert(&mut new, SignalId(0), 1, Driver::Constant(1));
            *memory_input(&mut new, *memory, *input)? = one;
        }
        Change::MemoryExchanged { memory, inputs: [a, b] } => {
            let (first, second) = (*memory_input(&mut new, *memory, *a)?, *memory_input(&mut new, *memory, *b)?);
            *memory_input(&mut new, *memory, *a)? = second;
            *memory_input(&mut new, *memory, *b)? = first;
        }
    }
    Some(new)
}

fn memory_input(module: &mut Module, memory: usize, input: usize) -> Option<&mut SignalId> {
    module.memories.get_mut(memory)?.inputs_mut().into_iter().nth(input)
}

/// A nameless signal after all others.
fn add(module: &mut Module, width: u32, driver: Driver) -> SignalId {
    module.signals.push(Signal::unnamed(width, driver));
    SignalId(module.signals.len() as u32 - 1)
}

/// Replaces `operand` of `signal` by a new signal with this driver.
fn substitute(module: &mut Module, signal: SignalId, operand: SignalId, driver: Driver) -> Option<()> {
    let width = module.signals.get(operand.index())?.width;
    module.signals.get(signal.index()).filter(|found| found.driver.operands().any(|id| id == operand))?;
    driver.operands().all(|id| id.index() < module.signals.len()).then_some(())?;
    let (new, reader) = insert(module, signal, width, driver);
    let shifted = after(signal, operand);
    module.signals[reader.index()].driver.renumber(|id| if id == shifted { new } else { id });
    Some(())
}

/// Inserts a nameless signal before another one, so that operands stay before their readers. Returns both positions.
/// The operands in `driver` have their old positions.
fn insert(module: &mut Module, before: SignalId, width: u32, driver: Driver) -> (SignalId, SignalId) {
    let shift = |id: &mut SignalId| *id = after(before, *id);
    module.signals.insert(before.index(), Signal::unnamed(width, driver));
    for signal in &mut module.signals {
        signal.driver.renumber(|id| after(before, id));
    }
    module.inputs.iter_mut().chain(&mut module.outputs).for_each(|port| shift(&mut port.signal));
    module.registers.iter_mut().flat_map(RegisterInfo::signals_mut).for_each(shift);
    module.memories.iter_mut().flat_map(MemoryInfo::signals_mut).for_each(shift);
    for instance in &mut module.instances {
        instance.inputs.iter_mut().chain(&mut instance.outputs).for_each(shift);
    }
    for item in &mut module.items {
        match item {
            Item::Signal(id) | Item::Parameter(id, _) => shift(id),
            Item::Unused(_, ids) => ids.iter_mut().for_each(shift),
            Item::Section(_) | Item::Instance(_) | Item::Register(_) | Item::Memory(_) => {}
        }
    }
    (before, after(before, before))
}

/// The position of a signal after an insertion before `place`.
fn after(place: SignalId, id: SignalId) -> SignalId {
    SignalId(id.0 + u32::from(id >= place))
}
