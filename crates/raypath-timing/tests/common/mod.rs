//! A model without arithmetic, whose jobs say whose they are, and agents that follow a list.

use raypath_model::{CycleModel, Model, OnPorts, Shape};
use raypath_ops::{JobKind, PortValue};
use raypath_timing::{Agent, Step};

/// A job of some kind that comes out as it went in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tag(pub JobKind, pub u64);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo;

impl OnPorts for Tag {
    type Kind = JobKind;

    fn kind(&self) -> JobKind {
        self.0
    }
    fn ports(&self) -> Vec<PortValue> {
        Vec::new()
    }
    fn words(&self, words: &mut Vec<u64>) {
        words.clear();
    }
}

impl Model for Echo {
    type Kind = JobKind;
    type Job = Tag;
    type Outcome = Tag;

    fn kinds(&self) -> Vec<JobKind> {
        JobKind::ALL.to_vec()
    }

    fn run(&mut self, job: &Tag) -> Tag {
        *job
    }
    fn reset(&mut self) {}
    fn job(&self, kind: JobKind, _: impl FnMut(&str) -> u64) -> Tag {
        Tag(kind, 0)
    }
    fn outcome(&self, kind: JobKind, _: impl FnMut(&str) -> u64) -> Tag {
        Tag(kind, 0)
    }
    fn job_of_words(&self, kind: JobKind, _: &[u64]) -> Tag {
        Tag(kind, 0)
    }
    fn outcome_of_words(&self, kind: JobKind, _: &[u64]) -> Tag {
        Tag(kind, 0)
    }
}

pub fn echo(shape: &Shape) -> CycleModel<Echo> {
    CycleModel::new(Echo, shape)
}

/// Does what its list says and keeps its answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Script<M: Model> {
    pub steps: std::collections::VecDeque<Step<M::Job>>,
    pub answers: Vec<M::Outcome>,
}

impl<M: Model> Script<M> {
    pub fn new(steps: impl IntoIterator<Item = Step<M::Job>>) -> Self {
        Self { steps: steps.into_iter().collect(), answers: Vec::new() }
    }
}

impl<M: Model> Agent<M> for Script<M> {
    fn step(&mut self) -> Step<M::Job> {
        self.steps.pop_front().unwrap_or(Step::Done)
    }
    fn answer(&mut self, outcome: &M::Outcome) {
        self.answers.push(outcome.clone());
    }
}

pub fn issue(kind: JobKind, number: u64) -> Step<Tag> {
    Step::Issue { job: Tag(kind, number), holds: false }
}
