//! Assigns the groups of every stage to rounds.

use super::groups::{Carried, Group, UnitPart, Work};
use crate::ir::graph::NodeId;
use std::collections::{BTreeMap, BTreeSet};

/// The positions at which a value may come into the registers that carry it.
#[derive(Debug, Clone, Copy)]
pub struct Arrival {
    pub earliest: u32,
    pub latest: u32,
    /// The positions that it may stay there after the one at which it came.
    pub stays: u32,
}

/// The rounds of one stage.
#[derive(Debug, Clone, Default)]
pub struct StageRounds {
    /// For each operation the round of each group.
    pub rounds: Vec<Vec<u32>>,
    /// The units that are needed.
    pub units: BTreeMap<UnitPart, usize>,
    /// For each operation when its values may come into the registers after the stage.
    pub arrivals: Vec<BTreeMap<NodeId, Arrival>>,
}

/// Assigns rounds to the stages one after another, each with as few units as the operands' arrivals allow. `starts` are
/// the first positions of the stages; the first entry, that of the input, is not used. The last stage has one round.
pub fn assign(interval: u32, works: &[Vec<Work>], starts: &[u32]) -> Option<Vec<StageRounds>> {
    let stages = starts.len();
    let at_once = Arrival { earliest: 0, latest: 0, stays: interval - 1 };
    let inputs = works.iter().map(|work| work[0].carried.iter().map(|value| (value.id, at_once)).collect());
    let input = StageRounds { rounds: vec![Vec::new(); works.len()], arrivals: inputs.collect(), ..Default::default() };
    let mut assigned = vec![input];
    for stage in 1..stages {
        let known = &assigned[stage - 1].arrivals;
        let rounds = if stage + 1 == stages { 1 } else { interval };
        let at = Stage { interval, rounds, start: starts[stage] };
        let mut windows = Vec::new();
        for (work, known) in works.iter().zip(known) {
            let groups = work[stage].groups.iter();
            windows.push(groups.map(|group| at.window(group, known)).collect::<Option<Vec<Window>>>()?);
        }
        let mut found = stage_rounds(works, stage, rounds, &windows);
        for ((work, known), rounds) in works.iter().zip(known).zip(&found.rounds) {
            found.arrivals.push(at.arrivals(&work[stage], rounds, known)?);
        }
        assigned.push(found);
    }
    Some(assigned)
}

/// The first and the last round in which all operands of a group are in their registers.
type Window = (u32, u32);

/// The positions of a stage.
#[derive(Clone, Copy)]
struct Stage {
    interval: u32,
    rounds: u32,
    start: u32,
}

impl Stage {
    /// The positions between `first` and `last` at which all of `leaves` can be in their registers.
    fn readable(
        self,
        leaves: &BTreeSet<NodeId>,
        known: &BTreeMap<NodeId, Arrival>,
        first: u32,
        last: u32,
    ) -> Option<(u32, u32)> {
        let earliest = leaves.iter().map(|leaf| known[leaf].earliest).fold(first, u32::max);
        let latest = leaves.iter().map(|leaf| known[leaf].latest + known[leaf].stays).fold(last, u32::min);
        (earliest <= latest).then_some((earliest, latest))
    }

    fn window(self, group: &Group, known: &BTreeMap<NodeId, Arrival>) -> Option<Window> {
        let found = self.readable(&group.leaves, known, self.start, self.start + self.rounds - 1)?;
        Some((found.0 - self.start, found.1 - self.start))
    }

    /// When the values that the stage passes on may come into the registers after it, with these rounds of its groups.
    fn arrivals(
        self,
        work: &Work,
        assigned: &[u32],
        known: &BTreeMap<NodeId, Arrival>,
    ) -> Option<BTreeMap<NodeId, Arrival>> {
        let arrival = |value: &Carried| {
            let (first, last) = value.group.map_or((0, self.rounds - 1), |group| (assigned[group], assigned[group]));
            let (earliest, latest) = self.readable(&value.leaves, known, self.start + first, self.start + last)?;
            let stays = if value.is_inside_unit { 0 } else { self.interval - 1 };
            Some((value.id, Arrival { earliest: earliest + 1, latest: latest + 1, stays }))
        };
        work.carried.iter().map(arrival).collect()
    }
}

/// List scheduling of one stage: the least number of units, then every group as early as possible.
fn stage_rounds(works: &[Vec<Work>], stage: usize, rounds: u32, windows: &[Vec<Window>]) -> StageRounds {
    let mut units: BTreeMap<UnitPart, usize> = BTreeMap::new();
    for work in works {
        let mut totals: BTreeMap<UnitPart, (usize, usize)> = BTreeMap::new();
        for (&kind, &count) in work[stage].groups.iter().flat_map(|group| &group.kinds) {
            let (total, most) = totals.entry(kind).or_default();
            (*total, *most) = (*total + count, (*most).max(count));
        }
        for (kind, (total, most)) in totals {
            let least = units.entry(kind).or_default();
            *least = (*least).max(most).max(total.div_ceil(rounds as usize));
        }
    }
    loop {
        let tried: Result<Vec<Vec<u32>>, &Group> =
            works.iter().zip(windows).map(|(work, windows)| list(&work[stage].groups, windows, &units)).collect();
        match tried {
            Ok(rounds) => return StageRounds { rounds, units, arrivals: Vec::new() },
            Err(group) => group.kinds.keys().for_each(|kind| *units.entry(*kind).or_default() += 1),
        }
    }
}

/// The rounds of an operation's groups with these units, or the group that does not fit.
fn list<'a>(groups: &'a [Group], windows: &[Window], units: &BTreeMap<UnitPart, usize>) -> Result<Vec<u32>, &'a Group> {
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|&group| (windows[group], group));
    let mut free: BTreeMap<(u32, UnitPart), usize> = BTreeMap::new();
    let mut rounds = vec![0; groups.len()];
    for number in order {
        let group = &groups[number];
        let (first, last) = windows[number];
        let has_room = |round: &u32| {
            group.kinds.iter().all(|(&kind, &count)| free.get(&(*round, kind)).unwrap_or(&units[&kind]) >= &count)
        };
        let round = (first..=last).find(has_room).ok_or(group)?;
        for (&kind, &count) in &group.kinds {
            *free.entry((round, kind)).or_insert(units[&kind]) -= count;
        }
        rounds[number] = round;
    }
    Ok(rounds)
}
