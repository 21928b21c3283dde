//! In a folded pipeline, the ports of a step that say at which position the job is.

use crate::allocate::plan::Plan;
use crate::config::Control;
use raypath_hdl::{Builder, Wire};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// The ports of a module, each declared when it is first read.
pub struct Positions<'m> {
    m: &'m Builder,
    /// The positions at which a job may have to wait.
    stops: BTreeSet<u32>,
    ports: RefCell<BTreeMap<String, Wire<'m>>>,
}

/// The stem of the port that is 1 while a job is at a position.
pub fn at(position: u32) -> String {
    format!("at_{position}")
}

/// The stem of the port that is 1 while a job is at a position and moves on.
pub fn moves(position: u32, stops: &BTreeSet<u32>) -> String {
    if stops.contains(&position) { format!("moves_{position}") } else { at(position) }
}

/// The positions at which a job may have to wait: none with credits, because the exit has a place for every job.
pub fn stops(plan: &Plan) -> BTreeSet<u32> {
    match (plan.microarchitecture.control, &plan.rounds) {
        (Control::Skid, Some(rounds)) => rounds.stops().collect(),
        _ => BTreeSet::new(),
    }
}

impl<'m> Positions<'m> {
    pub fn new(m: &'m Builder, plan: &Plan) -> Self {
        Self { m, stops: stops(plan), ports: RefCell::default() }
    }

    /// Whether a job may have to wait at one of these positions.
    pub fn may_wait(&self, mut positions: std::ops::RangeInclusive<u32>) -> bool {
        positions.any(|position| self.stops.contains(&position))
    }

    /// Whether the job is at a position.
    pub fn at(&self, position: u32) -> Wire<'m> {
        self.port(at(position))
    }

    /// Whether the job is at a position and moves on.
    pub fn moves(&self, position: u32) -> Wire<'m> {
        self.port(moves(position, &self.stops))
    }

    fn port(&self, stem: String) -> Wire<'m> {
        let mut ports = self.ports.borrow_mut();
        *ports.entry(stem).or_insert_with_key(|stem| self.m.input(&format!("{stem}_i"), 1))
    }
}
