use crate::LATENCY;
use crate::elastic::{Elastic, Transfer};
use crate::functional::Functional;
use raypath_ops::{Job, Outcome, Rules};

/// What the datapath shows at its ports in every cycle: the same handshakes and outcomes as the netlist.
///
/// A cycle is: look at [`input_ready`](Self::input_ready) and [`output`](Self::output), then call
/// [`cycle`](Self::cycle) with what source and sink do.
#[derive(Debug, Clone)]
pub struct CycleModel<const E: usize = 16, const A: usize = 8> {
    functional: Functional<E, A>,
    pipeline: Elastic<Outcome, LATENCY>,
}

impl<const E: usize, const A: usize> CycleModel<E, A> {
    /// An empty pipeline with accumulators at zero.
    pub fn new(rules: Rules) -> Self {
        Self { functional: Functional::new(rules), pipeline: Elastic::new() }
    }

    /// `input_ready_o`: whether a job offered in this cycle will be accepted.
    pub fn input_ready(&self) -> bool {
        self.pipeline.input_ready()
    }

    /// The outcome at the output where `output_valid_o` is 1.
    pub fn output(&self) -> Option<&Outcome> {
        self.pipeline.output()
    }

    /// One clock cycle. `job` is what the source offers (`input_valid_i` = 1), accepted if `input_ready` was true.
    pub fn cycle(&mut self, job: Option<&Job<E, A>>, output_ready: bool) -> Transfer<Outcome> {
        let accepted = job.filter(|_| self.input_ready()).map(|job| self.functional.run(job));
        self.pipeline.cycle(accepted, output_ready)
    }

    /// A cycle in which `rst_ni` is 0: everything in flight is lost, the accumulators are zero.
    pub fn reset(&mut self) {
        self.functional.reset();
        self.pipeline.reset();
    }
}
