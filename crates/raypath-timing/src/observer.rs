use raypath_model::PipelinePosition;

/// Looks on, cycle by cycle, in the cycles that it wants to see. `()` wants none.
pub trait Observer {
    /// The first cycle from this one on that it wants to see, none where it has seen enough. Idle cycles that nobody
    /// wants to see are skipped, not walked: an observer costs time only while it looks.
    fn wants(&self, cycle: u64) -> Option<u64>;

    /// A cycle that it wanted to see. `places` says where the jobs inside are during it, oldest first: the job that is
    /// accepted in it is not among them, and the one that is taken is the first.
    fn cycle(&mut self, cycle: &Cycle, places: impl Iterator<Item = PipelinePosition>);
}

/// What happens at the datapath's ends in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cycle {
    /// Which cycle, the first being 0.
    pub number: u64,
    /// What the source offers: its opcode, and whose it is (agents are numbered from 0 in the order in which they begin).
    pub offered: Option<(u64, u64)>,
    /// What is offered is accepted.
    pub accepted: bool,
    /// The output shows an answer.
    pub shown: bool,
    /// The sink takes it.
    pub taken: bool,
}

impl Observer for () {
    #[inline]
    fn wants(&self, _: u64) -> Option<u64> {
        None
    }
    #[inline]
    fn cycle(&mut self, _: &Cycle, _: impl Iterator<Item = PipelinePosition>) {}
}

impl<O: Observer> Observer for &mut O {
    #[inline]
    fn wants(&self, cycle: u64) -> Option<u64> {
        (**self).wants(cycle)
    }
    #[inline]
    fn cycle(&mut self, cycle: &Cycle, places: impl Iterator<Item = PipelinePosition>) {
        (**self).cycle(cycle, places);
    }
}
