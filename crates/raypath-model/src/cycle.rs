use crate::elastic::{Elastic, Transfer};
use crate::functional::Functional;
use crate::model::{Kind, Model, OnPorts};
use crate::places::Place;
use crate::shape::Shape;

/// What the datapath shows at its ports in every cycle: the same handshakes and outcomes as the netlist.
///
/// A cycle is: look at [`input_ready`](Self::input_ready) and [`output`](Self::output), then call
/// [`cycle`](Self::cycle) with what source and sink do.
#[derive(Debug, Clone)]
pub struct CycleModel<M: Model = Functional> {
    model: M,
    pipeline: Elastic<M::Outcome>,
}

impl<M: Model> CycleModel<M> {
    /// An empty pipeline of this shape, which answers as `model` does.
    pub fn new(model: M, shape: &Shape) -> Self {
        Self { model, pipeline: Elastic::new(shape) }
    }

    /// `input_ready_o` with this on the port `opcode_i`: whether a job, offered in this cycle, will be accepted.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.pipeline.input_ready(opcode)
    }

    /// The outcome at the output where `output_valid_o` is 1.
    #[inline]
    pub fn output(&self) -> Option<&M::Outcome> {
        self.pipeline.output()
    }

    /// One clock cycle. `job` is what the source offers (`input_valid_i` = 1), accepted if `input_ready` was true for
    /// its opcode.
    #[inline]
    pub fn cycle(&mut self, job: Option<&M::Job>, output_ready: bool) -> Transfer<M::Outcome> {
        let Self { model, pipeline } = self;
        match job {
            Some(job) => pipeline.cycle_with(Some(job.kind().opcode()), || model.run(job), output_ready),
            None => pipeline.cycle_with(None, || unreachable!("nothing is offered"), output_ready),
        }
    }

    /// Lets up to `limit` cycles pass in which the source offers nothing, and stops in the first that has an output.
    /// Answers how many have passed. The same as so many calls of [`cycle`](Self::cycle), in next to no time: what a
    /// simulator calls that knows when its next job comes.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        self.pipeline.idle(limit)
    }

    /// Where the jobs inside are, oldest first.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        self.pipeline.places()
    }

    /// A cycle in which `rst_ni` is 0: everything in flight is lost, the accumulators are zero.
    pub fn reset(&mut self) {
        self.model.reset();
        self.pipeline.reset();
    }
}
