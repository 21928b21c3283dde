//! Local improvement: applies small changes that reduce the cost.

use super::cost::Costs;
use super::problem::Problem;
use super::settle::Directions;
use crate::ir::position::LAST_STAGE;
use std::collections::BTreeSet;

/// The greatest number of rounds over all changes. A few are usually enough; the limit bounds the time.
const MAX_ROUNDS: usize = 50;

/// Moves single groups, all readers of a value together, and all groups with state together, each with the groups that
/// must move along, until no such move reduces the cost.
pub fn improve(problem: &Problem<'_>, directions: &Directions, costs: &Costs<'_>, start: Vec<u32>) -> Vec<u32> {
    let (mut stages, mut cost) = (start.clone(), costs.of(&start));
    let (earliest, latest) = (directions.earliest(), directions.latest());
    let sets = sets(problem);
    for _ in 0..MAX_ROUNDS {
        let before = cost;
        for set in &sets {
            let first = set.iter().map(|&group| earliest[group]).min().unwrap_or(1);
            let last = set.iter().map(|&group| latest[group]).max().unwrap_or(1);
            for target in first..=last {
                for changed in [later(directions, &stages, set, target), earlier(directions, &stages, set, target)] {
                    let Some(changed) = changed else { continue };
                    let new = costs.of(&changed);
                    if new < cost {
                        (stages, cost) = (changed, new);
                    }
                }
            }
        }
        if cost == before {
            break;
        }
    }
    stages
}

/// The sets of groups to move together: each group alone, the readers of each value, and the groups with state.
fn sets(problem: &Problem<'_>) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = (0..problem.groups.len()).map(|group| vec![group]).collect();
    let mut readers: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); problem.graph.nodes.len()];
    for (number, group) in problem.groups.iter().enumerate() {
        for operand in group.iter().flat_map(|&id| problem.graph.operands(id)) {
            readers[operand.index()].insert(number);
        }
    }
    let several = readers.into_iter().filter(|readers| readers.len() > 1).collect::<BTreeSet<_>>();
    sets.extend(several.into_iter().map(|readers| readers.into_iter().collect()));
    sets.push(problem.states.iter().flatten().copied().collect());
    sets
}

/// Moves the groups of the set that are before `target` to `target`, and the groups that depend on them to later
/// stages.
/// `None` if no group is before `target`, or a group would leave the pipeline.
fn later(directions: &Directions, stages: &[u32], set: &[usize], target: u32) -> Option<Vec<u32>> {
    let moved: Vec<usize> = set.iter().copied().filter(|&group| stages[group] < target).collect();
    change(stages, &moved, target, |stages| directions.settle_later(stages))
}

/// Moves the groups of the set that are after `target` to `target`, and the groups that they depend on to earlier
/// stages.
/// `None` if no group is after `target`, or a group would leave the pipeline.
fn earlier(directions: &Directions, stages: &[u32], set: &[usize], target: u32) -> Option<Vec<u32>> {
    let moved: Vec<usize> = set.iter().copied().filter(|&group| stages[group] > target).collect();
    change(stages, &moved, target, |stages| directions.settle_earlier(stages))
}

fn change(stages: &[u32], moved: &[usize], target: u32, settle: impl Fn(&mut [u32])) -> Option<Vec<u32>> {
    if moved.is_empty() {
        return None;
    }
    let mut changed = stages.to_vec();
    moved.iter().for_each(|&group| changed[group] = target);
    settle(&mut changed);
    changed.iter().all(|stage| (1..=LAST_STAGE).contains(stage)).then_some(changed)
}
