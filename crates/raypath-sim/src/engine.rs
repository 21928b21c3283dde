//! Engines that carry jobs through the datapath: the functional model, the cycle-exact one, and the netlist itself.

mod drive;
mod encoding;
mod netlist;

pub use drive::{Seen, drive, observe};
pub use encoding::PortEncoding;
pub use netlist::{Handshake, NetlistEngine};

use raypath_model::{Control, CycleModel, Loop, Model, Shape, WordModel, Words};
use raypath_rtl::{self as rtl, Config, Datapath};
use std::borrow::Borrow;

/// A datapath as seen from outside, cycle by cycle.
pub trait Engine {
    /// Puts a job on the input ports, where it stays until the next.
    fn present(&mut self, job: &Words);
    /// One clock cycle, in which `input_valid_i` and `output_ready_i` have these values.
    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown;
    /// A cycle in which `rst_ni` is 0.
    fn reset(&mut self);
}

/// What the ports showed in a cycle, before its clock edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// The outcome, where `output_valid_o` was 1.
    pub output: Option<Words>,
}

/// What a run took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Run {
    /// Clock cycles; 0 where the engine knows no time.
    pub cycles: u64,
    /// Jobs that came out.
    pub jobs: usize,
    /// Jobs that could not come out: withdrawn, or lost in a reset.
    pub dropped: usize,
    /// Outcomes that came out with no job inside.
    pub spurious: usize,
}

/// When a configuration's datapath shows what: how its cycle-exact model is shaped.
pub fn shape(config: Config, datapath: &Datapath) -> Shape {
    let control = match config.microarchitecture.control {
        rtl::Control::Skid => Control::Skid,
        rtl::Control::Credit => Control::Credit,
    };
    let loops = datapath.loops().into_iter().map(|found| Loop {
        opcode: found.opcode,
        first: found.first as usize,
        last: found.last as usize,
    });
    Shape { latency: datapath.latency() as usize, control, loops: loops.collect() }
}

/// Answers jobs without time, until `on_outcome` answers false.
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
    presented: Option<Words>,
}

impl CycleEngine {
    /// An empty pipeline of this shape, which answers as `model` does.
    pub fn new(model: WordModel, shape: &Shape) -> Self {
        Self { model: CycleModel::new(model, shape), presented: None }
    }
}

impl Engine for CycleEngine {
    fn present(&mut self, job: &Words) {
        self.presented = Some(job.clone());
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        // Before any job is there the port for the opcode is 0.
        let opcode = self.presented.as_ref().map_or(0, |job| job.kind().opcode());
        let shown = Shown { input_ready: self.model.input_ready(opcode), output: self.model.output().cloned() };
        self.model.cycle(self.presented.as_ref().filter(|_| input_valid), output_ready);
        shown
    }

    fn reset(&mut self) {
        self.model.reset();
    }
}
