use raypath_model::Model;

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
    Issue {
        /// The job.
        job: J,
        /// Whether the agent locks the datapath until its next job is accepted, so that the beats of one vector reach
        /// the accumulator without a beat of another agent in between. The agent may fetch or wait while it has the
        /// lock, but must issue another job before it is done.
        lock: bool,
    },
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
