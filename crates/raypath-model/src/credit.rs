//! Registers that never stall, and a FIFO behind them with a place for every job that was let in.

use crate::places::{Place, Row, highest};
use crate::shape::{Loop, Shape};

/// The control of such a pipeline: who is let in, and when what was let in has arrived.
#[derive(Debug, Clone)]
pub struct Credits {
    /// A register: how many more jobs may enter.
    credits: usize,
    /// The valid bits of the registers that never stall, the input's being bit 0.
    moving: Row,
    /// The FIFO, as if it were one more register.
    exit: Row,
    /// Jobs in the FIFO; its front is what the output shows.
    arrived: usize,
    gates: Vec<Gate>,
    capacity: usize,
}

/// Keeps jobs of an operation apart at the entrance.
#[derive(Debug, Clone)]
struct Gate {
    around: Loop,
    /// A register: for how many cycles no job of the operation may enter.
    closed_for: u64,
}

impl Credits {
    pub fn new(shape: &Shape) -> Self {
        let gates = shape.loops().map(|around| Gate { around, closed_for: 0 }).collect();
        let (capacity, exit) = (shape.capacity(), 1 << (shape.places() - 1));
        Self { credits: capacity, moving: 0, exit, arrived: 0, gates, capacity }
    }

    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.credits > 0 && !self.gates.iter().any(|gate| gate.around.opcode == opcode && gate.closed_for > 0)
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.arrived > 0
    }

    /// The clock edge. `entering` was accepted; what the output showed leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<u64>, taken: bool) {
        let moved = (self.moving << 1) | Row::from(entering.is_some());
        let arrives = moved & self.exit != 0;
        self.moving = moved & !self.exit;
        self.arrived = self.arrived + usize::from(arrives) - usize::from(taken);
        self.credits = self.credits + usize::from(taken) - usize::from(entering.is_some());
        for Gate { around, closed_for } in &mut self.gates {
            let closes = entering == Some(around.opcode);
            *closed_for = if closes { (around.last - around.first) as u64 } else { closed_for.saturating_sub(1) };
        }
    }

    /// Lets up to `limit` cycles pass in which nothing enters, until the output is valid. Answers how many have passed.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        if self.output_valid() {
            return 0;
        }
        let steps = match self.moving {
            0 => limit,
            moving => limit.min((highest(self.exit) - highest(moving)).into()),
        };
        // Of an empty row nothing is left to shift.
        let moved = if self.moving == 0 { 0 } else { self.moving << steps };
        self.arrived = usize::from(moved & self.exit != 0);
        self.moving = moved & !self.exit;
        self.gates.iter_mut().for_each(|gate| gate.closed_for = gate.closed_for.saturating_sub(steps));
        steps
    }

    /// Where the items are, oldest first.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        let exit = highest(self.exit);
        let arrived = (0..self.arrived).map(move |index| Place { stage: exit as usize + 1, waits: index > 0 });
        let moving = (0..exit).rev().filter(|index| self.moving >> index & 1 == 1);
        arrived.chain(moving.map(|index| Place { stage: index as usize + 1, waits: false }))
    }

    pub fn reset(&mut self) {
        self.credits = self.capacity;
        self.moving = 0;
        self.arrived = 0;
        self.gates.iter_mut().for_each(|gate| gate.closed_for = 0);
    }
}
