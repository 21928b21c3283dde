//! Listing the faults of a module.

use super::{Change, Fault};
use crate::builder::describe;
use crate::netlist::{Driver, Module, SignalId, mask};
use std::collections::BTreeSet;

/// See [`super::faults`].
pub fn faults(module: &Module) -> Vec<Fault> {
    let live = LiveSignals::new(module);
    let mut faults = Vec::new();
    let mut add = |place: String, change: Change| {
        faults.push(Fault { module: module.name.clone(), place, how: change.words(module), change });
    };
    for (index, signal) in module.signals.iter().enumerate() {
        let id = SignalId(index as u32);
        if live.is_live(id) {
            let mut changes = Changes { module, live: &live, id, width: signal.width, found: Vec::new() };
            changes.of(&signal.driver);
            changes.found.into_iter().for_each(|change| add(live.name(id), change));
        }
    }
    for (register, info) in module.registers.iter().enumerate() {
        let place = || describe(module, info.signal);
        if info.enable.is_some() {
            add(place(), Change::AlwaysLoads { register });
        }
        add(place(), Change::NeverLoads { register });
        if let Some(was) = info.reset {
            let ones = mask(module.signal(info.signal).width);
            for becomes in BTreeSet::from([was ^ 1, was ^ ones]) {
                add(place(), Change::Reset { register, was, becomes });
            }
            // Without any reset the module would have no port for it.
            let others = module.registers.iter().filter(|other| other.reset.is_some()).count() > 1;
            if others || module.instances.iter().any(|instance| instance.module.has_reset()) {
                add(place(), Change::NoReset { register });
            }
        }
    }
    for (memory, info) in module.memories.iter().enumerate() {
        for change in memory_changes(module, memory) {
            let (Change::MemoryMasked { input, .. }
            | Change::MemoryAlways { input, .. }
            | Change::MemoryExchanged { inputs: [input, _], .. }) = change
            else {
                continue;
            };
            add(format!("{}.{}", info.name, info.input_name(input)), change);
        }
    }
    for (instance, info) in module.instances.iter().enumerate() {
        for (input, (port, id)) in info.module.inputs.iter().zip(&info.inputs).enumerate() {
            let width = module.signal(*id).width;
            for value in [0, mask(width)] {
                if module.signal(*id).driver != Driver::Constant(value) {
                    add(format!("{}.{}", info.name, port.name), Change::PortConstant { instance, input, value });
                }
            }
            let is_alike = |other: &SignalId| other != id && module.signal(*other).width == width;
            if let Some(more) = info.inputs[input + 1..].iter().position(is_alike) {
                let inputs = [input, input + 1 + more];
                add(format!("{}.{}", info.name, port.name), Change::PortsExchanged { instance, inputs });
            }
        }
        for (output, (port, id)) in info.module.outputs.iter().zip(&info.outputs).enumerate() {
            let width = module.signal(*id).width;
            let is_alike =
                |other: &SignalId| module.signal(*other).width == width && (live.is_live(*id) || live.is_live(*other));
            if let Some(more) = info.outputs[output + 1..].iter().position(is_alike) {
                let outputs = [output, output + 1 + more];
                add(format!("{}.{}", info.name, port.name), Change::OutputsExchanged { instance, outputs });
            }
        }
    }
    faults
}

/// The changes at the inputs of a memory. Inputs are the two enables (0 and 2), their addresses (1 and 3), and columns.
fn memory_changes(module: &Module, memory: usize) -> Vec<Change> {
    let inputs = module.memories[memory].inputs();
    let signal = |input: usize| module.signal(*inputs[input]);
    let is_constant = |input: usize, value: u64| signal(input).driver == Driver::Constant(value);
    let mut changes = Vec::new();
    for (enable, address) in [(0, 1), (2, 3)] {
        changes.push(Change::MemoryMasked { memory, input: enable, mask: 0 });
        if !is_constant(enable, 1) {
            changes.push(Change::MemoryAlways { memory, input: enable });
        }
        let bits = 0..signal(address).width;
        changes.extend(bits.map(|bit| Change::MemoryMasked { memory, input: address, mask: !(1 << bit) }));
    }
    if inputs[1] != inputs[3] {
        changes.push(Change::MemoryExchanged { memory, inputs: [1, 3] });
    }
    for column in 4..inputs.len() {
        if !is_constant(column, 0) {
            changes.push(Change::MemoryMasked { memory, input: column, mask: 0 });
        }
        let is_exchangeable =
            |next: usize| inputs[next] != inputs[column] && signal(next).width == signal(column).width;
        if column + 1 < inputs.len() && is_exchangeable(column + 1) {
            changes.push(Change::MemoryExchanged { memory, inputs: [column, column + 1] });
        }
    }
    changes
}

/// The changes of one signal.
struct Changes<'m> {
    module: &'m Module,
    live: &'m LiveSignals<'m>,
    id: SignalId,
    width: u32,
    found: Vec<Change>,
}

impl Changes<'_> {
    fn of(&mut self, driver: &Driver) {
        self.operator(driver);
        let operands: BTreeSet<SignalId> = match driver {
            // The same as a multiplexer stuck at one side, which is listed, or as either operand of a conjunction.
            Driver::Mux { if_true, if_false, .. } => [*if_true, *if_false].into(),
            Driver::And(a, _) => [*a].into(),
            _ => driver.operands().collect(),
        };
        // A constant has faults of its own.
        let is_constant = |id: SignalId| matches!(self.module.signal(id).driver, Driver::Constant(_));
        let operands = operands.into_iter().filter(|&id| !is_constant(id));
        let signal = self.id;
        let becomes = |operand, becomes| Change::Operand { signal, operand, becomes };
        self.found.extend(operands.map(|operand| becomes(operand, Driver::Constant(0))));
        let with_ones: BTreeSet<SignalId> = match driver {
            Driver::Mux { if_true, if_false, .. } => [*if_true, *if_false].into(),
            // All ones, whichever operand is.
            Driver::Or(a, _) => [*a].into(),
            _ => driver.operands().collect(),
        };
        let with_ones = with_ones.into_iter().filter(|&id| !is_constant(id));
        let ones = |id: SignalId| Driver::Constant(mask(self.module.signal(id).width));
        self.found.extend(with_ones.map(|operand| becomes(operand, ones(operand))));
        for operand in driver.operands().collect::<BTreeSet<SignalId>>() {
            let with = self.nearest(driver, operand);
            self.found.extend(with.map(|with| becomes(operand, Driver::Alias(with))));
        }
    }

    /// The nearest live signal of an operand's width, before it if there is one, that is no constant and no operand.
    /// No other name either, because what it stands for may come later.
    fn nearest(&self, driver: &Driver, operand: SignalId) -> Option<SignalId> {
        let width = self.module.signal(operand).width;
        let is_it = |&other: &SignalId| {
            let signal = self.module.signal(other);
            let is_fit = signal.width == width && !matches!(signal.driver, Driver::Constant(_) | Driver::Alias(_));
            is_fit && self.live.is_live(other) && driver.operands().all(|id| id != other)
        };
        let before = (0..operand.0).rev().map(SignalId).find(is_it);
        before.or_else(|| (operand.0 + 1..self.id.0).map(SignalId).find(is_it))
    }

    fn operator(&mut self, driver: &Driver) {
        match driver {
            Driver::Input | Driver::Register(_) | Driver::Instance { .. } | Driver::Memory { .. } | Driver::Mul(..) => {
            }
            Driver::Constant(value) => self.constant(*value),
            Driver::Not(a) => self.becomes(driver, Driver::Alias(*a), "Not left out"),
            Driver::And(a, b) => self.becomes(driver, Driver::Or(*a, *b), "And becomes Or"),
            Driver::Or(a, b) => self.becomes(driver, Driver::And(*a, *b), "Or becomes And"),
            Driver::Xor(a, b) => self.becomes(driver, Driver::Or(*a, *b), "Xor becomes Or"),
            Driver::Add(a, b) => self.becomes(driver, Driver::Sub(*a, *b), "Add becomes Sub"),
            Driver::Sub(a, b) => self.becomes(driver, Driver::Add(*a, *b), "Sub becomes Add"),
            Driver::Equal(..) => self.inverted(),
            Driver::Less(a, b) => {
                self.becomes(driver, Driver::Less(*b, *a), "operands of Less exchanged");
                self.inverted();
            }
            Driver::Any(a) => {
                self.becomes(driver, Driver::All(*a), "Any becomes All");
                self.inverted();
            }
            Driver::All(a) => {
                self.becomes(driver, Driver::Any(*a), "All becomes Any");
                self.inverted();
            }
            Driver::ShiftLeft(a, by) => {
                self.becomes(driver, Driver::ShiftRight(*a, *by), "shifts right");
                self.found.push(Change::ShiftedMore { signal: self.id });
            }
            Driver::ShiftRight(a, by) => {
                self.becomes(driver, Driver::ShiftLeft(*a, *by), "shifts left");
                self.found.push(Change::ShiftedMore { signal: self.id });
            }
            Driver::Mux { select, if_true, if_false } => {
                if if_true != if_false {
                    let becomes = Driver::Not(*select);
                    self.found.push(Change::Operand { signal: self.id, operand: *select, becomes });
                    self.becomes(driver, Driver::Alias(*if_true), "select stuck at 1");
                    self.becomes(driver, Driver::Alias(*if_false), "select stuck at 0");
                }
            }
            Driver::Case { .. } => self.case(driver),
            Driver::Concat(parts) => self.concat(driver, parts),
            Driver::Slice { source, low } => {
                if *low > 0 {
                    self.becomes(driver, Driver::Slice { source: *source, low: low - 1 }, "slice one bit lower");
                }
                if low + self.width < self.module.signal(*source).width {
                    self.becomes(driver, Driver::Slice { source: *source, low: low + 1 }, "slice one bit higher");
                }
            }
            Driver::Alias(_) => self.inverted(),
        }
    }

    fn becomes(&mut self, was: &Driver, becomes: Driver, how: &'static str) {
        let both = |operands: (SignalId, SignalId)| operands.0 == operands.1;
        let is_same = match was {
            Driver::And(a, b) | Driver::Or(a, b) | Driver::Xor(a, b) | Driver::Less(a, b) => both((*a, *b)),
            _ => *was == becomes,
        };
        if !is_same {
            self.found.push(Change::Driver { signal: self.id, was: was.clone(), becomes, how });
        }
    }

    fn inverted(&mut self) {
        self.found.push(Change::Inverted { signal: self.id });
    }

    fn constant(&mut self, value: u64) {
        let ones = mask(self.width);
        let values = [
            (value.wrapping_add(1) & ones, "constant one more"),
            (value.wrapping_sub(1) & ones, "constant one less"),
            (value ^ 1 << (self.width - 1), "top bit of the constant flipped"),
            (value ^ 1 << (self.width / 2), "middle bit of the constant flipped"),
        ];
        for (place, &(new, how)) in values.iter().enumerate() {
            if values[..place].iter().all(|&(other, _)| other != new) {
                self.becomes(&Driver::Constant(value), Driver::Constant(new), how);
            }
        }
    }

    fn case(&mut self, driver: &Driver) {
        let Driver::Case { selector, arms, default } = driver else { return };
        let with = |arms: Vec<crate::Arm>, default: SignalId| match arms.as_slice() {
            [] => Driver::Alias(default),
            _ => Driver::Case { selector: *selector, arms, default },
        };
        for index in 0..arms.len() {
            if let Some(next) = arms.get(index + 1).filter(|next| next.value != arms[index].value) {
                let mut exchanged = arms.clone();
                (exchanged[index].value, exchanged[index + 1].value) = (next.value, arms[index].value);
                self.becomes(driver, with(exchanged, *default), "an arm exchanged with the next");
            }
            if arms[index].value != *default {
                let rest = [&arms[..index], &arms[index + 1..]].concat();
                self.becomes(driver, with(rest, *default), "an arm left out");
            }
        }
        // If every value of the selector has an arm, the default is dead.
        let labels = arms.len() as u128;
        if let Some(first) =
            arms.first().filter(|first| first.value != *default && labels < 1 << self.module.signal(*selector).width)
        {
            self.becomes(driver, with(arms.clone(), first.value), "the first arm taken by default");
        }
    }

    fn concat(&mut self, driver: &Driver, parts: &[SignalId]) {
        let signal = |id: SignalId| self.module.signal(id);
        let mut exchanged = Vec::new();
        for index in 1..parts.len() {
            let (a, b) = (parts[index - 1], parts[index]);
            let is_constant = |id| matches!(signal(id).driver, Driver::Constant(_));
            let is_same = a == b || is_constant(a) && signal(a).driver == signal(b).driver;
            if signal(a).width == signal(b).width && !is_same {
                let mut parts = parts.to_vec();
                parts.swap(index - 1, index);
                exchanged.push(Driver::Concat(parts));
            }
        }
        for becomes in exchanged {
            self.becomes(driver, becomes, "two parts of Concat exchanged");
        }
    }
}

/// The live signals and their descriptions.
struct LiveSignals<'m> {
    module: &'m Module,
    /// For each live signal, its own name, or the name of a signal that depends on it.
    readers: Vec<Option<String>>,
}

impl<'m> LiveSignals<'m> {
    fn new(module: &'m Module) -> Self {
        let mut open: Vec<(SignalId, String)> = Vec::new();
        for port in &module.outputs {
            open.push((port.signal, port.name.clone()));
        }
        for register in &module.registers {
            let name = describe(module, register.signal);
            open.extend([Some(register.next), register.enable].into_iter().flatten().map(|id| (id, name.clone())));
        }
        for memory in &module.memories {
            let inputs = memory.inputs().into_iter().enumerate();
            open.extend(inputs.map(|(input, &id)| (id, format!("{}.{}", memory.name, memory.input_name(input)))));
        }
        for instance in &module.instances {
            let ports = instance.module.inputs.iter().zip(&instance.inputs);
            open.extend(ports.map(|(port, &id)| (id, format!("{}.{}", instance.name, port.name))));
        }
        let mut readers: Vec<Option<String>> = vec![None; module.signals.len()];
        open.reverse();
        while let Some((id, reader)) = open.pop() {
            if readers[id.index()].is_some() {
                continue;
            }
            let name = module.signal(id).name.clone().unwrap_or(reader);
            open.extend(module.signal(id).driver.operands().map(|operand| (operand, name.clone())));
            readers[id.index()] = Some(name);
        }
        Self { module, readers }
    }

    fn is_live(&self, id: SignalId) -> bool {
        self.readers[id.index()].is_some()
    }

    fn name(&self, id: SignalId) -> String {
        let own = describe(self.module, id);
        match &self.readers[id.index()] {
            Some(reader) if *reader != own => format!("{own} in {reader}"),
            _ => own,
        }
    }
}
