//! What a job finds in a netlist, as functions of what is arbitrary.

use super::{Time, Way, is_control, is_handshake, is_unit, passed};
use crate::mutation::logic::{FALSE, Logic, TRUE, Word};
use raypath_hdl::{Driver, Module, SignalId};
use std::sync::Arc;

/// A hierarchy as a job with one opcode finds it.
pub struct View<'v> {
    scopes: Vec<Scope>,
    opcode: u64,
    /// How jobs pass; `None` where registers and what is inside of instances may have any value.
    way: Option<Way>,
    /// The module in which they pass so; in others they pass straight through.
    faulty: &'v str,
}

struct Scope {
    module: Arc<Module>,
    path: String,
    /// The scope and the instance that it is inside of.
    parent: Option<(usize, usize)>,
    children: Vec<Option<usize>>,
    /// By time.
    words: [Vec<Option<Word>>; 3],
}

impl<'v> View<'v> {
    pub fn new(top: &Arc<Module>, opcode: u64, way: Option<Way>, faulty: &'v str) -> Self {
        let mut view = Self { scopes: Vec::new(), opcode, way, faulty };
        view.add(top, String::new(), None);
        view
    }

    /// Adds a module, and what is inside of it where jobs pass through.
    fn add(&mut self, module: &Arc<Module>, path: String, parent: Option<(usize, usize)>) -> usize {
        let scope = self.scopes.len();
        let words = [(); 3].map(|()| vec![None; module.signals().len()]);
        self.scopes.push(Scope { module: module.clone(), path, parent, children: Vec::new(), words });
        for (number, instance) in module.instances().iter().enumerate() {
            let path = format!("{}{}.", self.scopes[scope].path, instance.name);
            let is_entered = self.way.is_some() && !is_unit(&instance.module) && !is_control(&instance.module);
            let child = is_entered.then(|| self.add(&instance.module, path, Some((scope, number))));
            self.scopes[scope].children.push(child);
        }
        scope
    }

    /// All that control sees of the module, and what it lets control see.
    pub fn control(&mut self, logic: &mut Logic) -> Vec<Word> {
        let module = self.scopes[0].module.clone();
        let mut seen = Vec::new();
        for register in module.registers() {
            seen.extend(register.enable.map(|enable| self.word(logic, 0, Time::Arriving, enable)));
            seen.extend(register.reset.map(|_| self.next(logic, 0, Time::Arriving, register)));
            seen.extend(register.reset.map(|reset| logic.constant(64, reset)));
        }
        for port in module.outputs().iter().filter(|port| is_handshake(&port.name)) {
            // The opcode is data, too: with the job it is compared there.
            if port.name != "opcode_o" {
                seen.push(self.word(logic, 0, Time::Arriving, port.signal));
            }
        }
        for instance in module.instances().iter().filter(|instance| !is_unit(&instance.module)) {
            let ports = instance.module.inputs().iter().zip(&instance.inputs);
            for (port, &id) in ports {
                if is_control(&instance.module) || is_handshake(&port.name) {
                    seen.push(self.word(logic, 0, Time::Arriving, id));
                }
            }
        }
        seen
    }

    /// What leaves the datapath, and all next states; and the opcode that the faulty module hands on.
    pub fn outcome(&mut self, logic: &mut Logic) -> Vec<Word> {
        let mut seen = Vec::new();
        for scope in 0..self.scopes.len() {
            let module = self.scopes[scope].module.clone();
            let is_faulty = module.name() == self.faulty;
            for port in module.outputs().iter().filter(|port| scope == 0 || is_faulty && port.name == "opcode_o") {
                let time = if module.is_clocked() && scope != 0 { Time::After } else { Time::Arriving };
                seen.push(self.word(logic, scope, time, port.signal));
            }
            for register in module.registers().iter().filter(|register| register.reset.is_some()) {
                seen.push(self.next(logic, scope, Time::Arriving, register));
            }
        }
        seen
    }

    /// What a register holds after the edge.
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

    /// The width of the first operand is part of the name, so that arguments cannot be divided otherwise.
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
        let loads_at = match (time, self.way_through(module)) {
            (Time::Arriving, _) => None,
            (Time::Leaving, _) => Some(Time::Arriving),
            (Time::After, Way::Straight) => Some(Time::Arriving),
            (Time::After, Way::Spare | Way::Place(_)) => Some(Time::Leaving),
        };
        if let Some(before) = loads_at.filter(|_| info.reset.is_none()) {
            let loads = info.enable.is_none_or(|enable| self.word(logic, scope, before, enable) == [TRUE]);
            if loads {
                return self.word(logic, scope, before, info.next);
            }
        }
        // State is what it was when the job came, others hold something else than the job.
        let time = if info.reset.is_some() { Time::Arriving } else { time };
        let (signal, path) = (module.signal(info.signal), &self.scopes[scope].path);
        let name = signal.name.as_deref().unwrap_or_default();
        logic.function(format!("register {path}{name} {time:?}"), vec![], signal.width)
    }

    fn input(&mut self, logic: &mut Logic, scope: usize, time: Time, module: &Module, id: SignalId) -> Word {
        let width = module.signal(id).width;
        let position = module.inputs().iter().position(|port| port.signal == id);
        let Some((place, port)) = position.map(|place| (place, &module.inputs()[place])) else { return Word::new() };
        match (self.scopes[scope].parent, time) {
            (Some((parent, instance)), Time::Arriving) => {
                let outside = self.scopes[parent].module.instances()[instance].inputs[place];
                self.word(logic, parent, Time::Arriving, outside)
            }
            (None, Time::Arriving) if port.name == "opcode_i" => logic.constant(width, self.opcode),
            _ => {
                let path = &self.scopes[scope].path;
                logic.function(format!("input {path}{} {time:?}", port.name), vec![], width)
            }
        }
    }

    fn way_through(&self, module: &Module) -> Way {
        self.way.filter(|_| module.name() == self.faulty).unwrap_or(Way::Straight)
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
        let way = self.way.filter(|_| info.module.name() != "raypath_credit").map(|_| self.way_through(module));
        match way.and_then(|way| passed(&port.name, way, time)) {
            Some(value) => logic.constant(width, value),
            None => {
                let (path, name) = (&self.scopes[scope].path, &info.name);
                logic.function(format!("{path}{name}.{} {time:?}", port.name), vec![], width)
            }
        }
    }
}
