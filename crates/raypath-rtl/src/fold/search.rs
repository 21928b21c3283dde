//! Searches for the first positions of the stages that need the least area.

use super::groups::Work;
use super::lives::{Life, Rounds};
use super::rounds::{self, StageRounds};
use crate::ir::graph::{Kind, OperationGraph};
use crate::ir::liveness::PositionValues;
use crate::ir::position::Step;
use crate::ir::units::UnitKind;
use raypath_float::Format;

/// The greatest number of positions where jobs may have to wait, because a word of the netlist has a bit for each.
pub const MAX_ELASTIC_POSITIONS: u32 = 64;

/// The greatest number of positions. The models have a bit of a word for each, and for the exit.
pub const MAX_POSITIONS: u32 = 127;

/// The schedule of a folded pipeline with this interval, which is at least 2. `values` are those of each operation and
/// step, `most` is the greatest number of positions.
pub fn plan(
    interval: u32,
    operations: &[OperationGraph<Step>],
    values: &[Vec<PositionValues>],
    format: Format,
    most: u32,
) -> Option<Rounds> {
    let work = |(graph, values): (&OperationGraph<Step>, &Vec<PositionValues>)| -> Vec<Work> {
        let none = PositionValues::default();
        let before = |step: usize| step.checked_sub(1).map_or(&none, |before| &values[before]);
        (0..values.len()).map(|step| Work::new(graph, Step(step as u32), before(step), &values[step])).collect()
    };
    let works: Vec<Vec<Work>> = operations.iter().zip(values).map(work).collect();
    let problem = Problem { interval, operations, works: &works, format, most };
    let stages = works.first().map_or(0, Vec::len);
    // The positions from the beginning of each stage to that of the next.
    let mut delays = vec![1; stages.saturating_sub(2)];
    // A value inside a unit goes on at once.
    let inside = |work: &Work| work.carried.iter().any(|value| value.is_inside_unit);
    let is_fixed: Vec<bool> =
        (0..delays.len()).map(|stage| works.iter().any(|work| inside(&work[stage + 1]))).collect();
    let mut best = problem.try_out(&delays);
    loop {
        let before = best.as_ref().map(|(cost, _)| *cost);
        for stage in (0..delays.len()).filter(|stage| !is_fixed[*stage]) {
            for delay in 1..=interval {
                let mut changed = delays.clone();
                changed[stage] = delay;
                let Some(found) = problem.try_out(&changed) else { continue };
                if best.as_ref().is_none_or(|(cost, _)| found.0 < *cost) {
                    (best, delays) = (Some(found), changed);
                }
            }
        }
        if best.as_ref().map(|(cost, _)| *cost) == before {
            return best.map(|(_, rounds)| rounds);
        }
    }
}

struct Problem<'a> {
    interval: u32,
    operations: &'a [OperationGraph<Step>],
    works: &'a [Vec<Work>],
    format: Format,
    most: u32,
}

impl Problem<'_> {
    /// The cost of the schedule with these delays, and the schedule.
    fn try_out(&self, delays: &[u32]) -> Option<(u64, Rounds)> {
        let mut starts = vec![0, 0];
        starts.extend(delays.iter().scan(0, |start, delay| {
            *start += delay;
            Some(*start)
        }));
        let assigned = rounds::assign(self.interval, self.works, &starts)?;
        let rounds = Rounds::new(self.interval, self.works, &starts, &assigned)?;
        (rounds.positions() <= self.most).then(|| (self.cost(&assigned, &rounds), rounds))
    }

    /// An estimate of the area in gates: units, register bits, and a little for each position.
    fn cost(&self, assigned: &[StageRounds], rounds: &Rounds) -> u64 {
        let bits = u64::from(self.format.significand());
        let area = |kind: UnitKind| match kind {
            UnitKind::Multiply => bits * bits * 5,
            UnitKind::Add | UnitKind::Sum => bits * 50,
            UnitKind::Compare | UnitKind::Encode | UnitKind::Decode => bits * 8,
        };
        let units = assigned.iter().flat_map(|stage| &stage.units).filter(|((_, part), _)| *part == 0);
        let units = units.map(|(&(kind, _), &count)| area(kind) * count as u64);
        let registers = (0..rounds.starts.len()).map(|step| self.register_bits(rounds, step) * 9);
        units.sum::<u64>() + registers.sum::<u64>() + u64::from(rounds.positions()) * 8
    }

    /// The bits that a boundary needs at the position with the most values, for the operation with the most.
    fn register_bits(&self, rounds: &Rounds, step: usize) -> u64 {
        let width = |op: usize, id| match self.operations[op].node(id).kind {
            Kind::Word(width) => u64::from(width),
            _ => u64::from(self.format.recoded_width()),
        };
        let at = |op: usize, position: u32| -> u64 {
            let here = Life { first: position, last: position };
            let lives = rounds.lives[op][step].iter().filter(|(_, life)| life.overlaps(here));
            lives.map(|(&id, life)| width(op, id) * if life.length() > 1 { 3 } else { 2 } / 2).sum()
        };
        let positions = rounds.starts[step]..=rounds.starts[step] + 2 * rounds.interval;
        positions.flat_map(|position| (0..self.works.len()).map(move |op| at(op, position))).max().unwrap_or(0)
    }
}
