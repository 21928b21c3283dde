//! A network as a list of steps, each many gates of one kind, and their execution over slices.

use super::network::{Bit, Gate, Kind, Network, Two};
use super::schedule::Schedule;
use super::transpose::Slice;

/// Gates in the order of evaluation. The places of their operands and results are positions in the memory.
#[derive(Default)]
pub struct Program {
    steps: Vec<Step>,
    /// For each gate, the places of its operands, then that of its result.
    places: Vec<u32>,
}

/// Gates of one kind. A gate may read the results of earlier ones.
#[derive(Clone, Copy)]
struct Step {
    kind: Kind,
    /// In [`Program::places`].
    first: u32,
    end: u32,
}

/// A part of a program that can be executed again for other arguments.
pub struct Function {
    steps: Vec<Step>,
    /// The places of its arguments, bit by bit.
    pub inputs: Vec<u32>,
    /// The places of its results, bit by bit.
    pub outputs: Vec<u32>,
    /// The place after those that it uses.
    pub end: u32,
}

impl Program {
    /// Adds the gates that `kept` depends on. They use places from `first` on. Returns the places that hold the kept
    /// bits until the next evaluation, and the place from which on all are free.
    pub fn add(&mut self, network: &Network, functions: &[Function], kept: &[Bit], first: u32) -> (Vec<u32>, u32) {
        let Schedule { gates, order } = Schedule::new(network, kept);
        let last_readers = last_readers(network, &gates, &order, kept);
        let mut slots = SlotAllocator { free: Vec::new(), end: first };
        let mut places = vec![u32::MAX; gates.len()];
        for gate in order {
            // A result may take the place of an operand that has no later reader.
            let mut release = |operands: &[Bit], places: &[u32]| {
                for (position, &bit) in operands.iter().enumerate() {
                    let is_last = last_readers[bit.index()] == Some(gate) && !operands[..position].contains(&bit);
                    if is_last && !matches!(gates[bit.index()], Gate::Source(_)) {
                        slots.free.push(places[bit.index()]);
                    }
                }
            };
            match gates[gate] {
                Gate::Source(place) => places[gate] = place,
                Gate::Call(call) => {
                    let call = &network.calls[call as usize];
                    let function = &functions[call.function];
                    for (&bit, &place) in call.arguments.iter().zip(&function.inputs) {
                        self.gate(Kind::Copy, &[places[bit.index()], place]);
                    }
                    release(&call.arguments, &places);
                    self.steps.extend(&function.steps);
                }
                Gate::Result(call, bit) => {
                    let Gate::Call(call) = gates[call.index()] else { unreachable!("only calls have results") };
                    let answer = functions[network.calls[call as usize].function].outputs[bit as usize];
                    places[gate] = slots.allocate();
                    self.gate(Kind::Copy, &[answer, places[gate]]);
                }
                Gate::Operation(kind, operands) => {
                    let operands = &operands[..kind.operands()];
                    let mut all: Vec<u32> = operands.iter().map(|bit| places[bit.index()]).collect();
                    release(operands, &places);
                    places[gate] = slots.allocate();
                    all.push(places[gate]);
                    self.gate(kind, &all);
                }
            }
        }
        (kept.iter().map(|bit| places[bit.index()]).collect(), slots.end)
    }

    /// Adds a function of `inputs` bits, which are the sources from `first` on.
    pub fn function(&mut self, network: &Network, inputs: u32, outputs: &[Bit], first: u32) -> Function {
        let before = self.steps.len();
        let (outputs, end) = self.add(network, &[], outputs, first + inputs);
        Function { steps: self.steps.split_off(before), inputs: (first..first + inputs).collect(), outputs, end }
    }

    /// Adds a gate without merging.
    pub fn gate(&mut self, kind: Kind, places: &[u32]) {
        let first = self.places.len() as u32;
        self.places.extend(places);
        let end = self.places.len() as u32;
        match self.steps.last_mut() {
            Some(step) if step.kind == kind && step.end == first => step.end = end,
            _ => self.steps.push(Step { kind, first, end }),
        }
    }

    /// Evaluates all gates.
    #[inline(always)]
    pub fn run(&self, memory: &mut [Slice]) {
        for step in &self.steps {
            let places = &self.places[step.first as usize..step.end as usize];
            match step.kind {
                Kind::Copy => one(memory, places, |a| a),
                Kind::Not => one(memory, places, |a| !a),
                Kind::Two(Two::And) => two(memory, places, |a, b| a & b),
                Kind::Two(Two::AndNot) => two(memory, places, |a, b| a & !b),
                Kind::Two(Two::NotAnd) => two(memory, places, |a, b| !a & b),
                Kind::Two(Two::Or) => two(memory, places, |a, b| a | b),
                Kind::Two(Two::Xor) => two(memory, places, |a, b| a ^ b),
                Kind::Pair(Two::And, second) => pair(memory, places, |a, b| a & b, second),
                Kind::Pair(Two::AndNot, second) => pair(memory, places, |a, b| a & !b, second),
                Kind::Pair(Two::NotAnd, second) => pair(memory, places, |a, b| !a & b, second),
                Kind::Pair(Two::Or, second) => pair(memory, places, |a, b| a | b, second),
                Kind::Pair(Two::Xor, second) => pair(memory, places, |a, b| a ^ b, second),
                Kind::Mux => three(memory, places, |a, b, c| a & b | !a & c),
                Kind::Majority => three(memory, places, |a, b, c| a & b | c & (a | b)),
            }
        }
    }
}

#[inline(always)]
fn pair(memory: &mut [Slice], places: &[u32], first: impl Fn(u32, u32) -> u32, second: Two) {
    match second {
        Two::And => three(memory, places, |a, b, c| first(a, b) & c),
        Two::AndNot => three(memory, places, |a, b, c| first(a, b) & !c),
        Two::NotAnd => three(memory, places, |a, b, c| !first(a, b) & c),
        Two::Or => three(memory, places, |a, b, c| first(a, b) | c),
        Two::Xor => three(memory, places, |a, b, c| first(a, b) ^ c),
    }
}

#[inline(always)]
fn one(memory: &mut [Slice], places: &[u32], gate: impl Fn(u32) -> u32) {
    for &[a, out] in places.as_chunks().0 {
        let a = memory[a as usize];
        memory[out as usize] = Slice(a.0.map(&gate));
    }
}

#[inline(always)]
fn two(memory: &mut [Slice], places: &[u32], gate: impl Fn(u32, u32) -> u32) {
    for &[a, b, out] in places.as_chunks().0 {
        let (a, b) = (memory[a as usize], memory[b as usize]);
        memory[out as usize] = Slice(std::array::from_fn(|word| gate(a.0[word], b.0[word])));
    }
}

#[inline(always)]
fn three(memory: &mut [Slice], places: &[u32], gate: impl Fn(u32, u32, u32) -> u32) {
    for &[a, b, c, out] in places.as_chunks().0 {
        let (a, b, c) = (memory[a as usize], memory[b as usize], memory[c as usize]);
        memory[out as usize] = Slice(std::array::from_fn(|word| gate(a.0[word], b.0[word], c.0[word])));
    }
}

/// Allocates places for bits. It reuses released places first, so that the memory stays small.
struct SlotAllocator {
    free: Vec<u32>,
    end: u32,
}

impl SlotAllocator {
    fn allocate(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.end += 1;
            self.end - 1
        })
    }
}

/// The last reader of each gate: `usize::MAX` if it is kept, `None` if it has no reader.
fn last_readers(network: &Network, gates: &[Gate], order: &[usize], kept: &[Bit]) -> Vec<Option<usize>> {
    let mut last = vec![None; gates.len()];
    for &gate in order {
        for operand in network.operands(&gates[gate]) {
            last[operand.index()] = Some(gate);
        }
    }
    for bit in kept {
        last[bit.index()] = Some(usize::MAX);
    }
    last
}
