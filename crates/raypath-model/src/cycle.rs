use crate::{Elastic, Functional, Kind, Model, PipelinePosition, Shape, Transfer};

/// The cycle-exact model of a datapath: in every cycle its ports show the same handshakes and outcomes as the netlist.
///
/// To simulate a cycle, read [`input_ready`](Self::input_ready) and [`output`](Self::output), then call
/// [`cycle`](Self::cycle) with the actions of source and sink.
#[derive(Debug, Clone)]
pub struct CycleModel<M: Model = Functional> {
    model: M,
    pipeline: Elastic<M::Outcome>,
}

impl<M: Model> CycleModel<M> {
    /// An empty pipeline of this shape whose outcomes `model` computes.
    pub fn new(model: M, shape: &Shape) -> Self {
        Self { model, pipeline: Elastic::new(shape) }
    }

    /// `input_ready_o` while `opcode_i` has this value: whether a job will be accepted if it is offered in this cycle.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.pipeline.input_ready(opcode)
    }

    /// The outcome at the output, if `output_valid_o` is 1.
    #[inline]
    pub fn output(&self) -> Option<&M::Outcome> {
        self.pipeline.output()
    }

    /// One clock cycle. The source offers `job` (`input_valid_i` = 1), which is accepted if `input_ready` was true for
    /// its opcode. The sink takes the outcome at the output if `output_ready`.
    #[inline]
    pub fn cycle(&mut self, job: Option<&M::Job>, output_ready: bool) -> Transfer<M::Outcome> {
        let Self { model, pipeline } = self;
        match job {
            Some(job) => pipeline.cycle_with(Some(M::kind(job).opcode()), || model.run(job), output_ready),
            None => pipeline.cycle_with(None, || unreachable!("nothing is offered"), output_ready),
        }
    }

    /// Advances up to `limit` cycles in which the source offers nothing, and stops in the first with a valid output.
    /// Returns the number of cycles. Equivalent to that many calls of [`cycle`](Self::cycle), but faster.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        self.pipeline.idle(limit)
    }

    /// The positions of the jobs in the pipeline, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        self.pipeline.positions()
    }

    /// A cycle in which `rst_ni` is 0: all jobs in flight are lost, and the accumulators are zero.
    pub fn reset(&mut self) {
        self.model.reset();
        self.pipeline.reset();
    }
}
