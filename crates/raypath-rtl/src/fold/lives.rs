//! The positions at which registers hold values.

use super::groups::Work;
use super::rounds::{Arrival, StageRounds};
use crate::ir::graph::NodeId;
use std::collections::BTreeMap;

/// The positions at which a register holds a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Life {
    /// The first position. The register loads when a job moves here from the position before.
    pub first: u32,
    /// The last position at which the value is read.
    pub last: u32,
}

impl Life {
    /// The number of positions.
    pub fn length(self) -> u32 {
        self.last - self.first + 1
    }

    /// Both lives and the time between them.
    pub fn hull(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), last: self.last.max(other.last) }
    }

    /// Whether a position belongs to both.
    pub fn overlaps(self, other: Self) -> bool {
        self.first <= other.last && other.first <= self.last
    }
}

/// The schedule of a folded pipeline.
#[derive(Debug, Clone)]
pub struct Rounds {
    /// The least number of positions between two jobs; at least 2.
    pub interval: u32,
    /// The first position of each step. The entry of the input's registers is 0.
    pub starts: Vec<u32>,
    /// For each operation and step, the position at which units compute values.
    pub units: Vec<Vec<BTreeMap<NodeId, u32>>>,
    /// For each operation and step, the lives of the values in the registers after the step.
    pub lives: Vec<Vec<BTreeMap<NodeId, Life>>>,
    /// For each operation, the position at which each state is written.
    pub states: Vec<Vec<u32>>,
}

impl Rounds {
    /// The lives of all values, each carried as late as possible; `None` if a value would stay too long in a register.
    pub fn new(interval: u32, works: &[Vec<Work>], starts: &[u32], assigned: &[StageRounds]) -> Option<Self> {
        let mut rounds =
            Self { interval, starts: starts.to_vec(), units: Vec::new(), lives: Vec::new(), states: Vec::new() };
        for (op, work) in works.iter().enumerate() {
            let position = |stage: usize, group: usize| starts[stage] + assigned[stage].rounds[op][group];
            let (mut units, mut states) = (vec![BTreeMap::new(); work.len()], BTreeMap::new());
            for (stage, work) in work.iter().enumerate().skip(1) {
                for (number, group) in work.groups.iter().enumerate() {
                    let position = position(stage, number);
                    units[stage].extend(group.units.iter().map(|&id| (id, position)));
                    states.extend(group.states.iter().map(|&state| (state, position)));
                }
            }
            rounds.units.push(units);
            rounds.states.push(states.into_values().collect());
            let arrivals: Vec<_> = assigned.iter().map(|stage| &stage.arrivals[op]).collect();
            rounds.lives.push(lives(interval, work, &arrivals, rounds.positions(), position)?);
        }
        Some(rounds)
    }

    /// The number of positions. A job at the last one leaves for the exit.
    pub fn positions(&self) -> u32 {
        self.starts.last().map_or(0, |last| last + 1)
    }

    /// The positions at which a job of a skid pipeline waits for the job before it, the last first.
    pub fn stops(&self) -> impl Iterator<Item = u32> {
        let (last, interval) = (self.positions() - 1, self.interval);
        (0..=last / interval).map(move |index| last - index * interval)
    }

    /// The positions at which the opcode is read from the registers before a step.
    pub fn opcode(&self, step: usize) -> Life {
        let first = self.starts[step];
        Life { first, last: (first + self.interval - 1).min(self.positions() - 1) }
    }
}

/// The lives of one operation's values after each step, from the last step to the input. `position` is that of a step's
/// group.
fn lives(
    interval: u32,
    work: &[Work],
    arrivals: &[&BTreeMap<NodeId, Arrival>],
    end: u32,
    position: impl Fn(usize, usize) -> u32,
) -> Option<Vec<BTreeMap<NodeId, Life>>> {
    let mut lives = vec![BTreeMap::new(); work.len()];
    // The first and the last position at which the values after a step are read.
    let at_exit = Life { first: end, last: end };
    let last = work.last().map_or(&[][..], |work| &work.carried);
    let mut reads: BTreeMap<NodeId, Life> = last.iter().map(|value| (value.id, at_exit)).collect();
    for (stage, work) in work.iter().enumerate().rev() {
        let mut before: BTreeMap<NodeId, Life> = BTreeMap::new();
        let mut read = |id: NodeId, at: u32| {
            let at = Life { first: at, last: at };
            before.entry(id).and_modify(|life| *life = life.hull(at)).or_insert(at);
        };
        for (number, group) in work.groups.iter().enumerate() {
            group.leaves.iter().for_each(|&leaf| read(leaf, position(stage, number)));
        }
        for value in &work.carried {
            let (needed, arrival) = (*reads.get(&value.id)?, arrivals[stage][&value.id]);
            let life = Life { first: needed.first.min(arrival.latest), last: needed.last };
            if life.first < arrival.earliest || life.length() > interval {
                return None;
            }
            value.leaves.iter().for_each(|&leaf| read(leaf, life.first - 1));
            lives[stage].insert(value.id, life);
        }
        reads = before;
    }
    Some(lives)
}
