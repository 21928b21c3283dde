//! Bit-parallel simulation: executes a netlist for many stimuli at once. A slice holds the same bit of all stimuli.
//!
//! The gates are interpreted. A SIMD instruction or a few evaluate a gate for all stimuli, so the cost of reading the
//! gate list is small, and the same list serves every machine.

mod network;
mod operators;
mod program;
mod ram;
mod schedule;
mod transpose;

use crate::Error;
use crate::flatten::Flat;
use crate::graph::Operation;
use crate::netlist::{Column, MemoryInfo, Module, SignalId};
use crate::ram::Random;
use crate::simulator::{InputPort, OutputPort, common_methods};
use fearless_simd::{Level, Simd, dispatch};
use network::{Bit, Kind, Network};
use operators::{Bits, operator};
use program::{Function, Program};
use ram::LaneMemory;
use std::collections::HashSet;
use std::sync::Arc;
pub use transpose::LANES;
use transpose::{Slice, from_slices, to_slices};

/// A simulation of a module in [`LANES`] lanes. Each lane behaves like a [`Simulator`](crate::Simulator) of its own,
/// except that all lanes share the reset. Ports are the same as those of a `Simulator`.
///
/// ```
/// use raypath_hdl::{Builder, LANES, LaneSimulator};
///
/// let m = Builder::new("sum");
/// let (sum, step) = (m.register("sum_q", 8).reset_to(0), m.input("step_i", 8));
/// sum.next(sum.wire() + step);
/// m.output("sum_o", sum.wire());
/// let module = m.finish()?;
///
/// let mut simulator = LaneSimulator::new(&module)?;
/// let (step, sum) = (simulator.input("step_i")?, simulator.output("sum_o")?);
/// simulator.set(step, &std::array::from_fn(|lane| lane as u64 % 10));
/// simulator.cycle();
/// simulator.cycle();
/// assert_eq!(simulator.get(sum)[..12], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 1]);
/// assert_eq!(simulator.get(sum).len(), LANES);
/// # Ok::<(), raypath_hdl::Error>(())
/// ```
pub struct LaneSimulator {
    module: Arc<Module>,
    level: Level,
    evaluation: Program,
    /// Copies the next values into the registers.
    edge: Program,
    memory: Vec<Slice>,
    memories: Vec<LaneMemory>,
    /// The places of the bits of registers without a reset value, and the place after them.
    unreset: Vec<(u32, u32)>,
    /// The place of each input's lowest bit, then the place after the last input.
    inputs: Vec<u32>,
    /// The places of each output's bits.
    outputs: Vec<Vec<u32>>,
    /// Register bits that have a reset value.
    resets: Vec<(u32, Slice)>,
    reset: bool,
}

impl LaneSimulator {
    /// Prepares `module` for the widest SIMD registers of this machine. Logic on which no output depends, even through
    /// registers, is left out.
    ///
    /// # Errors
    /// A combinational loop.
    pub fn new(module: &Arc<Module>) -> Result<Self, Error> {
        let flat = Flat::new(module, &|_| false)?;
        let mut evaluation = Program::default();
        let mut functions: Vec<Function> = Vec::new();
        for (function, call) in &flat.calls {
            // Functions are in the order of their first calls.
            if *function == functions.len() {
                functions.push(add_function(&mut evaluation, &flat.functions[*function], &call.module));
            }
        }
        let mut end = functions.iter().fold(AFTER_CONSTANTS, |end, function| end.max(function.end));

        let inputs = lay_out(input_widths(module), &mut end);
        let widths = flat.registers.iter().map(|register| flat.nodes[register.signal.index()].width);
        let registers = lay_out(widths, &mut end);
        let mut network = Network::new();
        let values = values(&mut network, &flat, &inputs, &registers);

        let (mut resets, mut unreset) = (Vec::new(), Vec::new());
        for (register, places) in flat.registers.iter().zip(registers.windows(2)) {
            let Some(value) = register.reset else {
                unreset.push((places[0], places[1]));
                continue;
            };
            resets.extend((places[0]..places[1]).zip(0..).map(|(place, bit)| (place, slice(value, bit))));
        }
        let loads = loads(&mut network, &flat, &values, &registers);
        let mut kept = |output: &SignalId| values[output.index()].iter().map(|&bit| network.kept(bit)).collect();
        // What memories take at the clock edge is shown like outputs.
        let inputs_of_memories = flat.memories.iter().flat_map(MemoryInfo::inputs);
        let shown: Vec<Bits> = flat.outputs.iter().chain(inputs_of_memories).map(&mut kept).collect();
        let kept: Bits =
            loads.iter().flat_map(|load| [load.enable, load.next]).chain(shown.iter().flatten().copied()).collect();
        let (places, end) = evaluation.add(&network, &functions, &kept, end);
        let (of_loads, mut of_outputs) = places.split_at(loads.len() * 2);
        let mut edge = Program::default();
        for (load, places) in loads.iter().zip(of_loads.as_chunks::<2>().0) {
            match load.enable {
                Bit::ONE => edge.gate(Kind::Copy, &[places[1], load.place]),
                _ => edge.gate(Kind::Mux, &[places[0], places[1], load.place, load.place]),
            }
        }
        let outputs = shown.iter().map(|bits| {
            let (here, rest) = of_outputs.split_at(bits.len());
            of_outputs = rest;
            here.to_vec()
        });
        let mut outputs: Vec<Vec<u32>> = outputs.collect();
        let mut of_memories = outputs.split_off(flat.outputs.len()).into_iter();
        let mut memories = Vec::new();
        for info in &flat.memories {
            let inputs = of_memories.by_ref().take(info.inputs().len()).collect();
            let register = |column: &Column| flat.register(column.read).map(|it| registers[it]..registers[it + 1]);
            memories.push(LaneMemory::new(info.depth, inputs, info.columns.iter().filter_map(register).collect()));
        }
        let memory = vec![Slice::ZEROS; end as usize];
        let (module, level) = (module.clone(), Level::new());
        let mut simulator =
            Self { module, level, evaluation, edge, memory, memories, unreset, inputs, outputs, resets, reset: false };
        simulator.restart();
        Ok(simulator)
    }

    common_methods!();

    /// Sets an input in each lane, until it is set again. Bits above its width are ignored.
    pub fn set(&mut self, input: InputPort, values: &[u64; LANES]) {
        let slices = &mut self.memory[self.inputs[input.slot] as usize..self.inputs[input.slot + 1] as usize];
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || to_slices(values, slices)));
    }

    /// The value of an output in each lane at the last evaluation: in the last cycle before its clock edge, or at the
    /// last call of [`settle`](Self::settle).
    pub fn get(&self, output: OutputPort) -> [u64; LANES] {
        let places = &self.outputs[output.slot - self.module.inputs.len()];
        let mut slices = [Slice::ZEROS; u64::BITS as usize];
        for (slice, &place) in slices.iter_mut().zip(places) {
            *slice = self.memory[place as usize];
        }
        let slices = &slices[..places.len()];
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || from_slices(slices)))
    }

    /// One clock cycle in every lane: evaluates with the inputs as set, then the rising edge.
    pub fn cycle(&mut self) {
        self.settle();
        let (edge, memory) = (&self.edge, &mut self.memory);
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || edge.run(memory)));
        for of_lanes in &mut self.memories {
            dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || of_lanes.edge(memory)));
        }
        if self.reset {
            self.apply_reset();
        }
    }

    /// Evaluates with the inputs as set, without an edge.
    pub fn settle(&mut self) {
        let (evaluation, memory) = (&self.evaluation, &mut self.memory);
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || evaluation.run(memory)));
    }

    /// Restores the state of a new simulator: registers and memories have their initial values, and inputs are 0.
    pub fn restart(&mut self) {
        self.reset = false;
        self.memory.fill(Slice::ZEROS);
        self.memory[ONE] = Slice::ONES;
        self.memories.iter_mut().for_each(LaneMemory::clear);
        self.apply_reset();
    }

    /// Like [`restart`](Self::restart), but registers without a reset value and the words of memories begin with random
    /// values: those of a [`Simulator`](crate::Simulator) with the seed `seed` plus the number of the lane.
    pub fn restart_randomly(&mut self, seed: u64) {
        self.restart();
        let mut random: [Random; LANES] = std::array::from_fn(|lane| Random(seed.wrapping_add(lane as u64)));
        for &(first, end) in &self.unreset {
            let values = std::array::from_fn(|lane| random[lane].word());
            to_slices(&values, &mut self.memory[first as usize..end as usize]);
        }
        self.memories.iter_mut().for_each(|memory| memory.fill(&mut random));
    }

    fn apply_reset(&mut self) {
        for &(place, value) in &self.resets {
            self.memory[place as usize] = value;
        }
    }
}

/// The value that a register bit loads at the clock edge, if it is enabled.
struct Load {
    enable: Bit,
    next: Bit,
    /// The register bit's.
    place: u32,
}

/// The loads of all registers, in an order in which no load overwrites a value that a later one reads. Registers that
/// read others mostly follow them in the netlist, and so precede them here. Other values are copied first.
fn loads(network: &mut Network, flat: &Flat, values: &[Bits], registers: &[u32]) -> Vec<Load> {
    let mut loads = Vec::new();
    let mut written = HashSet::new();
    // Columns of memories keep their values here.
    let loading = flat.registers.iter().zip(registers).rev().filter(|(register, _)| register.next != register.signal);
    for (register, &first) in loading {
        let mut as_before = |bit: Bit| if written.contains(&bit) { network.kept(bit) } else { bit };
        let enable = register.enable.map_or(Bit::ONE, |enable| as_before(values[enable.index()][0]));
        let current = &values[register.signal.index()];
        let next: Bits = values[register.next.index()].iter().map(|&bit| as_before(bit)).collect();
        let own: HashSet<Bit> = current.iter().copied().collect();
        for (place, (bit, current)) in next.into_iter().zip(current).enumerate() {
            // Bits of the same register may be exchanged.
            let (enable, next) =
                [enable, bit].map(|bit| if own.contains(&bit) { network.kept(bit) } else { bit }).into();
            loads.push(Load { enable, next, place: first + place as u32 });
            written.insert(*current);
        }
    }
    loads
}

/// A bit of a value that all lanes share.
fn slice(value: u64, bit: u32) -> Slice {
    if value >> bit & 1 == 1 { Slice::ONES } else { Slice::ZEROS }
}

/// The places of the constants; [`Network::new`] has them in the same order.
const ONE: usize = 1;
const AFTER_CONSTANTS: u32 = 2;

fn input_widths(module: &Module) -> impl Iterator<Item = u32> {
    module.inputs.iter().map(|port| module.signal(port.signal).width)
}

/// Places consecutive words of these widths from `end` on. Returns the place of each word's lowest bit, and the end.
fn lay_out(widths: impl Iterator<Item = u32>, end: &mut u32) -> Vec<u32> {
    let mut places = vec![*end];
    for width in widths {
        *end += width;
        places.push(*end);
    }
    places
}

/// Adds a function to a program. All functions use the same places, because none calls another.
fn add_function(program: &mut Program, flat: &Flat, module: &Module) -> Function {
    let mut end = AFTER_CONSTANTS;
    let inputs = lay_out(input_widths(module), &mut end);
    let mut network = Network::new();
    let values = values(&mut network, flat, &inputs, &[]);
    let outputs: Bits = flat.outputs.iter().flat_map(|output| &values[output.index()]).copied().collect();
    program.function(&network, end - AFTER_CONSTANTS, &outputs, AFTER_CONSTANTS)
}

/// The bits of every node.
fn values(network: &mut Network, flat: &Flat, inputs: &[u32], registers: &[u32]) -> Vec<Bits> {
    let mut values: Vec<Bits> = Vec::with_capacity(flat.nodes.len());
    // The results of each call that has been added, by output.
    let mut answers: Vec<Option<Vec<Bits>>> = vec![None; flat.calls.len()];
    for node in &flat.nodes {
        let mut sources = |first: u32| (first..first + node.width).map(|place| network.source(place)).collect();
        let bits = match &node.operation {
            Operation::Input(input) => sources(inputs[*input]),
            Operation::Register(register) => sources(registers[*register]),
            Operation::Result { call, output } => {
                answers[*call].get_or_insert_with(|| add_call(network, flat, *call, &values))[*output].clone()
            }
            Operation::Operator(driver) => operator(network, &values, driver, node.width),
        };
        values.push(bits);
    }
    values
}

/// Adds a call and copies all its results, because the next call overwrites them.
fn add_call(network: &mut Network, flat: &Flat, call: usize, values: &[Bits]) -> Vec<Bits> {
    let (function, call) = &flat.calls[call];
    let arguments = call.inputs.iter().flat_map(|input| &values[input.index()]).copied().collect();
    let made = network.call(*function, arguments);
    let function = &flat.functions[*function];
    let mut bits = (0..).map(|bit| network.result(made, bit));
    let widths = function.outputs.iter().map(|output| function.nodes[output.index()].width as usize);
    widths.map(|width| bits.by_ref().take(width).collect()).collect()
}
