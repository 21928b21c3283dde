//! A proof that a fault in a stage changes no job's outcome.
//!
//! Many values of a stage are don't-cares: the values that an operation leaves in registers of other operations, and
//! the operands of units that it does not use. Comparing two stages alone cannot show this; it depends on the stages
//! behind. Therefore each operation's job passes symbolically through the whole datapath, as a function of arbitrary
//! inputs and state: the control passes it on, registers hold what they have loaded, and units are uninterpreted
//! functions. In the stage with the fault the job takes every path: directly, or through the spare register, or through
//! each slot of the FIFO; in the last two cases the stage's inputs are arbitrary when the job leaves. Outputs and next
//! states must be the same functions as without the fault: by their structure, or as Yosys and ABC prove. In the stage
//! itself, with arbitrary registers, everything that affects control must be the same: enables, resets, handshakes.
//!
//! In a folded pipeline the job moves from position to position, and every register takes in each move what it loads
//! then. Jobs at least an interval away may be anywhere, but not nearer to each other than an interval.

mod folded;

use super::logic::{FALSE, Literal, Logic, TRUE, Word};
use super::mutant::Subject;
use folded::Rounds;
use raypath_hdl::{Driver, Module, RegisterInfo, SignalId};
use raypath_ops::JobKind;
use raypath_verify::Error;
use raypath_verify::sat::{ProofResult, Prover};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What the proof shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// The fault changes no job's outcome.
    None,
    /// The fault may change outcomes, but no enable, reset or handshake.
    Data,
    /// The fault may change anything; or it is in a unit or in control, or the datapath has memories.
    Any,
}

/// What a fault can change, by the proof.
pub fn effect(subject: &Subject, changed: &Arc<Module>, changed_top: &Arc<Module>) -> Result<Effect, Error> {
    let (datapath, original) = (&subject.datapath, &subject.module);
    if is_unit(original) || is_control(original) || datapath.top.memory_bits() > 0 {
        return Ok(Effect::Any);
    }
    let mut logic = Logic::default();
    let rounds = Rounds::new(&datapath.shape);
    let passes_rounds = rounds.is_some() && !is_exit(original);
    let job = |kind: JobKind| Job { opcode: kind.opcode(), path: None, rounds: None, faulty: original.name() };
    let mut open = Vec::new();
    for &kind in datapath.config.kinds() {
        let mut control = |module: &Arc<Module>| SymbolicJob::new(&mut logic, module, job(kind)).control(passes_rounds);
        open.push(unequal(control(original), control(changed)));
    }
    if !are_equal(&logic, open)? {
        return Ok(Effect::Any);
    }
    let mut open = Vec::new();
    for &kind in datapath.config.kinds() {
        for path in slot_paths(original) {
            let job = Job { path: Some(path), rounds, ..job(kind) };
            let mut outcome = |top: &Arc<Module>| SymbolicJob::new(&mut logic, top, job).outcome();
            open.push(unequal(outcome(&datapath.top), outcome(changed_top)));
        }
    }
    Ok(if are_equal(&logic, open)? { Effect::None } else { Effect::Data })
}

/// The pairs of functions that are not equal by their structure; None if the words have other widths.
fn unequal(a: Vec<Word>, b: Vec<Word>) -> Option<Vec<[Literal; 2]>> {
    let is_alike = a.iter().map(Word::len).eq(b.iter().map(Word::len));
    let bits = a.into_iter().flatten().zip(b.into_iter().flatten());
    is_alike.then(|| bits.filter(|(a, b)| a != b).map(|(a, b)| [a, b]).collect())
}

/// Whether ABC proves that the functions of each pair are equal.
fn are_equal(logic: &Logic, pairs: Vec<Option<Vec<[Literal; 2]>>>) -> Result<bool, Error> {
    let Some(pairs) = pairs.into_iter().collect::<Option<Vec<_>>>() else { return Ok(false) };
    let pairs = pairs.concat();
    if pairs.is_empty() {
        return Ok(true);
    }
    let found = Prover::find()?.solve(&[logic.miter(&pairs)], LIMIT, &AtomicBool::new(false))?;
    Ok(matches!(found.as_slice(), [ProofResult::Proved { .. }]))
}

/// The time limit of a proof by ABC.
const LIMIT: Duration = Duration::from_secs(20);

fn slot_paths(module: &Module) -> Vec<SlotPath> {
    let mut paths = vec![SlotPath::Direct];
    for instance in module.instances() {
        match instance.module.name() {
            "raypath_skid" => paths.push(SlotPath::Spare),
            "raypath_exit" => paths.extend((0..instance.module.port_width("read_o").unwrap_or(0)).map(SlotPath::Slot)),
            _ => {}
        }
    }
    paths
}

/// The path of a job through the stage with the fault.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SlotPath {
    /// Directly.
    Direct,
    /// Through the spare register of a skid buffer.
    Spare,
    /// Through this slot of the exit's FIFO.
    Slot(u32),
}

/// A moment of a job's passage through a stage. In a folded pipeline, the first three are those of the last stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Time {
    /// The job is in the registers before the stage; the stage's registers are arbitrary.
    Arriving,
    /// The job is in the spare register or FIFO; the stage's inputs are arbitrary.
    Leaving,
    /// The job is in the stage's output registers.
    After,
    /// In a folded pipeline, the job moves, and has moved so many times before: 0 at the ports.
    Moving(u32),
    /// The same, but the job waits.
    Waiting(u32),
}

/// The job and its path.
#[derive(Debug, Clone, Copy)]
struct Job<'n> {
    opcode: u64,
    /// None if registers and instances are arbitrary.
    path: Option<SlotPath>,
    /// The positions of a folded pipeline.
    rounds: Option<Rounds>,
    /// The module with the fault. In other modules the job passes directly.
    faulty: &'n str,
}

/// A module of the hierarchy, by its number, at a moment.
#[derive(Debug, Clone, Copy)]
struct At {
    scope: usize,
    time: Time,
}

/// The outermost module when the job arrives.
const OUTSIDE: At = At { scope: 0, time: Time::Arriving };

/// A hierarchy of modules while a job with one opcode passes.
struct SymbolicJob<'v> {
    logic: &'v mut Logic,
    scopes: Vec<Scope>,
    job: Job<'v>,
}

struct Scope {
    module: Arc<Module>,
    path: String,
    /// The scope and the instance that contain this scope.
    parent: Option<(usize, usize)>,
    children: Vec<Option<usize>>,
    words: HashMap<(Time, usize), Word>,
}

impl<'v> SymbolicJob<'v> {
    /// A job in a module and, if it has a path, in the stages below.
    fn new(logic: &'v mut Logic, top: &Arc<Module>, job: Job<'v>) -> Self {
        let mut new = Self { logic, scopes: Vec::new(), job };
        new.add(top, String::new(), None);
        new
    }

    /// Adds a module and, if the job passes through, the stages below.
    fn add(&mut self, module: &Arc<Module>, path: String, parent: Option<(usize, usize)>) -> usize {
        let scope = self.scopes.len();
        let (module, children, words) = (module.clone(), Vec::new(), HashMap::new());
        self.scopes.push(Scope { module: module.clone(), path, parent, children, words });
        for (number, instance) in module.instances().iter().enumerate() {
            let path = format!("{}{}.", self.scopes[scope].path, instance.name);
            let is_entered = self.job.path.is_some() && !is_unit(&instance.module) && !is_control(&instance.module);
            let child = is_entered.then(|| self.add(&instance.module, path, Some((scope, number))));
            self.scopes[scope].children.push(child);
        }
        scope
    }

    /// Everything in the module that affects control. Where a job passes rounds, `outcome` follows it in every cycle,
    /// so that a register without reset may load in others.
    fn control(&mut self, passes_rounds: bool) -> Vec<Word> {
        let module = self.scopes[0].module.clone();
        let mut words = Vec::new();
        for register in module.registers() {
            let enable = register.enable.filter(|_| !passes_rounds || register.reset.is_some());
            words.extend(enable.map(|enable| self.word(OUTSIDE, enable)));
            words.extend(register.reset.map(|_| self.next(OUTSIDE, register)));
            words.extend(register.reset.map(|reset| self.logic.constant(64, reset)));
        }
        for port in module.outputs().iter().filter(|port| is_handshake(&port.name)) {
            // The opcode is data too; `outcome` compares it.
            if port.name != "opcode_o" {
                words.push(self.word(OUTSIDE, port.signal));
            }
        }
        for instance in module.instances().iter().filter(|instance| !is_unit(&instance.module)) {
            let ports = instance.module.inputs().iter().zip(&instance.inputs);
            for (port, &id) in ports {
                if is_control(&instance.module) || is_handshake(&port.name) {
                    words.push(self.word(OUTSIDE, id));
                }
            }
        }
        words
    }

    /// The datapath's outputs, all next states, and the opcode that leaves the faulty module.
    fn outcome(&mut self) -> Vec<Word> {
        let mut words = Vec::new();
        for scope in 0..self.scopes.len() {
            let module = self.scopes[scope].module.clone();
            let is_faulty = module.name() == self.job.faulty;
            for port in module.outputs().iter().filter(|port| scope == 0 || is_faulty && port.name == "opcode_o") {
                for time in self.times_of_outputs(&module, scope) {
                    words.push(self.word(At { scope, time }, port.signal));
                }
            }
            for register in module.registers().iter().filter(|register| register.reset.is_some()) {
                for time in self.times_of_states(&module) {
                    words.push(self.next(At { scope, time }, register));
                }
            }
        }
        words
    }

    /// A register's value after the clock edge.
    fn next(&mut self, at: At, register: &RegisterInfo) -> Word {
        let enable = register.enable.map_or(TRUE, |enable| self.word(at, enable)[0]);
        match enable {
            TRUE => self.word(at, register.next),
            FALSE => self.word(at, register.signal),
            _ => {
                let (next, held) = (self.word(at, register.next), self.word(at, register.signal));
                self.logic.choose(enable, &next, &held)
            }
        }
    }

    fn word(&mut self, at: At, id: SignalId) -> Word {
        if let Some(word) = self.scopes[at.scope].words.get(&(at.time, id.index())) {
            return word.clone();
        }
        let module = self.scopes[at.scope].module.clone();
        let word = self.driven(at, &module, id);
        self.scopes[at.scope].words.insert((at.time, id.index()), word.clone());
        word
    }

    fn driven(&mut self, at: At, module: &Module, id: SignalId) -> Word {
        let signal = module.signal(id);
        let width = signal.width;
        match &signal.driver {
            Driver::Input => self.input(at, module, id),
            Driver::Register(register) => self.register(at, module, *register),
            Driver::Instance { instance, output } => self.output(at, module, *instance, *output),
            Driver::Memory { .. } => {
                let name = signal.name.as_deref().unwrap_or_default();
                self.logic.function(format!("memory {}{name} {:?}", self.scopes[at.scope].path, at.time), vec![], width)
            }
            Driver::Constant(value) => self.logic.constant(width, *value),
            Driver::Alias(a) => self.word(at, *a),
            Driver::Not(a) => self.word(at, *a).iter().map(|bit| bit ^ 1).collect(),
            Driver::And(a, b) => self.bitwise(at, [*a, *b], Logic::and),
            Driver::Or(a, b) => self.bitwise(at, [*a, *b], Logic::or),
            Driver::Xor(a, b) => self.bitwise(at, [*a, *b], Logic::xor),
            Driver::Equal(a, b) => {
                let (a, b) = (self.word(at, *a), self.word(at, *b));
                vec![self.logic.equal(&a, &b)]
            }
            Driver::All(a) => {
                let word = self.word(at, *a);
                vec![self.logic.all(&word)]
            }
            Driver::Any(a) => {
                let inverted: Word = self.word(at, *a).iter().map(|bit| bit ^ 1).collect();
                vec![self.logic.all(&inverted) ^ 1]
            }
            Driver::Mux { select, if_true, if_false } => {
                let select = self.word(at, *select)[0];
                // The branch that a constant does not select is not visited, because it may lead back to this signal.
                match select {
                    TRUE => self.word(at, *if_true),
                    FALSE => self.word(at, *if_false),
                    _ => {
                        let (a, b) = (self.word(at, *if_true), self.word(at, *if_false));
                        self.logic.choose(select, &a, &b)
                    }
                }
            }
            Driver::Case { selector, arms, default } => {
                let selector = self.word(at, *selector);
                let mut value = self.word(at, *default);
                for arm in arms {
                    let label = self.logic.constant(selector.len() as u32, arm.label.value);
                    let (is_it, arm) = (self.logic.equal(&selector, &label), self.word(at, arm.value));
                    value = self.logic.choose(is_it, &arm, &value);
                }
                value
            }
            Driver::Concat(parts) => parts.iter().rev().flat_map(|&part| self.word(at, part)).collect(),
            Driver::Slice { source, low } => self.word(at, *source)[*low as usize..(low + width) as usize].to_vec(),
            Driver::Add(a, b) => self.arithmetic(at, "add", width, [*a, *b]),
            Driver::Sub(a, b) => self.arithmetic(at, "sub", width, [*a, *b]),
            Driver::Mul(a, b) => self.arithmetic(at, "mul", width, [*a, *b]),
            Driver::Less(a, b) => self.arithmetic(at, "less", width, [*a, *b]),
            Driver::ShiftLeft(a, b) => self.arithmetic(at, "left", width, [*a, *b]),
            Driver::ShiftRight(a, b) => self.arithmetic(at, "right", width, [*a, *b]),
        }
    }

    fn bitwise(&mut self, at: At, [a, b]: [SignalId; 2], operator: fn(&mut Logic, u32, u32) -> u32) -> Word {
        let (a, b) = (self.word(at, a), self.word(at, b));
        self.logic.bitwise(&a, &b, operator)
    }

    /// The name includes the first operand's width, so that equal arguments are equal operands.
    fn arithmetic(&mut self, at: At, name: &str, width: u32, ids: [SignalId; 2]) -> Word {
        let words = ids.map(|id| self.word(at, id));
        self.logic.function(format!("{name} {width} {}", words[0].len()), words.concat(), width)
    }

    fn register(&mut self, at: At, module: &Module, register: usize) -> Word {
        let info = &module.registers()[register];
        if let (Time::Moving(moves) | Time::Waiting(moves), None) = (at.time, info.reset) {
            return self.after_moves(at.scope, info, moves);
        }
        let loads_at = match (at.time, self.path_through(module)) {
            (Time::Arriving, _) => None,
            (Time::Leaving, _) => Some(Time::Arriving),
            (Time::After, SlotPath::Direct) => Some(Time::Arriving),
            (Time::After, SlotPath::Spare | SlotPath::Slot(_)) => Some(Time::Leaving),
            (Time::Moving(_) | Time::Waiting(_), _) => None,
        };
        if let Some(before) = loads_at.filter(|_| info.reset.is_none()) {
            let loads = info.enable.is_none_or(|enable| self.word(At { time: before, ..at }, enable) == [TRUE]);
            if loads {
                return self.word(At { time: before, ..at }, info.next);
            }
        }
        // A register with reset holds its state from the job's arrival, or in a folded pipeline that of any job; others
        // hold no part of the job.
        let is_state = info.reset.is_some() && self.job.rounds.is_none();
        self.arbitrary(at.scope, info, if is_state { Time::Arriving } else { at.time })
    }

    /// The arbitrary value of a register.
    fn arbitrary(&mut self, scope: usize, info: &RegisterInfo, time: Time) -> Word {
        let Scope { module, path, .. } = &self.scopes[scope];
        let signal = module.signal(info.signal);
        let name = signal.name.as_deref().unwrap_or_default();
        self.logic.function(format!("register {path}{name} {time:?}"), vec![], signal.width)
    }

    fn input(&mut self, at: At, module: &Module, id: SignalId) -> Word {
        let width = module.signal(id).width;
        let position = module.inputs().iter().position(|port| port.signal == id);
        let Some((index, port)) = position.map(|index| (index, &module.inputs()[index])) else { return Word::new() };
        match (self.scopes[at.scope].parent, self.time_outside(module, at.time)) {
            (Some((parent, instance)), Some(time)) => {
                let outside = self.scopes[parent].module.instances()[instance].inputs[index];
                self.word(At { scope: parent, time }, outside)
            }
            (None, _) if port.name == "opcode_i" && matches!(at.time, Time::Arriving | Time::Moving(0)) => {
                self.logic.constant(width, self.job.opcode)
            }
            _ => {
                let path = &self.scopes[at.scope].path;
                self.logic.function(format!("input {path}{} {:?}", port.name, at.time), vec![], width)
            }
        }
    }

    fn path_through(&self, module: &Module) -> SlotPath {
        self.job.path.filter(|_| module.name() == self.job.faulty).unwrap_or(SlotPath::Direct)
    }

    fn output(&mut self, at: At, module: &Module, instance: usize, output: usize) -> Word {
        let info = &module.instances()[instance];
        let port = &info.module.outputs()[output];
        let width = info.module.signal(port.signal).width;
        if is_unit(&info.module) {
            let arguments = info.inputs.iter().flat_map(|&id| self.word(at, id)).collect();
            return self.logic.function(format!("unit {}.{}", info.module.name(), port.name), arguments, width);
        }
        let inside = self.scopes[at.scope].children[instance].zip(self.time_inside(&info.module, at.time));
        if let Some((child, time)) = inside {
            return self.word(At { scope: child, time }, port.signal);
        }
        let path_in_control =
            self.job.path.filter(|_| info.module.name() != "raypath_credit").map(|_| self.path_through(module));
        let known = match self.job.rounds {
            Some(rounds) if !is_exit(module) => rounds.control_value(info.module.name(), &port.name, at.time),
            _ => path_in_control.and_then(|path| control_value(&port.name, path, at.time)),
        };
        match known {
            Some(value) => self.logic.constant(width, value),
            None => {
                let name = format!("{}{}", self.scopes[at.scope].path, info.name);
                let of_another = self.of_another_job(&name, &info.module, &port.name, at.time);
                of_another.unwrap_or_else(|| self.arbitrary_output(&name, &port.name, at.time, width))
            }
        }
    }

    /// The arbitrary value of an instance's output.
    fn arbitrary_output(&mut self, instance: &str, port: &str, time: Time, width: u32) -> Word {
        self.logic.function(format!("{instance}.{port} {time:?}"), vec![], width)
    }
}

fn is_unit(module: &Module) -> bool {
    module.name().starts_with("raypath_fp_")
}

fn is_control(module: &Module) -> bool {
    matches!(module.name(), "raypath_skid" | "raypath_exit" | "raypath_credit" | "raypath_rounds")
}

/// Whether a module of a folded pipeline is its last stage.
fn is_exit(module: &Module) -> bool {
    module.instances().iter().any(|instance| matches!(instance.module.name(), "raypath_skid" | "raypath_exit"))
}

/// Whether a port belongs to the stages' handshake.
fn is_handshake(port: &str) -> bool {
    ["valid_i", "valid_o", "ready_i", "ready_o", "opcode_i", "opcode_o", "returned_i"].contains(&port)
        || port.ends_with("_written_i")
        || port.ends_with("_written_o")
        || folded::position(port).is_some()
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
