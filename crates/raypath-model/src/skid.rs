//! Skid buffers in a row.

use crate::places::{Place, Row, highest};
use crate::shape::{Loop, Shape};

/// A row of skid buffers. Each holds two items, passes one a cycle, and says from a register whether it is ready:
/// nothing that the sink does is seen by the source in the same cycle.
///
/// All buffers move at once: bit i of a [`Row`] is buffer i, the input's being 0.
#[derive(Debug, Clone)]
pub struct SkidRow {
    /// The output's buffer.
    last: Row,
    /// Buffers whose front shows an item to the next stage.
    front: Row,
    /// Buffers that keep an item which arrived while the front could not leave.
    spare: Row,
    gates: Vec<Gate>,
}

/// Where jobs wait for an accumulator.
#[derive(Debug, Clone)]
struct Gate {
    around: Loop,
    /// Buffers whose front is a job of the loop's operation.
    front: Row,
    /// Buffers whose spare is one.
    spare: Row,
    /// A flip-flop: a job has read the accumulator and not yet written it.
    pending: bool,
}

impl SkidRow {
    pub fn new(shape: &Shape) -> Self {
        let gates = shape.loops().map(|around| Gate { around, front: 0, spare: 0, pending: false }).collect();
        Self { last: 1 << (shape.places() - 1), front: 0, spare: 0, gates }
    }

    #[inline]
    pub fn input_ready(&self) -> bool {
        self.spare & 1 == 0
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.front & self.last != 0
    }

    /// The clock edge. `entering` was accepted, so the row was ready; what the output showed leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<u64>, taken: bool) {
        // A buffer that gives away its front is ready only if it was so when the cycle began.
        let next_is_ready = !self.spare >> 1;
        let held = self.gates.iter().fold(0, |held, gate| held | gate.held());
        let leaving = if taken { self.last } else { 0 };
        let moving = self.front & !held & ((next_is_ready & (self.last - 1)) | leaving);
        let staying = self.front & !moving;
        let arriving = ((moving & !self.last) << 1) | Row::from(entering.is_some());
        for gate in &mut self.gates {
            gate.cycle(moving, staying, Row::from(entering == Some(gate.around.opcode)));
        }
        self.front = staying | self.spare | arriving;
        self.spare = staying & (self.spare | arriving);
    }

    /// Lets up to `limit` cycles pass in which nothing enters, until the output is valid. Answers how many have passed.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        let mut passed = 0;
        while passed < limit && !self.output_valid() {
            if self.front == 0 {
                return limit;
            }
            if self.spare == 0 && self.gates.iter().all(Gate::is_idle) {
                let free = highest(self.last) - highest(self.front);
                let steps = (limit - passed).min(free.into());
                self.front <<= steps;
                passed += steps;
            } else {
                self.cycle(None, false);
                passed += 1;
            }
        }
        passed
    }

    /// Where the items are, oldest first.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        let buffers = (0..=highest(self.last)).rev();
        buffers.flat_map(|index| {
            let holds = |row: Row, waits| (row >> index & 1 == 1).then_some(Place { stage: index as usize + 1, waits });
            holds(self.front, false).into_iter().chain(holds(self.spare, true))
        })
    }

    pub fn reset(&mut self) {
        (self.front, self.spare) = (0, 0);
        self.gates.iter_mut().for_each(|gate| (gate.front, gate.spare, gate.pending) = (0, 0, false));
    }
}

impl Gate {
    /// The buffer whose front must not move, if it is a job of the loop's operation.
    #[inline]
    fn held(&self) -> Row {
        if self.pending { self.front & self.before(self.around.first) } else { 0 }
    }

    /// The clock edge. `moving` and `staying` are the fronts that do; `entering` is 1 for a job of the loop's operation.
    #[inline]
    fn cycle(&mut self, moving: Row, staying: Row, entering: Row) {
        let moving = self.front & moving;
        let reads = moving & self.before(self.around.first) != 0;
        // Only after the edge is it seen that the accumulator was written.
        let writes = moving & self.before(self.around.last) != 0;
        self.pending = (self.pending | reads) & !writes;
        let arriving = self.spare | (moving << 1) | entering;
        self.front = (self.front & staying) | (arriving & !staying);
        self.spare = arriving & staying;
    }

    /// The buffer from which a job passes a step. Step i leads into buffer i, and a loop's steps are at least 1.
    #[inline]
    fn before(&self, step: usize) -> Row {
        1 << (step - 1)
    }

    #[inline]
    fn is_idle(&self) -> bool {
        !self.pending && self.front == 0
    }
}
