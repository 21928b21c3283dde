use raypath_model::Model;

/// Whatever asks the datapath for answers, one after another: a ray, a query.
///
/// Its own work takes no cycles. The harness asks it what to do ([`step`](Self::step)) when it may do something, and
/// hands it the answers to its jobs ([`answer`](Self::answer)) in the order in which it issued them, each in the cycle in
/// which the datapath's output is taken: whatever the agent is waiting for then.
pub trait Agent<M: Model> {
    /// What it does next.
    ///
    /// Asked first when it gets its place; then `memory_latency` cycles after a fetch, in the cycle after its job was
    /// accepted, and, having said [`Step::Wait`], in the cycle after each answer.
    fn step(&mut self) -> Step<M::Job>;

    /// Takes the answer to the oldest of its jobs that have none.
    fn answer(&mut self, outcome: &M::Outcome);
}

/// What an agent does next.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum Step<J> {
    /// Reads memory: it does nothing more until `memory_latency` cycles have passed.
    Fetch,
    /// Gives the datapath a job.
    Issue {
        /// The job.
        job: J,
        /// The next job that the datapath takes must be this agent's next one: beats of one vector share an
        /// accumulator. Whoever holds may fetch or wait in between, but has to issue a job before it is done.
        holds: bool,
    },
    /// Waits for the next of the answers that it has not had.
    Wait,
    /// Wants nothing more; answers that are outstanding it still gets, and keeps its place until it has had them.
    Done,
}

/// An agent that stays with its owner, who reads from it afterwards what it has found.
impl<M: Model, A: Agent<M> + ?Sized> Agent<M> for &mut A {
    #[inline]
    fn step(&mut self) -> Step<M::Job> {
        (**self).step()
    }
    #[inline]
    fn answer(&mut self, outcome: &M::Outcome) {
        (**self).answer(outcome);
    }
}
