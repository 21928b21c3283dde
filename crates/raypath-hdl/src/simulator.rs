//! Executing a netlist, cycle by cycle, as native code.

use crate::Error;
use crate::flatten::{Flat, words_in};
use crate::jit::Code;
use crate::netlist::{Module, mask};
use crate::ram::{Random, SimulatedMemory};
use std::collections::HashMap;
use std::sync::Arc;

/// A simulation of a module.
///
/// Set inputs, simulate a [`cycle`](Self::cycle), and get the values of the outputs in it. Registers begin with their
/// reset values, or 0 if they have none, as if a reset had just ended. The words of memories begin with 0.
pub struct Simulator {
    module: Arc<Module>,
    code: Code,
    /// The values of the registers, and their next values.
    current: Vec<u64>,
    next: Vec<u64>,
    /// Inputs, outputs, observed signals and inputs of memories, observed words.
    io: Vec<u64>,
    /// The number of words in `io` that `code` accesses.
    evaluated: usize,
    memories: Vec<SimulatedMemory>,
    /// The memory and the position in it of each observed word.
    words: Vec<(usize, usize)>,
    /// The width of each register, if it has no reset value.
    unreset: Vec<(usize, u32)>,
    /// The memory of `code` between evaluations.
    memory: Vec<u64>,
    /// Registers that have a reset value.
    resets: Vec<(usize, u64)>,
    reset: bool,
    /// Observed names, widths and positions in `io`.
    observed: Vec<(String, u32, usize)>,
}

/// An input of a [`Simulator`]; valid for others of the same module too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InputPort {
    pub(crate) slot: usize,
    pub(crate) mask: u64,
}

/// An output of a [`Simulator`]; valid for others of the same module too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputPort {
    pub(crate) slot: usize,
}

/// An observed signal of the [`Simulator`] that gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Probe {
    slot: usize,
}

impl Simulator {
    /// Compiles `module`. Logic on which no output depends, even through registers, is left out.
    ///
    /// # Errors
    /// A combinational loop.
    pub fn new(module: &Arc<Module>) -> Result<Self, Error> {
        Self::observing(module, |_| false)
    }

    /// Compiles `module` so that the signals, in it and inside its instances, whose hierarchical name
    /// (`u_stage_3.valid_q`) is `wanted` can be observed. Only signals with a name and output ports have one. It is the
    /// name in the printed text, with one exception: there, an instance's output without a reader is `unused_` and its
    /// name. The inputs of a memory `u_stack` are `u_stack.write_enable`, `u_stack.write_address`, `u_stack.write_node`
    /// for a column `node`, `u_stack.read_enable` and `u_stack.read_address`; its words, if there are at most 64, are
    /// `u_stack.node_3` and so on.
    pub fn observing(module: &Arc<Module>, wanted: impl Fn(&str) -> bool) -> Result<Self, Error> {
        let flat = Flat::new(module, &wanted)?;
        let inputs = module.inputs.len();
        let code = Code::new(&flat, inputs)?;
        let first = inputs + flat.outputs.len();
        let evaluated = first + flat.observed.len();
        let resets = flat.registers.iter().enumerate();
        let unreset = resets.clone().filter(|(_, register)| register.reset.is_none());
        let slots = HashMap::from_iter(flat.observed.iter().copied().zip(first..));
        let memories: Vec<_> = flat.memories.iter().map(|info| SimulatedMemory::new(&flat, info, &slots)).collect();
        let mut words = Vec::new();
        let mut observed: Vec<_> =
            flat.names.iter().map(|(name, width, slot)| (name.clone(), *width, first + slot)).collect();
        for (place, (info, memory)) in flat.memories.iter().zip(&memories).enumerate() {
            for (name, column, address) in words_in(info).into_iter().filter(|(name, ..)| wanted(name)) {
                observed.push((name, flat.nodes[column.read.index()].width, evaluated + words.len()));
                words.push((place, memory.place(column.read, address)));
            }
        }
        let mut simulator = Self {
            module: module.clone(),
            memory: vec![0; code.memory()],
            code,
            current: vec![0; flat.registers.len()],
            next: vec![0; flat.registers.len()],
            io: vec![0; evaluated + words.len()],
            evaluated,
            memories,
            words,
            unreset: unreset.map(|(place, it)| (place, flat.nodes[it.signal.index()].width)).collect(),
            resets: resets.filter_map(|(place, register)| Some((place, register.reset?))).collect(),
            reset: false,
            observed,
        };
        simulator.apply_reset();
        Ok(simulator)
    }

    /// The module that it executes.
    pub fn module(&self) -> &Arc<Module> {
        &self.module
    }

    /// The input port of this name.
    pub fn input(&self, name: &str) -> Result<InputPort, Error> {
        let slot = self.module.input_position(name)?;
        let width = self.module.signal(self.module.inputs[slot].signal).width;
        Ok(InputPort { slot, mask: mask(width) })
    }

    /// The output port of this name.
    pub fn output(&self, name: &str) -> Result<OutputPort, Error> {
        Ok(OutputPort { slot: self.module.inputs.len() + self.module.output_position(name)? })
    }

    /// Drives `rst_ni`: low if `asserted`. The reset is asynchronous: registers with a reset value take it at once,
    /// without an edge, and hold it until the reset ends. Outputs follow at the next evaluation.
    pub fn set_reset(&mut self, asserted: bool) {
        self.reset = asserted;
        if asserted {
            self.apply_reset();
        }
    }

    /// Whether the reset is asserted.
    pub fn is_reset(&self) -> bool {
        self.reset
    }

    /// Sets an input, until it is set again. Bits above its width are ignored.
    pub fn set(&mut self, input: InputPort, value: u64) {
        self.io[input.slot] = value & input.mask;
    }

    /// The value of an output at the last evaluation: in the last cycle before its clock edge, or at the last call of
    /// [`settle`](Self::settle).
    pub fn get(&self, output: OutputPort) -> u64 {
        self.io[output.slot]
    }

    /// Sets the first inputs, in the order of the module's ports, until they are set again.
    pub fn set_all(&mut self, values: impl IntoIterator<Item = u64>) {
        for (slot, (port, value)) in self.module.inputs.iter().zip(values).enumerate() {
            self.io[slot] = value & mask(self.module.signal(port.signal).width);
        }
    }

    /// The values of all outputs at the last evaluation, in the order of the module's ports.
    pub fn outputs(&self) -> &[u64] {
        &self.io[self.module.inputs.len()..][..self.module.outputs.len()]
    }

    /// Sets the first inputs, evaluates without an edge, and returns all outputs, in the order of the ports.
    pub fn evaluate(&mut self, values: impl IntoIterator<Item = u64>) -> &[u64] {
        self.set_all(values);
        self.settle();
        self.outputs()
    }

    /// One clock cycle: evaluates with the inputs as set, then the rising edge.
    pub fn cycle(&mut self) {
        self.settle();
        for memory in &mut self.memories {
            memory.edge(&self.io, &mut self.next);
        }
        std::mem::swap(&mut self.current, &mut self.next);
        if self.reset {
            self.apply_reset();
        }
    }

    /// Evaluates with the inputs as set, without an edge.
    pub fn settle(&mut self) {
        self.code.run(&self.current, &mut self.next, &mut self.io[..self.evaluated], &mut self.memory);
        for (shown, &(memory, word)) in self.io[self.evaluated..].iter_mut().zip(&self.words) {
            *shown = self.memories[memory].words[word];
        }
    }

    /// Restores the state of a new simulator: registers and memories have their initial values, and inputs are 0.
    pub fn restart(&mut self) {
        self.reset = false;
        self.current.fill(0);
        self.memories.iter_mut().for_each(|memory| memory.clear());
        self.io.fill(0);
        self.apply_reset();
    }

    /// Like [`restart`](Self::restart), but registers without a reset value and the words of memories begin with random
    /// values: what hardware shows must not depend on them.
    pub fn restart_randomly(&mut self, seed: u64) {
        self.restart();
        let mut random = Random(seed);
        for &(register, width) in &self.unreset {
            self.current[register] = random.word() & mask(width);
        }
        self.memories.iter_mut().for_each(|memory| memory.fill(&mut random));
    }

    /// Hierarchical names and widths of the signals that can be observed.
    pub fn signals(&self) -> impl Iterator<Item = (&str, u32)> {
        self.observed.iter().map(|(name, width, _)| (name.as_str(), *width))
    }

    /// Hierarchical names, widths and probes of the signals that can be observed. Signals of the same value share a
    /// probe.
    pub fn probes(&self) -> impl Iterator<Item = (&str, u32, Probe)> {
        self.observed.iter().map(|(name, width, slot)| (name.as_str(), *width, Probe { slot: *slot }))
    }

    /// The observed signal of this hierarchical name.
    pub fn observe(&self, name: &str) -> Result<Probe, Error> {
        let found = self.observed.iter().find(|(observed, ..)| observed == name);
        found.map(|&(_, _, slot)| Probe { slot }).ok_or_else(|| Error::Name {
            module: self.module.name.clone(),
            name: name.to_string(),
            problem: "is not an observed signal".to_string(),
        })
    }

    /// The value of an observed signal at the last evaluation, like [`get`](Self::get).
    pub fn peek(&self, probe: Probe) -> u64 {
        self.io[probe.slot]
    }

    fn apply_reset(&mut self) {
        for &(register, value) in &self.resets {
            self.current[register] = value;
        }
    }
}
