//! The control of an elastic pipeline, without the items.

use crate::credit::Credits;
use crate::folded::Folded;
use crate::shape::{Control, PipelinePosition, Shape};
use crate::skid::SkidBuffers;
use crate::{State, StateWords};

/// The cycle-exact control of a pipeline of some [`Shape`]: how many items are inside and where, but not which.
/// [`Elastic`](crate::Elastic) adds the items.
#[derive(Debug, Clone)]
pub struct Flow(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Skid(SkidBuffers),
    Credit(Credits),
    Folded(Folded),
}

/// Evaluates an expression for each control.
macro_rules! each_control {
    ($kind:expr, $control:ident => $result:expr) => {
        match $kind {
            Kind::Skid($control) => $result,
            Kind::Credit($control) => $result,
            Kind::Folded($control) => $result,
        }
    };
}

impl State for Flow {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        each_control!(&mut self.0, control => control.pass(words));
    }
}

impl Flow {
    /// An empty pipeline.
    pub fn new(shape: &Shape) -> Self {
        Self(match shape.control {
            Control::Skid if shape.is_folded() => Kind::Folded(Folded::new(shape)),
            Control::Skid => Kind::Skid(SkidBuffers::new(shape)),
            Control::Credit => Kind::Credit(Credits::new(shape)),
        })
    }

    /// Whether an item of the operation with this opcode can enter in this cycle.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        match &self.0 {
            Kind::Skid(buffers) => buffers.input_ready(),
            Kind::Credit(credits) => credits.input_ready(opcode),
            Kind::Folded(folded) => folded.input_ready(),
        }
    }

    /// Whether there is an item at the output in this cycle.
    #[inline]
    pub fn output_valid(&self) -> bool {
        each_control!(&self.0, control => control.output_valid())
    }

    /// One clock cycle. An item of the operation with the opcode `entering` enters, for which
    /// [`input_ready`](Self::input_ready) was true. The item at the output leaves if `taken`, for which
    /// [`output_valid`](Self::output_valid) was true.
    #[inline]
    pub fn cycle(&mut self, entering: Option<u64>, taken: bool) {
        match &mut self.0 {
            Kind::Skid(buffers) => buffers.cycle(entering, taken),
            Kind::Credit(credits) => credits.cycle(entering, taken),
            Kind::Folded(folded) => folded.cycle(entering.is_some(), taken),
        }
    }

    /// Advances up to `limit` cycles in which nothing enters, and stops in the first with a valid output. Returns the
    /// number of cycles. Equivalent to that many calls of [`cycle`](Self::cycle), but faster.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        each_control!(&mut self.0, control => control.idle(limit))
    }

    /// The positions of the items, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        let (buffers, credits, folded) = match &self.0 {
            Kind::Skid(buffers) => (Some(buffers.positions()), None, None),
            Kind::Credit(credits) => (None, Some(credits.positions()), None),
            Kind::Folded(folded) => (None, None, Some(folded.positions())),
        };
        buffers.into_iter().flatten().chain(credits.into_iter().flatten()).chain(folded.into_iter().flatten())
    }

    /// A hardware reset: all items are lost.
    pub fn reset(&mut self) {
        each_control!(&mut self.0, control => control.reset());
    }
}
