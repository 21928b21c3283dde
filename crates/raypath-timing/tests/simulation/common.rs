//! A model without arithmetic, whose jobs carry the number of their owner, and agents that follow a list.

use raypath_model::{CycleModel, Model, PipelinePosition, Shape};
use raypath_ops::JobKind;
use raypath_timing::{Action, Agent, Observer, PortActivity};

/// A job of a kind, with the number of its owner. Its outcome is the job itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tag(pub JobKind, pub u64);

/// The model that returns jobs unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo;

impl Model for Echo {
    type Kind = JobKind;
    type Job = Tag;
    type Outcome = Tag;

    fn kind(tag: &Tag) -> JobKind {
        tag.0
    }
    fn run(&mut self, job: &Tag) -> Tag {
        *job
    }
    fn reset(&mut self) {}
}

pub fn echo(shape: &Shape) -> CycleModel<Echo> {
    CycleModel::new(Echo, shape)
}

/// An agent that performs a list of actions and collects its outcomes.
#[derive(Debug, Clone, PartialEq)]
pub struct Script<M: Model> {
    pub actions: std::collections::VecDeque<Action<M::Job>>,
    pub outcomes: Vec<M::Outcome>,
}

impl<M: Model> Script<M> {
    pub fn new(actions: impl IntoIterator<Item = Action<M::Job>>) -> Self {
        Self { actions: actions.into_iter().collect(), outcomes: Vec::new() }
    }
}

impl<M: Model> Agent<M> for Script<M> {
    fn next_action(&mut self) -> Action<M::Job> {
        self.actions.pop_front().unwrap_or(Action::Done)
    }
    fn receive(&mut self, outcome: &M::Outcome) {
        self.outcomes.push(outcome.clone());
    }
}

/// Observes the cycles of a range.
pub struct Cycles {
    from: u64,
    until: u64,
    pub seen: Vec<(PortActivity, Vec<PipelinePosition>)>,
}

impl Cycles {
    pub fn between(from: u64, until: u64) -> Self {
        Self { from, until, seen: Vec::new() }
    }
}

impl Observer for Cycles {
    fn next_observed(&self, cycle: u64) -> Option<u64> {
        Some(cycle.max(self.from)).filter(|cycle| *cycle < self.until)
    }
    fn observe(&mut self, ports: &PortActivity, positions: impl Iterator<Item = PipelinePosition>) {
        self.seen.push((*ports, positions.collect()));
    }
}

pub fn issue(kind: JobKind, number: u64) -> Action<Tag> {
    Action::Issue(Tag(kind, number))
}
