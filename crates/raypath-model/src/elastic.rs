//! Elastic pipelines: ready and valid at both ends, with no item lost, repeated or reordered.

use crate::flow::Flow;
use crate::shape::{PipelinePosition, Shape};
use std::collections::VecDeque;

/// A cycle-exact model of a pipeline of some [`Shape`], for items of any type.
#[derive(Debug, Clone)]
pub struct Elastic<T> {
    /// The positions of the items. Items stay in order, so only their opcodes matter.
    flow: Flow,
    /// The items, oldest first.
    inside: VecDeque<T>,
}

/// The transfers at the two ends of a pipeline in one cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer<T> {
    /// The offered item was accepted.
    pub accepted: bool,
    /// The item that left.
    pub output: Option<T>,
}

impl<T> Elastic<T> {
    /// An empty pipeline.
    pub fn new(shape: &Shape) -> Self {
        Self { flow: Flow::new(shape), inside: VecDeque::with_capacity(shape.capacity()) }
    }

    /// Whether an item of the operation with this opcode will be accepted if it is offered in this cycle.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.flow.input_ready(opcode)
    }

    /// The item at the output in this cycle, if the output is valid. It stays until the sink is ready.
    #[inline]
    pub fn output(&self) -> Option<&T> {
        if self.flow.output_valid() { self.inside.front() } else { None }
    }

    /// One clock cycle. The source offers `input`, an opcode and an item; the sink takes the output if `output_ready`.
    #[inline]
    pub fn cycle(&mut self, input: Option<(u64, T)>, output_ready: bool) -> Transfer<T> {
        match input {
            Some((opcode, item)) => self.cycle_with(Some(opcode), || item, output_ready),
            None => self.cycle_with(None, || unreachable!("nothing is offered"), output_ready),
        }
    }

    /// As [`cycle`](Self::cycle), with an item that is computed only if it is accepted.
    // The item is computed in place. A copy would read it in pieces of other sizes than it was written in, which stalls
    // the processor.
    #[inline]
    pub(crate) fn cycle_with(
        &mut self,
        offered: Option<u64>,
        item: impl FnOnce() -> T,
        output_ready: bool,
    ) -> Transfer<T> {
        let taken = output_ready && self.output().is_some();
        let entering = offered.filter(|opcode| self.input_ready(*opcode));
        self.flow.cycle(entering, taken);
        let output = if taken { self.inside.pop_front() } else { None };
        if entering.is_some() {
            self.inside.push_back(item());
        }
        Transfer { accepted: entering.is_some(), output }
    }

    /// Advances up to `limit` cycles in which the source offers nothing, and stops in the first with a valid output.
    /// Returns the number of cycles. Equivalent to that many calls of [`cycle`](Self::cycle), but faster.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        self.flow.idle(limit)
    }

    /// The positions of the items, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        self.flow.positions()
    }

    /// A hardware reset: all items are lost.
    pub fn reset(&mut self) {
        self.inside.clear();
        self.flow.reset();
    }
}
