use raypath_model::{Model, PipelinePosition};

/// A client of the datapath, such as a ray or a query: it reads memory, issues jobs and waits for their outcomes.
///
/// Computation inside the agent takes no cycles. [`simulate`](crate::simulate) calls [`next_action`](Self::next_action)
/// when the agent may act, and [`receive`](Self::receive) with the outcomes of its jobs, in the order of issue, each in
/// the cycle in which the sink takes it. An outcome may arrive while the agent is fetching or waiting for the datapath.
pub trait Agent<M: Model> {
    /// The next action.
    ///
    /// The simulation asks for it when the agent starts, `memory_latency` cycles after a fetch, in the cycle after a
    /// job was accepted and, after [`Action::Wait`], in the cycle after each outcome.
    fn next_action(&mut self) -> Action<M::Job>;

    /// Receives the outcome of the agent's oldest outstanding job.
    fn receive(&mut self, outcome: &M::Outcome);
}

/// An action of an [`Agent`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum Action<J> {
    /// Read memory. The next action follows `memory_latency` cycles later.
    Fetch,
    /// Issue a job to the datapath.
    Issue(J),
    /// Wait for the next outcome.
    Wait,
    /// Nothing more to do. The agent still receives outstanding outcomes and occupies its slot until then.
    Done,
}

/// A borrowed agent: the owner can read its state after the simulation.
impl<M: Model, A: Agent<M> + ?Sized> Agent<M> for &mut A {
    #[inline]
    fn next_action(&mut self) -> Action<M::Job> {
        (**self).next_action()
    }
    #[inline]
    fn receive(&mut self, outcome: &M::Outcome) {
        (**self).receive(outcome);
    }
}

/// An observer of selected cycles of a simulation. `()` selects none.
pub trait Observer {
    /// The first cycle to observe from `cycle` on, if any. The simulation skips idle cycles that are not observed.
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
