//! A proof that a fault in a stage changes nothing that a job can see.
//!
//! Many values of a stage matter to nobody: what an operation leaves in registers that only other operations read, what
//! it gives to units that it does not use. No comparison of two stages can tell; the stages behind must be asked. So for
//! each opcode a job goes through the datapath as a function of arbitrary inputs and state: the control passes it on,
//! registers show what they load, units are functions that nothing is known of. In the stage with the fault it takes
//! every way that there is: straight through, or by way of the spare register or each place of the FIFO. Outputs and
//! next states must come out the same as without the fault. And in the stage itself, whatever its registers hold, all
//! that control sees must be the same: enables, resets, handshakes.

use super::logic::{FALSE, Logic, TRUE, Word};
use super::trial::Trial;
use raypath_hdl::{Driver, Module, SignalId};
use std::sync::Arc;

/// Whether the fault is proven to change nothing. Of faults in units and in control it says nothing.
pub fn passes_alike(trial: &Trial<'_>) -> bool {
    let (datapath, original) = (&trial.subject.datapath, &trial.subject.module);
    if is_unit(original) || is_control(original) {
        return false;
    }
    let mut logic = Logic::default();
    datapath.config.kinds().iter().all(|kind| {
        let mut controlled = |module: &Arc<Module>| {
            let mut view = View::new(module, kind.opcode(), None, original.name());
            view.control(&mut logic)
        };
        if controlled(original) != controlled(&trial.module) {
            return false;
        }
        ways(original).into_iter().all(|way| {
            let mut seen = |top: &Arc<Module>| {
                let mut view = View::new(top, kind.opcode(), Some(way), original.name());
                view.outcome(&mut logic)
            };
            seen(&datapath.top) == seen(&trial.top)
        })
    })
}

/// How a job goes through the stage with the fault.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// At once.
    Straight,
    /// By way of the spare register of a skid buffer.
    Spare,
    /// By way of this place of the exit's FIFO.
    Place(u32),
}

fn ways(module: &Module) -> Vec<Way> {
    let mut ways = vec![Way::Straight];
    for instance in module.instances() {
        match instance.module.name() {
            "raypath_skid" => ways.push(Way::Spare),
            "raypath_exit" => ways.extend((0..instance.module.port_width("read_o").unwrap_or(0)).map(Way::Place)),
            _ => {}
        }
    }
    ways
}

fn is_unit(module: &Module) -> bool {
    module.name().starts_with("raypath_fp_")
}

fn is_control(module: &Module) -> bool {
    matches!(module.name(), "raypath_skid" | "raypath_exit" | "raypath_credit")
}

/// Ports by which stages control each other.
fn is_handshake(port: &str) -> bool {
    ["valid_i", "valid_o", "ready_i", "ready_o", "opcode_i", "opcode_o", "returned_i"].contains(&port)
        || port.ends_with("_written_i")
        || port.ends_with("_written_o")
}

/// A hierarchy as a job with one opcode finds it.
struct View<'v> {
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
    words: Vec<Option<Word>>,
}

impl<'v> View<'v> {
    fn new(top: &Arc<Module>, opcode: u64, way: Option<Way>, faulty: &'v str) -> Self {
        let mut view = Self { scopes: Vec::new(), opcode, way, faulty };
        view.add(top, String::new(), None);
        view
    }

    /// Adds a module, and what is inside of it where jobs pass through.
    fn add(&mut self, module: &Arc<Module>, path: String, parent: Option<(usize, usize)>) -> usize {
        let scope = self.scopes.len();
        let words = vec![None; module.signals().len()];
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
    fn control(&mut self, logic: &mut Logic) -> Vec<Word> {
        let module = self.scopes[0].module.clone();
        let mut seen = Vec::new();
        for register in module.registers() {
            seen.extend(register.enable.map(|enable| self.word(logic, 0, enable)));
            seen.extend(register.reset.map(|_| self.next(logic, 0, register)));
            seen.extend(register.reset.map(|reset| logic.constant(64, reset)));
        }
        for port in module.outputs().iter().filter(|port| is_handshake(&port.name)) {
            // The opcode is data, too: with the job it is compared there.
            if port.name != "opcode_o" {
                seen.push(self.word(logic, 0, port.signal));
            }
        }
        for instance in module.instances().iter().filter(|instance| !is_unit(&instance.module)) {
            let ports = instance.module.inputs().iter().zip(&instance.inputs);
            for (port, &id) in ports {
                if is_control(&instance.module) || is_handshake(&port.name) {
                    seen.push(self.word(logic, 0, id));
                }
            }
        }
        seen
    }

    /// What leaves the datapath, and all next states; and the opcode that the faulty module hands on.
    fn outcome(&mut self, logic: &mut Logic) -> Vec<Word> {
        let mut seen = Vec::new();
        for scope in 0..self.scopes.len() {
            let module = self.scopes[scope].module.clone();
            let is_faulty = module.name() == self.faulty;
            for port in module.outputs().iter().filter(|port| scope == 0 || is_faulty && port.name == "opcode_o") {
                seen.push(self.word(logic, scope, port.signal));
            }
            for register in module.registers().iter().filter(|register| register.reset.is_some()) {
                seen.push(self.next(logic, scope, register));
            }
        }
        seen
    }

    /// What a register holds after the edge.
    fn next(&mut self, logic: &mut Logic, scope: usize, register: &raypath_hdl::RegisterInfo) -> Word {
        let next = self.word(logic, scope, register.next);
        let Some(enable) = register.enable else { return next };
        let (enable, held) = (self.word(logic, scope, enable), self.word(logic, scope, register.signal));
        logic.choose(enable[0], &next, &held)
    }

    fn word(&mut self, logic: &mut Logic, scope: usize, id: SignalId) -> Word {
        if let Some(word) = &self.scopes[scope].words[id.index()] {
            return word.clone();
        }
        let module = self.scopes[scope].module.clone();
        let word = self.driven(logic, scope, &module, id);
        self.scopes[scope].words[id.index()] = Some(word.clone());
        word
    }

    fn driven(&mut self, logic: &mut Logic, scope: usize, module: &Module, id: SignalId) -> Word {
        let signal = module.signal(id);
        let width = signal.width;
        let operator = |name: &str| format!("{name} {width}");
        match &signal.driver {
            Driver::Input => self.input(logic, scope, module, id),
            Driver::Register(register) => {
                let info = &module.registers()[*register];
                match (self.way, info.reset) {
                    (Some(_), None) => self.word(logic, scope, info.next),
                    _ => {
                        let name = signal.name.as_deref().unwrap_or_default();
                        logic.function(format!("register {}{name}", self.scopes[scope].path), vec![], width)
                    }
                }
            }
            Driver::Instance { instance, output } => self.output(logic, scope, module, *instance, *output),
            Driver::Constant(value) => logic.constant(width, *value),
            Driver::Alias(a) => self.word(logic, scope, *a),
            Driver::Not(a) => self.word(logic, scope, *a).iter().map(|bit| bit ^ 1).collect(),
            Driver::And(a, b) => self.bitwise(logic, scope, [*a, *b], Logic::and),
            Driver::Or(a, b) => self.bitwise(logic, scope, [*a, *b], Logic::or),
            Driver::Xor(a, b) => self.bitwise(logic, scope, [*a, *b], Logic::xor),
            Driver::Equal(a, b) => {
                let (a, b) = (self.word(logic, scope, *a), self.word(logic, scope, *b));
                vec![logic.equal(&a, &b)]
            }
            Driver::All(a) => {
                let word = self.word(logic, scope, *a);
                vec![logic.all(&word)]
            }
            Driver::Any(a) => {
                let inverted: Word = self.word(logic, scope, *a).iter().map(|bit| bit ^ 1).collect();
                vec![logic.all(&inverted) ^ 1]
            }
            Driver::Mux { select, if_true, if_false } => {
                let select = self.word(logic, scope, *select)[0];
                // What a constant does not choose is not asked for: it may lead back to where we come from.
                match select {
                    TRUE => self.word(logic, scope, *if_true),
                    FALSE => self.word(logic, scope, *if_false),
                    _ => {
                        let (a, b) = (self.word(logic, scope, *if_true), self.word(logic, scope, *if_false));
                        logic.choose(select, &a, &b)
                    }
                }
            }
            Driver::Case { selector, arms, default } => {
                let selector = self.word(logic, scope, *selector);
                let mut value = self.word(logic, scope, *default);
                for arm in arms {
                    let label = logic.constant(selector.len() as u32, arm.label.value);
                    let (is_it, arm) = (logic.equal(&selector, &label), self.word(logic, scope, arm.value));
                    value = logic.choose(is_it, &arm, &value);
                }
                value
            }
            Driver::Concat(parts) => parts.iter().rev().flat_map(|&part| self.word(logic, scope, part)).collect(),
            Driver::Slice { source, low } => {
                self.word(logic, scope, *source)[*low as usize..(low + width) as usize].to_vec()
            }
            Driver::Add(a, b) => self.arithmetic(logic, scope, operator("add"), width, [*a, *b]),
            Driver::Sub(a, b) => self.arithmetic(logic, scope, operator("sub"), width, [*a, *b]),
            Driver::Mul(a, b) => self.arithmetic(logic, scope, operator("mul"), width, [*a, *b]),
            Driver::Less(a, b) => self.arithmetic(logic, scope, operator("less"), width, [*a, *b]),
            Driver::ShiftLeft(a, b) => self.arithmetic(logic, scope, operator("left"), width, [*a, *b]),
            Driver::ShiftRight(a, b) => self.arithmetic(logic, scope, operator("right"), width, [*a, *b]),
        }
    }

    fn bitwise(
        &mut self,
        logic: &mut Logic,
        scope: usize,
        [a, b]: [SignalId; 2],
        operator: fn(&mut Logic, u32, u32) -> u32,
    ) -> Word {
        let (a, b) = (self.word(logic, scope, a), self.word(logic, scope, b));
        logic.bitwise(&a, &b, operator)
    }

    /// The width of the first operand is part of the name, so that arguments cannot be divided otherwise.
    fn arithmetic(&mut self, logic: &mut Logic, scope: usize, name: String, width: u32, ids: [SignalId; 2]) -> Word {
        let words = ids.map(|id| self.word(logic, scope, id));
        logic.function(format!("{name} {}", words[0].len()), words.concat(), width)
    }

    fn input(&mut self, logic: &mut Logic, scope: usize, module: &Module, id: SignalId) -> Word {
        let width = module.signal(id).width;
        let position = module.inputs().iter().position(|port| port.signal == id);
        let Some((place, port)) = position.map(|place| (place, &module.inputs()[place])) else { return Word::new() };
        match self.scopes[scope].parent {
            Some((parent, instance)) => {
                let outside = self.scopes[parent].module.instances()[instance].inputs[place];
                self.word(logic, parent, outside)
            }
            None if port.name == "opcode_i" => logic.constant(width, self.opcode),
            None => logic.function(format!("input {}", port.name), vec![], width),
        }
    }

    fn output(&mut self, logic: &mut Logic, scope: usize, module: &Module, instance: usize, output: usize) -> Word {
        let info = &module.instances()[instance];
        let port = &info.module.outputs()[output];
        let width = info.module.signal(port.signal).width;
        if is_unit(&info.module) {
            let arguments = info.inputs.iter().flat_map(|&id| self.word(logic, scope, id)).collect();
            return logic.function(format!("unit {}.{}", info.module.name(), port.name), arguments, width);
        }
        if let Some(child) = self.scopes[scope].children[instance] {
            return self.word(logic, child, port.signal);
        }
        let way = self.way.map(|way| if module.name() == self.faulty { way } else { Way::Straight });
        let passed = way.filter(|_| info.module.name() != "raypath_credit").and_then(|way| passed(&port.name, way));
        match passed {
            Some(value) => logic.constant(width, value & (u64::MAX >> (64 - width))),
            None => logic.function(format!("{}{}.{}", self.scopes[scope].path, info.name, port.name), vec![], width),
        }
    }
}

/// What the control of a stage's registers shows while a job passes.
fn passed(port: &str, way: Way) -> Option<u64> {
    Some(match (port, way) {
        ("arrives_o", way) => u64::from(way == Way::Straight),
        ("from_store_o", way) => u64::from(way != Way::Straight),
        ("read_o", Way::Place(place)) => 1 << place,
        ("read_o", _) => return None,
        ("store_o", _) => u64::MAX,
        ("ready_o" | "valid_o" | "load_front_o", _) => 1,
        _ => return None,
    })
}
