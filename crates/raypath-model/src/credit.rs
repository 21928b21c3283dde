//! A pipeline of registers that never stall, followed by a FIFO with space for every admitted job.

use crate::shape::{Loop, Occupancy, PipelinePosition, Shape, highest};

/// The control of a pipeline with credits: a job takes one when it is admitted and returns it when it leaves the FIFO.
#[derive(Debug, Clone)]
pub struct Credits {
    /// A register: the number of jobs that may still enter.
    credits: usize,
    /// The valid bits of the registers that never stall.
    moving: Occupancy,
    /// The bit of the FIFO, as one more register.
    exit: Occupancy,
    /// The number of jobs in the FIFO, whose first is at the output.
    arrived: usize,
    gates: Vec<Gate>,
    capacity: usize,
}

/// What spaces jobs at the input: an accumulator loop those of its operation, a folded pipeline all.
#[derive(Debug, Clone)]
struct Gate {
    /// The operation; `None`: all.
    opcode: Option<u64>,
    /// The number of cycles after a job in which no other one may enter.
    cycles: u64,
    /// A register: the number of those that are left.
    closed_for: u64,
}

impl Gate {
    fn is_for(&self, opcode: u64) -> bool {
        self.opcode.is_none_or(|own| own == opcode)
    }
}

crate::state! {
    Credits { credits, moving, arrived, gates }
    Gate { closed_for }
}

impl Credits {
    pub fn new(shape: &Shape) -> Self {
        let gate = |opcode, cycles| Gate { opcode, cycles: cycles as u64, closed_for: 0 };
        let loops = shape.loops().map(|Loop { opcode, first, last }| gate(Some(opcode), last - first));
        let all = shape.is_folded().then(|| gate(None, shape.spacing() - 1));
        let gates = loops.chain(all).collect();
        let (capacity, exit) = (shape.capacity(), 1 << (shape.length() - 1));
        Self { credits: capacity, moving: 0, exit, arrived: 0, gates, capacity }
    }

    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.credits > 0 && !self.gates.iter().any(|gate| gate.is_for(opcode) && gate.closed_for > 0)
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.arrived > 0
    }

    /// One clock edge. `entering` is the opcode of a job that was accepted. The job at the output leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<u64>, taken: bool) {
        let moved = (self.moving << 1) | Occupancy::from(entering.is_some());
        let arrives = moved & self.exit != 0;
        self.moving = moved & !self.exit;
        self.arrived = self.arrived + usize::from(arrives) - usize::from(taken);
        self.credits = self.credits + usize::from(taken) - usize::from(entering.is_some());
        for gate in &mut self.gates {
            let closes = entering.is_some_and(|opcode| gate.is_for(opcode));
            gate.closed_for = if closes { gate.cycles } else { gate.closed_for.saturating_sub(1) };
        }
    }

    /// Advances up to `limit` cycles without input, until the output is valid. Returns the number of cycles.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        if self.output_valid() {
            return 0;
        }
        let steps = match self.moving {
            0 => limit,
            moving => limit.min((highest(self.exit) - highest(moving)).into()),
        };
        // `steps` may exceed the shift's range if the registers are empty.
        let moved = if self.moving == 0 { 0 } else { self.moving << steps };
        self.arrived = usize::from(moved & self.exit != 0);
        self.moving = moved & !self.exit;
        self.gates.iter_mut().for_each(|gate| gate.closed_for = gate.closed_for.saturating_sub(steps));
        steps
    }

    /// The positions of the jobs, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        let exit = highest(self.exit);
        let arrived =
            (0..self.arrived).map(move |index| PipelinePosition { stage: exit as usize + 1, waits: index > 0 });
        let moving = (0..exit).rev().filter(|index| self.moving >> index & 1 == 1);
        arrived.chain(moving.map(|index| PipelinePosition { stage: index as usize + 1, waits: false }))
    }

    pub fn reset(&mut self) {
        self.credits = self.capacity;
        self.moving = 0;
        self.arrived = 0;
        self.gates.iter_mut().for_each(|gate| gate.closed_for = 0);
    }
}
