//! A folded pipeline whose jobs may have to wait: they are at least an interval apart, and each takes several cycles in a
//! stage. While the exit is full, which holds two, jobs wait at positions that are an interval apart, the last one among
//! them. Of one with credits, [`Credits`](crate::credit::Credits) is the control.

use crate::shape::{Occupancy, PipelinePosition, Shape, highest};

/// The control of a folded pipeline. Jobs move from position 0 to the last position, and then to the exit, which shows
/// the oldest job to the sink.
///
/// Bit i of an [`Occupancy`] is position i.
#[derive(Debug, Clone)]
pub struct Folded {
    /// The least number of positions between two jobs.
    interval: u32,
    /// The bit of the last position.
    last: Occupancy,
    /// The jobs before the exit.
    at: Occupancy,
    /// The number of jobs in the exit.
    arrived: usize,
}

crate::state! { Folded { at, arrived } }

/// The jobs that the exit of an elastic pipeline holds.
const EXIT_PLACES: usize = 2;

impl Folded {
    pub fn new(shape: &Shape) -> Self {
        let last = 1 << (shape.length() - 2);
        Self { interval: shape.spacing() as u32, last, at: 0, arrived: 0 }
    }

    #[inline]
    pub fn input_ready(&self) -> bool {
        let near = (1 << (self.interval - 1)) - 1;
        // A job at the position behind those must move.
        self.at & near == 0 && self.waiting() & (near + 1) == 0
    }

    #[inline]
    pub fn output_valid(&self) -> bool {
        self.arrived > 0
    }

    /// One clock edge. `entering` is whether a job was accepted. The job at the output leaves if `taken`.
    #[inline]
    pub fn cycle(&mut self, entering: bool, taken: bool) {
        let waiting = self.waiting();
        let moving = self.at & !waiting;
        self.arrived = self.arrived + usize::from(moving & self.last != 0) - usize::from(taken);
        self.at = waiting | ((moving & !self.last) << 1) | Occupancy::from(entering);
    }

    /// The jobs that do not move in this cycle.
    #[inline]
    fn waiting(&self) -> Occupancy {
        if self.arrived < EXIT_PLACES {
            return 0;
        }
        let mut waiting = self.at & self.last;
        let mut stop = highest(self.last);
        // A job at one of these positions has no other job before the next of them.
        while let Some(before) = stop.checked_sub(self.interval) {
            waiting |= self.at & (waiting >> self.interval) & (1 << before);
            stop = before;
        }
        waiting
    }

    /// Advances up to `limit` cycles without input, until the output is valid. Returns the number of cycles.
    #[inline]
    pub fn idle(&mut self, limit: u64) -> u64 {
        if self.output_valid() {
            return 0;
        }
        let steps = match self.at {
            0 => limit,
            at => limit.min((highest(self.last) + 1 - highest(at)).into()),
        };
        // `steps` may exceed the shift's range if there are no jobs.
        let moved = if self.at == 0 { 0 } else { self.at << steps };
        let exit = self.last << 1;
        self.arrived = usize::from(moved & exit != 0);
        self.at = moved & !exit;
        steps
    }

    /// The positions of the jobs, oldest first.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        let exit = highest(self.last) as usize + 2;
        let arrived = (0..self.arrived).map(move |index| PipelinePosition { stage: exit, waits: index > 0 });
        let moving = (0..exit - 1).rev().filter(|index| self.at >> index & 1 == 1);
        arrived.chain(moving.map(|index| PipelinePosition { stage: index + 1, waits: false }))
    }

    pub fn reset(&mut self) {
        (self.at, self.arrived) = (0, 0);
    }
}
