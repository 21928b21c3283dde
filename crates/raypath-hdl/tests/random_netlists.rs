//! Random netlists, compiled, against an interpreter of the netlist that shares no code with the simulator.

#[path = "common/netlists.rs"]
mod netlists;

use netlists::{Contents, netlist};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Driver, MemoryInfo, Module, SignalId, Simulator, expand_memories};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The interpreter: it evaluates a signal on demand and keeps the value for the rest of the cycle.
struct Scope<'m> {
    module: &'m Module,
    children: Vec<Scope<'m>>,
    registers: Vec<u128>,
    memories: Vec<Memory>,
    /// The values of the input ports, when known.
    inputs: Vec<Option<u128>>,
    values: Vec<Option<u128>>,
}

/// Words by address and column, and the columns that were read last.
struct Memory {
    words: Vec<Vec<u128>>,
    read: Vec<u128>,
}

impl Memory {
    fn new(info: &MemoryInfo) -> Self {
        let word = vec![0; info.columns.len()];
        Self { words: vec![word.clone(); info.depth as usize], read: word }
    }
}

impl<'m> Scope<'m> {
    fn new(module: &'m Module) -> Self {
        Self {
            module,
            children: module.instances().iter().map(|instance| Scope::new(&instance.module)).collect(),
            registers: module.registers().iter().map(|register| u128::from(register.reset.unwrap_or(0))).collect(),
            memories: module.memories().iter().map(Memory::new).collect(),
            inputs: vec![None; module.inputs().len()],
            values: vec![None; module.signals().len()],
        }
    }

    fn begin_cycle(&mut self, reset: bool) {
        self.values.fill(None);
        self.inputs.fill(None);
        for (register, info) in self.registers.iter_mut().zip(self.module.registers()) {
            if let (true, Some(value)) = (reset, info.reset) {
                *register = u128::from(value);
            }
        }
        self.children.iter_mut().for_each(|child| child.begin_cycle(reset));
    }

    /// Evaluates all signals, including those that only registers read.
    fn evaluate(&mut self) {
        for id in 0..self.module.signals().len() as u32 {
            self.value(SignalId(id));
        }
        for place in 0..self.children.len() {
            self.connect(place);
            self.children[place].evaluate();
        }
    }

    fn edge(&mut self, reset: bool) {
        for (place, info) in self.module.registers().iter().enumerate() {
            let enabled = info.enable.is_none_or(|enable| self.values[enable.index()] == Some(1));
            match info.reset {
                Some(value) if reset => self.registers[place] = u128::from(value),
                _ if enabled => self.registers[place] = self.values[info.next.index()].unwrap(),
                _ => {}
            }
        }
        for (memory, info) in self.memories.iter_mut().zip(self.module.memories()) {
            let value = |id: SignalId| self.values[id.index()].unwrap();
            if value(info.read_enable) == 1 {
                let word = memory.words.get(value(info.read_address) as usize);
                memory.read = word.cloned().unwrap_or_else(|| vec![0; info.columns.len()]);
            }
            let written = memory.words.get_mut(value(info.write_address) as usize);
            if let Some(word) = written.filter(|_| value(info.write_enable) == 1) {
                *word = info.columns.iter().map(|column| value(column.written)).collect();
            }
        }
        self.children.iter_mut().for_each(|child| child.edge(reset));
    }

    fn connect(&mut self, instance: usize) {
        let inputs = &self.module.instances()[instance].inputs;
        let values: Vec<_> = inputs.iter().map(|&id| Some(self.value(id))).collect();
        self.children[instance].inputs = values;
    }

    fn value(&mut self, id: SignalId) -> u128 {
        if let Some(value) = self.values[id.index()] {
            return value;
        }
        let signal = self.module.signal(id);
        let size = 1u128 << signal.width;
        let value = match &signal.driver {
            Driver::Input => {
                let port = self.module.inputs().iter().position(|port| port.signal == id).unwrap();
                self.inputs[port].unwrap()
            }
            Driver::Constant(value) => u128::from(*value),
            Driver::Not(a) => size - 1 - self.value(*a),
            Driver::And(a, b) => self.value(*a) & self.value(*b),
            Driver::Or(a, b) => self.value(*a) | self.value(*b),
            Driver::Xor(a, b) => self.value(*a) ^ self.value(*b),
            Driver::Add(a, b) => (self.value(*a) + self.value(*b)) % size,
            Driver::Sub(a, b) => (size + self.value(*a) - self.value(*b)) % size,
            Driver::Mul(a, b) => self.value(*a) * self.value(*b),
            Driver::Equal(a, b) => u128::from(self.value(*a) == self.value(*b)),
            Driver::Less(a, b) => u128::from(self.value(*a) < self.value(*b)),
            Driver::Any(a) => u128::from(self.value(*a) != 0),
            Driver::All(a) => u128::from(self.value(*a) == (1 << self.module.signal(*a).width) - 1),
            Driver::ShiftLeft(a, by) => (self.value(*a) << self.value(*by).min(64)) % size,
            Driver::ShiftRight(a, by) => self.value(*a) >> self.value(*by).min(64),
            Driver::Mux { select, if_true, if_false } => {
                let chosen = if self.value(*select) == 1 { if_true } else { if_false };
                self.value(*chosen)
            }
            Driver::Case { selector, arms, default } => {
                let selector = self.value(*selector);
                let arm = arms.iter().find(|arm| u128::from(arm.label.value) == selector);
                self.value(arm.map_or(*default, |arm| arm.value))
            }
            Driver::Concat(parts) => {
                parts.iter().fold(0, |all, part| (all << self.module.signal(*part).width) + self.value(*part))
            }
            Driver::Slice { source, low } => (self.value(*source) >> low) % size,
            Driver::Alias(a) => self.value(*a),
            Driver::Register(register) => self.registers[*register],
            Driver::Memory { memory, column } => self.memories[*memory].read[*column],
            Driver::Instance { instance, output } => {
                self.connect(*instance);
                let child = &mut self.children[*instance];
                child.value(child.module.outputs()[*output].signal)
            }
        };
        assert!(value < size, "the interpreter made {value} of {} bits", signal.width);
        self.values[id.index()] = Some(value);
        value
    }
}

fn random_word(random: &mut ChaCha8Rng) -> u64 {
    match random.random_range(0..4) {
        0 => 0,
        1 => u64::MAX,
        _ => random.random(),
    }
}

fn compare(module: &Arc<Module>, random: &mut ChaCha8Rng, seed: u64) {
    let mut plain = Simulator::new(module).unwrap();
    let mut observing = Simulator::observing(module, |_| true).unwrap();
    let mut scope = Scope::new(module);
    for cycle in 0..40 {
        let reset = random.random_range(0..10) == 0;
        plain.set_reset(reset);
        observing.set_reset(reset);
        scope.begin_cycle(reset);
        let words: Vec<u64> = module.inputs().iter().map(|_| random_word(random)).collect();
        plain.set_all(words.iter().copied());
        observing.set_all(words.iter().copied());
        for (place, (port, &word)) in module.inputs().iter().zip(&words).enumerate() {
            scope.inputs[place] = Some(u128::from(word) % (1 << module.signal(port.signal).width));
        }
        scope.evaluate();
        plain.cycle();
        observing.cycle();
        for (port, &word) in module.outputs().iter().zip(plain.outputs()) {
            assert_eq!(u128::from(word), scope.value(port.signal), "{} in cycle {cycle} of seed {seed}", port.name);
        }
        assert_eq!(observing.outputs(), plain.outputs(), "observing in cycle {cycle} of seed {seed}");
        compare_observed(&observing, &mut scope, "", &format!("cycle {cycle} of seed {seed}"));
        scope.edge(reset);
    }
}

/// Every named signal and every output port of a scope and those inside it.
fn compare_observed(simulator: &Simulator, scope: &mut Scope<'_>, prefix: &str, place: &str) {
    let module = scope.module;
    let signals = module.signals().iter().enumerate();
    let named = signals.filter_map(|(place, signal)| Some((signal.name.as_ref()?, SignalId(place as u32))));
    for (name, id) in named.chain(module.outputs().iter().map(|port| (&port.name, port.signal))) {
        let name = format!("{prefix}{name}");
        let shown = simulator.peek(simulator.observe(&name).unwrap());
        assert_eq!(u128::from(shown), scope.value(id), "{name} in {place}");
    }
    for (instance, child) in module.instances().iter().zip(&mut scope.children) {
        compare_observed(simulator, child, &format!("{prefix}{}.", instance.name), place);
    }
}

#[test]
fn random_netlists_agree_with_the_interpreter() {
    let mut drivers = BTreeSet::new();
    for seed in 0..30 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut module = |name, operators, registers, inside: &[Arc<Module>]| {
            let memories = registers / 5;
            netlist(name, &mut random, &Contents { operators, registers, memories, inside, constants: true })
        };
        let small = module("little", 8, 0, &[]);
        let large = module("wide", 60, 0, &[]);
        let clocked = module("clocked", 30, 5, &[large.clone(), small.clone()]);
        let top = module("top", 40, 6, &[large.clone(), clocked.clone(), large, clocked, small]);
        compare(&top, &mut random, seed);
        if seed % 10 == 0 {
            compare(&expand_memories(&top).unwrap(), &mut random, seed);
        }
        drivers.extend(top.signals().iter().map(|signal| {
            let driver = format!("{:?}", signal.driver);
            driver.split(['(', ' ']).next().unwrap_or_default().to_string()
        }));
    }
    assert_eq!(drivers.len(), 23, "every driver occurs: {drivers:?}");
}
