//! Simulation of a design's gates for 64 streams of stimuli at once: the transitions of every net. The outputs are
//! compared in every cycle with those of the netlist that was synthesised.

use crate::Error;
use crate::gates::{Gates, NetId, ONE};
use crate::logic::{MAX_INPUTS, Output, evaluate};
use crate::netlist::Direction;
use raypath_hdl::{Module, Simulator};
use raypath_tools::ToolError;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The number of streams of a [`Workload`].
pub const STREAMS: usize = u64::BITS as usize;

/// The values at the input ports of a design, cycle by cycle, for which power is measured.
pub struct Workload {
    /// The name in reports.
    pub name: String,
    /// The jobs that the design accepts in the measured cycles of all streams; 0 if it idles.
    pub jobs: u64,
    /// The number of frames before the measured ones, in which the pipeline fills. At least 1.
    pub warm_up: usize,
    /// The stimuli, a frame per cycle, after a cycle of reset.
    pub frames: Vec<Frame>,
    /// A check of the output ports, beside the comparison with the netlist.
    pub check: Check,
}

/// Returns a message about wrong values of the output ports in a stream and a frame, by their numbers. The ports are in
/// the order of the top module.
pub type Check = Box<dyn Fn(usize, usize, &[u64]) -> Option<String> + Sync>;

/// The value of each input port in each stream, the ports in the order of the design's top module without clock and
/// reset. Bits above the width of a port are ignored.
pub type Frame = Vec<[u64; STREAMS]>;

/// The activity of the nets of a design in a workload. There are no glitches: a net changes at most once a cycle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Activity {
    /// The measured cycles of all streams together.
    pub cycles: u64,
    /// For each net the cycles in which it differs from the cycle before.
    pub toggles: Vec<u64>,
    /// For each net the cycles in which it is 1.
    pub ones: Vec<u64>,
}

/// The gates of a design beside the netlist that they were made from.
pub struct GateSimulator<'g> {
    gates: &'g Gates,
    /// The value of each net: bit i for stream i.
    values: Vec<u64>,
    /// The state of each cell that is a flip-flop.
    states: Vec<u64>,
    flip_flops: Vec<u32>,
    text: Simulator,
    inputs: Vec<&'g [NetId]>,
    outputs: Vec<(&'g str, &'g [NetId])>,
    /// The clock, and those behind clock gates. The value of a clock is whether it has a pulse in the cycle.
    clocks: Vec<NetId>,
    clock: Option<NetId>,
    reset: Option<NetId>,
}

impl<'g> GateSimulator<'g> {
    /// Prepares the simulation of `gates`, which were made from `top`.
    ///
    /// # Errors
    /// A netlist with a combinational loop, or gates without its ports.
    pub fn new(gates: &'g Gates, top: &Arc<Module>) -> Result<Self, Error> {
        let text = Simulator::new(top)?;
        let port = |name: &str, direction: Direction| {
            let found = gates.ports.iter().find(|(known, of, _)| known == name && *of == direction);
            let missing = || ToolError::unexpected("yosys", format!("no port {name}"), "the ports of the netlist");
            found.map(|(name, _, nets)| (name.as_str(), nets.as_slice())).ok_or_else(missing)
        };
        let inputs = top.inputs().iter().map(|input| Ok(port(&input.name, Direction::Input)?.1));
        let outputs = top.outputs().iter().map(|output| port(&output.name, Direction::Output));
        let is_flip_flop = |cell: &u32| gates.logic(&gates.cells[*cell as usize]).state.is_some();
        let clock = gates.input("clk_i");
        let behind_gates = gates.cells.iter().filter(|cell| gates.logic(cell).is_clock_gate);
        let clocks = behind_gates.flat_map(|cell| &cell.outputs).copied().chain(clock).collect();
        Ok(Self {
            values: vec![0; gates.nets],
            states: vec![0; gates.cells.len()],
            flip_flops: (0..gates.cells.len() as u32).filter(is_flip_flop).collect(),
            clocks,
            clock,
            reset: gates.input("rst_ni"),
            gates,
            text,
            inputs: inputs.collect::<Result<_, ToolError>>()?,
            outputs: outputs.collect::<Result<_, _>>()?,
        })
    }

    /// Runs a workload from a reset, in which all registers begin with 0. `stop` ends it early.
    ///
    /// # Errors
    /// An output that differs from the netlist's, with port, stream and cycle; [`ToolError::Stopped`].
    pub fn run(&mut self, workload: &Workload, stop: &AtomicBool) -> Result<Activity, ToolError> {
        let of_text = self.of_text(workload, stop)?;
        self.states.fill(0);
        self.values.fill(0);
        self.values[ONE as usize] = u64::MAX;
        if let Some(clock) = self.clock {
            self.values[clock as usize] = u64::MAX;
        }
        self.reset_cycle();
        let nets = self.gates.nets;
        let mut activity = Activity { cycles: 0, toggles: vec![0; nets], ones: vec![0; nets] };
        let mut before = vec![0; nets];
        for (cycle, frame) in workload.frames.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                return Err(ToolError::Stopped);
            }
            self.set(frame);
            self.settle();
            self.compare(workload, cycle, &of_text)?;
            if cycle >= workload.warm_up.max(1) {
                activity.add(&before, &self.values);
            }
            before.copy_from_slice(&self.values);
            self.clock_edge();
        }
        // A clock has two transitions in each cycle with a pulse, and is 1 in half of it.
        for clock in &self.clocks {
            let pulses = activity.ones[*clock as usize];
            (activity.toggles[*clock as usize], activity.ones[*clock as usize]) = (2 * pulses, pulses / 2);
        }
        Ok(activity)
    }

    /// What the netlist before synthesis shows at its outputs: for each stream, the ports of each frame in turn.
    fn of_text(&mut self, workload: &Workload, stop: &AtomicBool) -> Result<Vec<Vec<u64>>, ToolError> {
        let mut all = Vec::with_capacity(STREAMS);
        for stream in 0..STREAMS {
            if stop.load(Ordering::Relaxed) {
                return Err(ToolError::Stopped);
            }
            self.text.restart();
            self.text.set_reset(true);
            self.text.cycle();
            self.text.set_reset(false);
            let mut shown = Vec::with_capacity(workload.frames.len() * self.outputs.len());
            for frame in &workload.frames {
                self.text.set_all(frame.iter().map(|values| values[stream]));
                self.text.cycle();
                shown.extend_from_slice(self.text.outputs());
            }
            all.push(shown);
        }
        Ok(all)
    }

    fn reset_cycle(&mut self) {
        self.settle();
        self.clock_edge();
        if let Some(reset) = self.reset {
            self.values[reset as usize] = u64::MAX;
        }
    }

    fn set(&mut self, frame: &Frame) {
        for (nets, values) in self.inputs.iter().zip(frame) {
            for (bit, net) in nets.iter().enumerate() {
                let of_streams = values.iter().enumerate().map(|(stream, value)| (value >> bit & 1) << stream);
                self.values[*net as usize] = of_streams.sum();
            }
        }
    }

    fn settle(&mut self) {
        let mut at = [0; MAX_INPUTS];
        for index in &self.gates.order {
            let cell = &self.gates.cells[*index as usize];
            let logic = self.gates.logic(cell);
            let inputs = &mut at[..cell.inputs.len()];
            for (value, net) in inputs.iter_mut().zip(&cell.inputs) {
                *value = self.values[*net as usize];
            }
            let state = logic.state.as_ref().map_or(0, |state| {
                let [clear, preset] = [state.clear, state.preset].map(|table| evaluate(table, inputs));
                (self.states[*index as usize] | preset) & !clear
            });
            for ((_, output), net) in logic.outputs.iter().zip(&cell.outputs) {
                self.values[*net as usize] = match output {
                    Output::Table(table) => evaluate(*table, inputs),
                    Output::State => state,
                    Output::Complement => !state,
                };
            }
        }
    }

    fn clock_edge(&mut self) {
        let mut at = [0; MAX_INPUTS];
        for index in &self.flip_flops {
            let cell = &self.gates.cells[*index as usize];
            let inputs = &mut at[..cell.inputs.len()];
            for (value, net) in inputs.iter_mut().zip(&cell.inputs) {
                *value = self.values[*net as usize];
            }
            let logic = self.gates.logic(cell);
            let pulse = logic.clock.map_or(u64::MAX, |clock| inputs[clock.input]);
            if let Some(state) = &logic.state {
                let [next, clear, preset] =
                    [state.next, state.clear, state.preset].map(|table| evaluate(table, inputs));
                let loaded = (next & pulse) | (self.states[*index as usize] & !pulse);
                self.states[*index as usize] = (loaded | preset) & !clear;
            }
        }
    }

    fn compare(&self, workload: &Workload, cycle: usize, of_text: &[Vec<u64>]) -> Result<(), ToolError> {
        let at = |stream| format!("in cycle {cycle} of {}, stream {stream}", workload.name);
        let mut values = vec![0; self.outputs.len()];
        for stream in 0..STREAMS {
            for (value, (_, nets)) in values.iter_mut().zip(&self.outputs) {
                let bits = nets.iter().enumerate();
                *value = bits.map(|(bit, net)| (self.values[*net as usize] >> stream & 1) << bit).sum();
            }
            let of_text = &of_text[stream][cycle * self.outputs.len()..];
            for ((name, ..), (found, &expected)) in self.outputs.iter().zip(values.iter().zip(of_text)) {
                if *found != expected {
                    let found = format!("{name} is {found:x} {}", at(stream));
                    let expected = format!("{expected:x} as in the netlist before synthesis");
                    return Err(ToolError::unexpected("yosys", found, expected));
                }
            }
            if let Some(wrong) = (workload.check)(stream, cycle, &values) {
                return Err(ToolError::unexpected("yosys", format!("{} {wrong}", at(stream)), "the model's outputs"));
            }
        }
        Ok(())
    }
}

impl Activity {
    fn add(&mut self, before: &[u64], now: &[u64]) {
        self.cycles += STREAMS as u64;
        let counts = self.toggles.iter_mut().zip(&mut self.ones);
        for ((toggles, ones), (before, now)) in counts.zip(before.iter().zip(now)) {
            *toggles += u64::from((before ^ now).count_ones());
            *ones += u64::from(now.count_ones());
        }
    }
}
