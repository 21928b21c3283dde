//! Engines that run jobs cycle by cycle: the cycle-exact model and the simulated netlist.

mod drive;
mod netlist;

pub use drive::{Seen, drive, observe};
pub use netlist::{Handshake, NetlistEngine};

use raypath_float::Format;
use raypath_model::{Control, CycleModel, Loop, Model, Shape, WordModel, Words};
use raypath_ops::PortKind;
use raypath_rtl::{self as rtl, Config, DatapathNetlist, Encoding};
use std::borrow::Borrow;

/// A datapath that is simulated cycle by cycle at its ports.
pub trait Engine {
    /// Puts a job on the input ports, where it stays until the next call.
    fn present(&mut self, job: &Words);
    /// One clock cycle, in which `input_valid_i` and `output_ready_i` have these values.
    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown;
    /// A cycle in which `rst_ni` is 0.
    fn reset(&mut self);
}

/// The values of the output ports in a cycle, before its clock edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// The outcome, if `output_valid_o` was 1.
    pub output: Option<Words>,
}

/// The counts of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Run {
    /// Clock cycles; 0 for the functional model.
    pub cycles: u64,
    /// Jobs whose outcome was taken.
    pub jobs: usize,
    /// Jobs that were withdrawn or lost in a reset.
    pub dropped: usize,
    /// Outcomes that were taken while no job was inside.
    pub spurious: usize,
}

/// The shape of the cycle-exact model of a datapath.
pub fn shape(config: Config, datapath: &DatapathNetlist) -> Shape {
    let control = match config.microarchitecture.control {
        rtl::Control::Skid => Control::Skid,
        rtl::Control::Credit => Control::Credit,
    };
    let loops = datapath.loops().into_iter().map(|found| Loop {
        opcode: found.opcode,
        first: found.first as usize,
        last: found.last as usize,
    });
    let (latency, interval) = (datapath.latency() as usize, datapath.interval() as usize);
    Shape { latency, control, interval, loops: loops.collect() }
}

/// Runs jobs through the functional model. `on_outcome` gets the position of a job and its outcome; false ends the run.
pub fn evaluate<J: Borrow<Words>>(
    mut model: WordModel,
    jobs: impl Iterator<Item = J>,
    mut on_outcome: impl FnMut(usize, Words) -> bool,
) -> Run {
    let mut run = Run::default();
    for job in jobs {
        run.jobs += 1;
        if !on_outcome(run.jobs - 1, model.run(job.borrow())) {
            break;
        }
    }
    run
}

/// The cycle-exact model as an engine.
#[derive(Debug, Clone)]
pub struct CycleEngine {
    model: CycleModel<WordModel>,
    /// The job at the input ports.
    pub(crate) presented: Option<Words>,
}

impl CycleEngine {
    /// An empty pipeline of this shape, with `model` for the outcomes.
    pub fn new(model: WordModel, shape: &Shape) -> Self {
        Self { model: CycleModel::new(model, shape), presented: None }
    }
}

impl Engine for CycleEngine {
    fn present(&mut self, job: &Words) {
        self.presented = Some(job.clone());
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        // The opcode port is 0 until the first job is presented.
        let opcode = self.presented.as_ref().map_or(0, |job| job.kind().opcode());
        let shown = Shown { input_ready: self.model.input_ready(opcode), output: self.model.output().cloned() };
        self.model.cycle(self.presented.as_ref().filter(|_| input_valid), output_ready);
        shown
    }

    fn reset(&mut self) {
        self.model.reset();
    }
}

/// The encoding of numbers at the ports of a datapath. Jobs and outcomes have numbers in the IEEE 754 layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortEncoding {
    format: Format,
    io: Encoding,
}

impl PortEncoding {
    /// The encoding of a configuration.
    pub fn of(config: Config) -> Self {
        Self { format: config.semantics.format, io: config.microarchitecture.io }
    }

    /// The bits at a port for a value. The encoding of each number of an outcome is unique.
    #[inline]
    pub fn to_port(self, kind: PortKind, bits: u64) -> u64 {
        if self.is_recoded(kind) { self.format.encode(bits) } else { bits }
    }

    /// The value of the bits at a port.
    #[inline]
    pub fn from_port(self, kind: PortKind, bits: u64) -> u64 {
        if self.is_recoded(kind) { self.format.decode(bits) } else { bits }
    }

    #[inline]
    fn is_recoded(self, kind: PortKind) -> bool {
        kind == PortKind::Number && self.io == Encoding::Recoded
    }
}
