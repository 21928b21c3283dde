use raypath_model::PipelinePosition;

/// An observer of selected cycles of a simulation. `()` selects none.
pub trait Observer {
    /// The first cycle to observe from `cycle` on, or `None` if there is no such cycle. The simulation skips idle
    /// cycles that are not observed.
    fn next_observed(&self, cycle: u64) -> Option<u64>;

    /// Observes a selected cycle. `positions` are the pipeline positions of the jobs inside at the start of the cycle,
    /// oldest first: a job that is accepted in this cycle is not among them, a job that the sink takes is the first.
    fn observe(&mut self, ports: &PortActivity, positions: impl Iterator<Item = PipelinePosition>);
}

/// The handshakes at the input and the output of the datapath in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortActivity {
    /// The number of the cycle, from 0.
    pub cycle: u64,
    /// The job that the source offers: its opcode and the number of its owner. [`simulate`](crate::simulate) numbers
    /// agents from 0 in the order in which they start.
    pub offered: Option<(u64, u64)>,
    /// Whether the datapath accepts the offered job.
    pub accepted: bool,
    /// Whether the output is valid.
    pub output_valid: bool,
    /// Whether the sink takes the output.
    pub output_taken: bool,
}

impl Observer for () {
    #[inline]
    fn next_observed(&self, _: u64) -> Option<u64> {
        None
    }
    #[inline]
    fn observe(&mut self, _: &PortActivity, _: impl Iterator<Item = PipelinePosition>) {}
}

impl<O: Observer> Observer for &mut O {
    #[inline]
    fn next_observed(&self, cycle: u64) -> Option<u64> {
        (**self).next_observed(cycle)
    }
    #[inline]
    fn observe(&mut self, ports: &PortActivity, positions: impl Iterator<Item = PipelinePosition>) {
        (**self).observe(ports, positions);
    }
}
