//! Registers that never stall, and a FIFO behind them with a place for every job that was let in.

use crate::shape::{Loop, Shape};
use raypath_ops::JobKind;
use std::collections::VecDeque;

/// The control of such a pipeline: who is let in, and when what was let in has arrived.
#[derive(Debug, Clone)]
pub struct Credits {
    /// A register: how many more jobs may enter.
    credits: usize,
    /// The valid bits of the registers that never stall, the output's end first.
    moving: VecDeque<bool>,
    /// Jobs in the FIFO; its front is what the output shows.
    arrived: usize,
    gates: Vec<Gate>,
    capacity: usize,
}

/// Keeps jobs of a kind apart at the entrance.
#[derive(Debug, Clone)]
struct Gate {
    around: Loop,
    /// A register: for how many cycles no job of the kind may enter.
    closed_for: usize,
}

impl Credits {
    pub fn new(shape: &Shape) -> Self {
        let gates = shape.loops().map(|around| Gate { around, closed_for: 0 }).collect();
        let moving = vec![false; shape.latency.max(1) - 1].into();
        Self { credits: shape.capacity(), moving, arrived: 0, gates, capacity: shape.capacity() }
    }

    #[inline]
    pub fn input_ready(&self, kind: JobKind) -> bool {
        self.credits > 0 && !self.gates.iter().any(|gate| gate.around.kind == kind && gate.closed_for > 0)
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.arrived > 0
    }

    /// The clock edge. `entering` was accepted; what the output showed leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<JobKind>, taken: bool) {
        self.moving.push_back(entering.is_some());
        let arrives = self.moving.pop_front() == Some(true);
        self.arrived = self.arrived + usize::from(arrives) - usize::from(taken);
        self.credits = self.credits + usize::from(taken) - usize::from(entering.is_some());
        for Gate { around, closed_for } in &mut self.gates {
            let closes = entering == Some(around.kind);
            *closed_for = if closes { around.last - around.first } else { closed_for.saturating_sub(1) };
        }
    }

    pub fn reset(&mut self) {
        self.credits = self.capacity;
        self.moving.iter_mut().for_each(|valid| *valid = false);
        self.arrived = 0;
        self.gates.iter_mut().for_each(|gate| gate.closed_for = 0);
    }
}
