//! Skid buffers in a row.

use crate::shape::{Loop, Shape};
use raypath_ops::JobKind;

/// A row of skid buffers. Each holds two items, passes one a cycle, and says from a register whether it is ready:
/// nothing that the sink does is seen by the source in the same cycle.
#[derive(Debug, Clone)]
pub struct SkidRow {
    buffers: Vec<SkidBuffer>,
    gates: Vec<Gate>,
}

#[derive(Debug, Clone, Default)]
struct SkidBuffer {
    /// What the next stage sees.
    front: Option<JobKind>,
    /// What arrived while `front` could not leave.
    spare: Option<JobKind>,
}

/// Where jobs wait for an accumulator.
#[derive(Debug, Clone)]
struct Gate {
    around: Loop,
    /// A flip-flop: a job has read the accumulator and not yet written it.
    pending: bool,
    /// In this cycle it writes.
    written: bool,
}

impl SkidRow {
    pub fn new(shape: &Shape) -> Self {
        let gates = shape.loops().map(|around| Gate { around, pending: false, written: false }).collect();
        Self { buffers: vec![SkidBuffer::default(); shape.latency.max(1)], gates }
    }

    #[inline]
    pub fn input_ready(&self) -> bool {
        self.buffers[0].is_ready()
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.buffers.last().is_some_and(|last| last.front.is_some())
    }

    /// The clock edge. `entering` was accepted, so the row was ready; what the output showed leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<JobKind>, taken: bool) {
        let last = self.buffers.len() - 1;
        if taken {
            self.buffers[last].front = None;
        }
        for step in (1..=last).rev() {
            let (before, from_here) = self.buffers.split_at_mut(step);
            let (source, target) = (&mut before[step - 1], &mut from_here[0]);
            // `target` has given away its front already, but is ready only if it was so when the cycle began.
            let ready = target.is_ready();
            let moving = source.front.take_if(|kind| ready && !self.gates.iter().any(|gate| gate.holds(*kind, step)));
            if let Some(kind) = moving {
                self.gates.iter_mut().for_each(|gate| gate.passes(kind, step));
            }
            target.settle(moving);
        }
        self.buffers[0].settle(entering);
        self.gates.iter_mut().for_each(Gate::settle);
    }

    pub fn reset(&mut self) {
        self.buffers.fill(SkidBuffer::default());
        self.gates.iter_mut().for_each(|gate| gate.pending = false);
    }
}

impl SkidBuffer {
    #[inline]
    fn is_ready(&self) -> bool {
        self.spare.is_none()
    }

    /// The clock edge, after `front` may have left.
    #[inline]
    fn settle(&mut self, arriving: Option<JobKind>) {
        if self.front.is_none() {
            self.front = self.spare.take().or(arriving);
        } else if arriving.is_some() {
            self.spare = arriving;
        }
    }
}

impl Gate {
    /// Whether a job of this kind must not move at this step.
    #[inline]
    fn holds(&self, kind: JobKind, step: usize) -> bool {
        self.pending && (kind, step) == (self.around.kind, self.around.first)
    }

    /// A job of this kind moves at this step.
    #[inline]
    fn passes(&mut self, kind: JobKind, step: usize) {
        if kind == self.around.kind {
            self.pending |= step == self.around.first;
            self.written |= step == self.around.last;
        }
    }

    /// The clock edge: only now is it seen that the accumulator was written.
    #[inline]
    fn settle(&mut self) {
        self.pending &= !std::mem::take(&mut self.written);
    }
}
