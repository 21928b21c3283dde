//! A pipeline of skid buffers.

use crate::shape::{Loop, Occupancy, PipelinePosition, Shape, highest};

/// The control of a pipeline of skid buffers. Each buffer holds two jobs, passes one per cycle, and has a registered
/// ready output, so that there is no combinational path from the sink to the source.
///
/// Bit i of an [`Occupancy`] is buffer i; the input's buffer is 0.
#[derive(Debug, Clone)]
pub struct SkidBuffers {
    /// The bit of the output's buffer.
    last: Occupancy,
    /// Buffers with a job in the front register, which the next stage reads.
    front: Occupancy,
    /// Buffers with a job in the spare register, which arrived while the front could not leave.
    spare: Occupancy,
    gates: Vec<Gate>,
}

/// The control of one accumulator loop.
#[derive(Debug, Clone)]
struct Gate {
    around: Loop,
    /// Buffers with a job of the loop's operation in the front register.
    front: Occupancy,
    /// Buffers with such a job in the spare register.
    spare: Occupancy,
    /// A flip-flop: a job has read the accumulator and has not yet written it.
    pending: bool,
}

crate::state! {
    SkidBuffers { front, spare, gates }
    Gate { front, spare, pending }
}

impl SkidBuffers {
    pub fn new(shape: &Shape) -> Self {
        let gates = shape.loops().map(|around| Gate { around, front: 0, spare: 0, pending: false }).collect();
        Self { last: 1 << (shape.length() - 1), front: 0, spare: 0, gates }
    }

    #[inline]
    pub fn input_ready(&self) -> bool {
        self.spare & 1 == 0
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.front & self.last != 0
    }

    /// One clock edge. `entering` is the opcode of a job that was accepted. The job at the output leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: Option<u64>, taken: bool) {
        // One test of bits that are nearly always 0, because `taken` alone is as random as the traffic.
        let waiting = if taken { 0 } else { self.front & self.last };
        if (self.spare | waiting) == 0 && self.gates.is_empty() {
            // All jobs move.
            self.front = (self.front & !self.last) << 1 | Occupancy::from(entering.is_some());
            return;
        }
        // A buffer whose front leaves is ready only if it was ready when the cycle began.
        let next_is_ready = !self.spare >> 1;
        let held = self.gates.iter().fold(0, |held, gate| held | gate.held());
        let leaving = if taken { self.last } else { 0 };
        let moving = self.front & !held & ((next_is_ready & (self.last - 1)) | leaving);
        let staying = self.front & !moving;
        let arriving = ((moving & !self.last) << 1) | Occupancy::from(entering.is_some());
        for gate in &mut self.gates {
            gate.cycle(moving, staying, Occupancy::from(entering == Some(gate.around.opcode)));
        }
        self.front = staying | self.spare | arriving;
        self.spare = staying & (self.spare | arriving);
    }

    /// Advances up to `limit` cycles without input, until the output is valid. Returns the number of cycles.
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

    /// The positions of the jobs, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        let buffers = (0..=highest(self.last)).rev();
        buffers.flat_map(|index| {
            let holds = |row: Occupancy, waits| {
                (row >> index & 1 == 1).then_some(PipelinePosition { stage: index as usize + 1, waits })
            };
            holds(self.front, false).into_iter().chain(holds(self.spare, true))
        })
    }

    pub fn reset(&mut self) {
        (self.front, self.spare) = (0, 0);
        self.gates.iter_mut().for_each(|gate| (gate.front, gate.spare, gate.pending) = (0, 0, false));
    }
}

impl Gate {
    /// The buffer before the loop, if its front is a job that must wait.
    #[inline]
    fn held(&self) -> Occupancy {
        if self.pending { self.front & self.before(self.around.first) } else { 0 }
    }

    /// One clock edge. `moving` and `staying` are fronts; `entering` is 1 for a job of the loop's operation.
    #[inline]
    fn cycle(&mut self, moving: Occupancy, staying: Occupancy, entering: Occupancy) {
        let moving = self.front & moving;
        let reads = moving & self.before(self.around.first) != 0;
        // The write becomes visible after the edge.
        let writes = moving & self.before(self.around.last) != 0;
        self.pending = (self.pending | reads) & !writes;
        let arriving = self.spare | (moving << 1) | entering;
        self.front = (self.front & staying) | (arriving & !staying);
        self.spare = arriving & staying;
    }

    /// The buffer before a step. Step i leads into buffer i, and a loop's steps are at least 1.
    #[inline]
    fn before(&self, step: usize) -> Occupancy {
        1 << (step - 1)
    }

    #[inline]
    fn is_idle(&self) -> bool {
        !self.pending && self.front == 0
    }
}
