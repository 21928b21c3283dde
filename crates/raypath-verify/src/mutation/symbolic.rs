//! A job that passes symbolically through a netlist.

use super::logic::{FALSE, Logic, TRUE, Word};
use raypath_hdl::{Driver, Module, SignalId};
use std::sync::Arc;

/// The path of a job through the stage with the fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SlotPath {
    /// Directly.
    Direct,
    /// Through the spare register of a skid buffer.
    Spare,
    /// Through this slot of the exit's FIFO.
    Slot(u32),
}

/// A moment of a job's passage through a stage.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Time {
    /// The job is in the registers before the stage; the stage's registers are arbitrary.
    Arriving,
    /// The job is in the spare register or FIFO; the stage's inputs are arbitrary.
    Leaving,
    /// The job is in the stage's output registers.
    After,
}

/// A hierarchy of modules while a job with one opcode passes.
pub struct SymbolicJob<'v> {
    scopes: Vec<Scope>,
    opcode: u64,
    /// The job's path; none if registers and instances are arbitrary.
    path: Option<SlotPath>,
    /// The module with the fault. In other modules the job passes directly.
    faulty: &'v str,
}

struct Scope {
    module: Arc<Module>,
    path: String,
    /// The scope and the instance that contain this scope.
    parent: Option<(usize, usize)>,
    children: Vec<Option<usize>>,
    /// The signals' words by moment.
    words: [Vec<Option<Word>>; 3],
}

impl<'v> SymbolicJob<'v> {
    /// A job in a module and, if it has a path, in the stages below.
    pub fn new(top: &Arc<Module>, opcode: u64, path: Option<SlotPath>, faulty: &'v str) -> Self {
        let mut job = Self { scopes: Vec::new(), opcode, path, faulty };
        job.add(top, String::new(), None);
        job
    }

    /// Adds a module and, if the job passes through, the stages below.
    fn add(&mut self, module: &Arc<Module>, path: String, parent: Option<(usize, usize)>) -> usize {
        let scope = self.scopes.len();
        let words = [(); 3].map(|()| vec![None; module.signals().len()]);
        self.scopes.push(Scope { module: module.clone(), path, parent, children: Vec::new(), words });
        for (number, instance) in module.instances().iter().enumerate() {
            let path = format!("{}{}.", self.scopes[scope].path, instance.name);
            let is_entered = self.path.is_some() && !is_unit(&instance.module) && !is_control(&instance.module);
            let child = is_entered.then(|| self.add(&instance.module, path, Some((scope, number))));
            self.scopes[scope].children.push(child);
        }
        scope
    }

    /// Everything in the module that affects control.
    pub fn control(&mut self, logic: &mut Logic) -> Vec<Word> {
        let module = self.scopes[0].module.clone();
        let mut words = Vec::new();
        for register in module.registers() {
            words.extend(register.enable.map(|enable| self.word(logic, 0, Time::Arriving, enable)));
            words.extend(register.reset.map(|_| self.next(logic, 0, Time::Arriving, register)));
            words.extend(register.reset.map(|reset| logic.constant(64, reset)));
        }
        for port in module.outputs().iter().filter(|port| is_handshake(&port.name)) {
            // The opcode is data too; `outcome` compares it.
            if port.name != "opcode_o" {
                words.push(self.word(logic, 0, Time::Arriving, port.signal));
            }
        }
        for instance in module.instances().iter().filter(|instance| !is_unit(&instance.module)) {
            let ports = instance.module.inputs().iter().zip(&instance.inputs);
            for (port, &id) in ports {
                if is_control(&instance.module) || is_handshake(&port.name) {
                    words.push(self.word(logic, 0, Time::Arriving, id));
                }
            }
        }
        words
    }

    /// The datapath's outputs, all next states, and the opcode that leaves the faulty module.
    pub fn outcome(&mut self, logic: &mut Logic) -> Vec<Word> {
        let mut words = Vec::new();
        for scope in 0..self.scopes.len() {
            let module = self.scopes[scope].module.clone();
            let is_faulty = module.name() == self.faulty;
            for port in module.outputs().iter().filter(|port| scope == 0 || is_faulty && port.name == "opcode_o") {
                let time = if module.is_clocked() && scope != 0 { Time::After } else { Time::Arriving };
                words.push(self.word(logic, scope, time, port.signal));
            }
            for register in module.registers().iter().filter(|register| register.reset.is_some()) {
                words.push(self.next(logic, scope, Time::Arriving, register));
            }
        }
        words
    }

    /// A register's value after the clock edge.
    fn next(&mut self, logic: &mut Logic, scope: usize, time: Time, register: &raypath_hdl::RegisterInfo) -> Word {
        let next = self.word(logic, scope, time, register.next);
        let Some(enable) = register.enable else { return next };
        let (enable, held) = (self.word(logic, scope, time, enable), self.word(logic, scope, time, register.signal));
        logic.choose(enable[0], &next, &held)
    }

    fn word(&mut self, logic: &mut Logic, scope: usize, time: Time, id: SignalId) -> Word {
        if let Some(word) = &self.scopes[scope].words[time as usize][id.index()] {
            return word.clone();
        }
        let module = self.scopes[scope].module.clone();
        let word = self.driven(logic, scope, time, &module, id);
        self.scopes[scope].words[time as usize][id.index()] = Some(word.clone());
        word
    }

    fn driven(&mut self, logic: &mut Logic, scope: usize, time: Time, module: &Module, id: SignalId) -> Word {
        let signal = module.signal(id);
        let width = signal.width;
        let operator = |name: &str| format!("{name} {width}");
        match &signal.driver {
            Driver::Input => self.input(logic, scope, time, module, id),
            Driver::Register(register) => self.register(logic, scope, time, module, *register),
            Driver::Instance { instance, output } => self.output(logic, scope, time, module, *instance, *output),
            Driver::Constant(value) => logic.constant(width, *value),
            Driver::Alias(a) => self.word(logic, scope, time, *a),
            Driver::Not(a) => self.word(logic, scope, time, *a).iter().map(|bit| bit ^ 1).collect(),
            Driver::And(a, b) => self.bitwise(logic, scope, time, [*a, *b], Logic::and),
            Driver::Or(a, b) => self.bitwise(logic, scope, time, [*a, *b], Logic::or),
            Driver::Xor(a, b) => self.bitwise(logic, scope, time, [*a, *b], Logic::xor),
            Driver::Equal(a, b) => {
                let (a, b) = (self.word(logic, scope, time, *a), self.word(logic, scope, time, *b));
                vec![logic.equal(&a, &b)]
            }
            Driver::All(a) => {
                let word = self.word(logic, scope, time, *a);
                vec![logic.all(&word)]
            }
            Driver::Any(a) => {
                let inverted: Word = self.word(logic, scope, time, *a).iter().map(|bit| bit ^ 1).collect();
                vec![logic.all(&inverted) ^ 1]
            }
            Driver::Mux { select, if_true, if_false } => {
                let select = self.word(logic, scope, time, *select)[0];
                // What a constant does not choose is not asked for: it may lead back to where we come from.
                match select {
                    TRUE => self.word(logic, scope, time, *if_true),
                    FALSE => self.word(logic, scope, time, *if_false),
                    _ => {
                        let (a, b) =
                            (self.word(logic, scope, time, *if_true), self.word(logic, scope, time, *if_false));
                        logic.choose(select, &a, &b)
                    }
                }
            }
            Driver::Case { selector, arms, default } => {
                let selector = self.word(logic, scope, time, *selector);
                let mut value = self.word(logic, scope, time, *default);
                for arm in arms {
                    let label = logic.constant(selector.len() as u32, arm.label.value);
                    let (is_it, arm) = (logic.equal(&selector, &label), self.word(logic, scope, time, arm.value));
                    value = logic.choose(is_it, &arm, &value);
                }
                value
            }
            Driver::Concat(parts) => parts.iter().rev().flat_map(|&part| self.word(logic, scope, time, part)).collect(),
            Driver::Slice { source, low } => {
                self.word(logic, scope, time, *source)[*low as usize..(low + width) as usize].to_vec()
            }
            Driver::Add(a, b) => self.arithmetic(logic, scope, time, operator("add"), width, [*a, *b]),
            Driver::Sub(a, b) => self.arithmetic(logic, scope, time, operator("sub"), width, [*a, *b]),
            Driver::Mul(a, b) => self.arithmetic(logic, scope, time, operator("mul"), width, [*a, *b]),
            Driver::Less(a, b) => self.arithmetic(logic, scope, time, operator("less"), width, [*a, *b]),
            Driver::ShiftLeft(a, b) => self.arithmetic(logic, scope, time, operator("left"), width, [*a, *b]),
            Driver::ShiftRight(a, b) => self.arithmetic(logic, scope, time, operator("right"), width, [*a, *b]),
        }
    }

    fn bitwise(
        &mut self,
        logic: &mut Logic,
        scope: usize,
        time: Time,
        [a, b]: [SignalId; 2],
        operator: fn(&mut Logic, u32, u32) -> u32,
    ) -> Word {
        let (a, b) = (self.word(logic, scope, time, a), self.word(logic, scope, time, b));
        logic.bitwise(&a, &b, operator)
    }

    /// The name includes the first operand's width, so that equal arguments are equal operands.
    fn arithmetic(
        &mut self,
        logic: &mut Logic,
        scope: usize,
        time: Time,
        name: String,
        width: u32,
        ids: [SignalId; 2],
    ) -> Word {
        let words = ids.map(|id| self.word(logic, scope, time, id));
        logic.function(format!("{name} {}", words[0].len()), words.concat(), width)
    }

    fn register(&mut self, logic: &mut Logic, scope: usize, time: Time, module: &Module, register: usize) -> Word {
        let info = &module.registers()[register];
        let loads_at = match (time, self.path_through(module)) {
            (Time::Arriving, _) => None,
            (Time::Leaving, _) => Some(Time::Arriving),
            (Time::After, SlotPath::Direct) => Some(Time::Arriving),
            (Time::After, SlotPath::Spare | SlotPath::Slot(_)) => Some(Time::Leaving),
        };
        if let Some(before) = loads_at.filter(|_| info.reset.is_none()) {
            let loads = info.enable.is_none_or(|enable| self.word(logic, scope, before, enable) == [TRUE]);
            if loads {
                return self.word(logic, scope, before, info.next);
            }
        }
        // A register with reset holds its state from the job's arrival; others hold no part of the job.
        let time = if info.reset.is_some() { Time::Arriving } else { time };
        let (signal, path) = (module.signal(info.signal), &self.scopes[scope].path);
        let name = signal.name.as_deref().unwrap_or_default();
        logic.function(format!("register {path}{name} {time:?}"), vec![], signal.width)
    }

    fn input(&mut self, logic: &mut Logic, scope: usize, time: Time, module: &Module, id: SignalId) -> Word {
        let width = module.signal(id).width;
        let position = module.inputs().iter().position(|port| port.signal == id);
        let Some((index, port)) = position.map(|index| (index, &module.inputs()[index])) else { return Word::new() };
        match (self.scopes[scope].parent, time) {
            (Some((parent, instance)), Time::Arriving) => {
                let outside = self.scopes[parent].module.instances()[instance].inputs[index];
                self.word(logic, parent, Time::Arriving, outside)
            }
            (None, Time::Arriving) if port.name == "opcode_i" => logic.constant(width, self.opcode),
            _ => {
                let path = &self.scopes[scope].path;
                logic.function(format!("input {path}{} {time:?}", port.name), vec![], width)
            }
        }
    }

    /// The job's path through a module.
    fn path_through(&self, module: &Module) -> SlotPath {
        self.path.filter(|_| module.name() == self.faulty).unwrap_or(SlotPath::Direct)
    }

    fn output(
        &mut self,
        logic: &mut Logic,
        scope: usize,
        time: Time,
        module: &Module,
        instance: usize,
        output: usize,
    ) -> Word {
        let info = &module.instances()[instance];
        let port = &info.module.outputs()[output];
        let width = info.module.signal(port.signal).width;
        if is_unit(&info.module) {
            let arguments = info.inputs.iter().flat_map(|&id| self.word(logic, scope, time, id)).collect();
            return logic.function(format!("unit {}.{}", info.module.name(), port.name), arguments, width);
        }
        if let Some(child) = self.scopes[scope].children[instance] {
            let time = if info.module.is_clocked() { Time::After } else { Time::Arriving };
            return self.word(logic, child, time, port.signal);
        }
        let path_in_control =
            self.path.filter(|_| info.module.name() != "raypath_credit").map(|_| self.path_through(module));
        match path_in_control.and_then(|path| control_value(&port.name, path, time)) {
            Some(value) => logic.constant(width, value),
            None => {
                let (path, name) = (&self.scopes[scope].path, &info.name);
                logic.function(format!("{path}{name}.{} {time:?}", port.name), vec![], width)
            }
        }
    }
}

/// Whether a module is a floating-point unit.
pub fn is_unit(module: &Module) -> bool {
    module.name().starts_with("raypath_fp_")
}

/// Whether a module is control.
pub fn is_control(module: &Module) -> bool {
    matches!(module.name(), "raypath_skid" | "raypath_exit" | "raypath_credit")
}

/// Whether a port belongs to the stages' handshake.
fn is_handshake(port: &str) -> bool {
    ["valid_i", "valid_o", "ready_i", "ready_o", "opcode_i", "opcode_o", "returned_i"].contains(&port)
        || port.ends_with("_written_i")
        || port.ends_with("_written_o")
}

/// The output of a stage's control while a job passes; none if the job does not depend on it.
fn control_value(port: &str, path: SlotPath, time: Time) -> Option<u64> {
    match (time, port, path) {
        (Time::Arriving, "ready_o" | "arrives_o", _) => Some(1),
        (Time::Arriving, "load_front_o", path) => Some((path == SlotPath::Direct).into()),
        (Time::Arriving, "from_store_o" | "store_o", SlotPath::Direct) => Some(0),
        (Time::Arriving, "store_o", SlotPath::Slot(slot)) | (Time::Leaving, "read_o", SlotPath::Slot(slot)) => {
            Some(1 << slot)
        }
        (Time::Leaving, "arrives_o", _) => Some(0),
        (Time::Leaving, "load_front_o" | "from_store_o", _) | (Time::After, "valid_o", _) => Some(1),
        _ => None,
    }
}
