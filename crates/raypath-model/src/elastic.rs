//! An elastic pipeline: ready and valid at both ends, nothing lost, repeated or reordered in between.

use crate::credit::Credits;
use crate::places::Place;
use crate::shape::{Control, Shape};
use crate::skid::SkidRow;
use std::collections::VecDeque;

/// A pipeline of some [`Shape`], cycle by cycle, whatever its items are.
#[derive(Debug, Clone)]
pub struct Elastic<T> {
    flow: Flow,
    /// The items, oldest first; where each of them is, `flow` knows.
    inside: VecDeque<T>,
}

/// What passed at the two ends in one cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer<T> {
    /// The item offered was accepted.
    pub accepted: bool,
    /// The item that the sink took.
    pub output: Option<T>,
}

/// How far items have come. Order is kept, so opcodes say all that there is to know about them.
#[derive(Debug, Clone)]
enum Flow {
    Skid(SkidRow),
    Credit(Credits),
}

impl<T> Elastic<T> {
    /// An empty pipeline.
    pub fn new(shape: &Shape) -> Self {
        let flow = match shape.control {
            Control::Skid => Flow::Skid(SkidRow::new(shape)),
            Control::Credit => Flow::Credit(Credits::new(shape)),
        };
        Self { flow, inside: VecDeque::with_capacity(shape.capacity()) }
    }

    /// Whether an item of the operation with this opcode, offered in this cycle, will be accepted.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        match &self.flow {
            Flow::Skid(row) => row.input_ready(),
            Flow::Credit(credits) => credits.input_ready(opcode),
        }
    }

    /// What the output shows in this cycle; it stays until the sink takes it.
    #[inline]
    pub fn output(&self) -> Option<&T> {
        let valid = match &self.flow {
            Flow::Skid(row) => row.output_valid(),
            Flow::Credit(credits) => credits.output_valid(),
        };
        if valid { self.inside.front() } else { None }
    }

    /// One clock cycle in which the source offers `input`, an opcode and an item, and the sink takes the output if `output_ready`.
    #[inline]
    pub fn cycle(&mut self, input: Option<(u64, T)>, output_ready: bool) -> Transfer<T> {
        match input {
            Some((opcode, item)) => self.cycle_with(Some(opcode), || item, output_ready),
            None => self.cycle_with(None, || unreachable!("nothing is offered"), output_ready),
        }
    }

    /// The same with an item that is made if it is accepted.
    // Made where it stays: on its way it would be read in other pieces than it was written in, which processors wait for.
    #[inline]
    pub(crate) fn cycle_with(
        &mut self,
        offered: Option<u64>,
        item: impl FnOnce() -> T,
        output_ready: bool,
    ) -> Transfer<T> {
        let taken = output_ready && self.output().is_some();
        let entering = offered.filter(|opcode| self.input_ready(*opcode));
        match &mut self.flow {
            Flow::Skid(row) => row.cycle(entering, taken),
            Flow::Credit(credits) => credits.cycle(entering, taken),
        }
        let output = if taken { self.inside.pop_front() } else { None };
        if entering.is_some() {
            self.inside.push_back(item());
        }
        Transfer { accepted: entering.is_some(), output }
    }

    /// Lets up to `limit` cycles pass in which the source offers nothing, and stops in the first that has an output.
    /// Answers how many have passed. The same as so many calls of [`cycle`](Self::cycle), in next to no time.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        match &mut self.flow {
            Flow::Skid(row) => row.idle(limit),
            Flow::Credit(credits) => credits.idle(limit),
        }
    }

    /// Where the items inside are, oldest first.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        let (row, credits) = match &self.flow {
            Flow::Skid(row) => (Some(row.places()), None),
            Flow::Credit(credits) => (None, Some(credits.places())),
        };
        row.into_iter().flatten().chain(credits.into_iter().flatten())
    }

    /// A hardware reset: everything in flight is lost.
    pub fn reset(&mut self) {
        self.inside.clear();
        match &mut self.flow {
            Flow::Skid(row) => row.reset(),
            Flow::Credit(credits) => credits.reset(),
        }
    }
}
