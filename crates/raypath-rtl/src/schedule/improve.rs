//! Local improvement: small changes, each taken if it costs less.

use super::LAST;
use super::cost::Costs;
use super::problem::Problem;
use super::settle::Sides;
use std::collections::BTreeSet;

/// Rounds over all changes. Each takes at least a bit away, and a handful is enough; this bounds the time.
const ROUNDS: usize = 50;

/// Moves single groups, all readers of a value together, and all that a group is made of or makes with it, until no
/// such change makes the schedule cheaper.
pub fn improve(problem: &Problem<'_>, sides: &Sides, costs: &Costs<'_>, start: Vec<u32>) -> Vec<u32> {
    let (mut stages, mut cost) = (start.clone(), costs.of(&start));
    let (earliest, latest) = (sides.earliest(), sides.latest());
    let sets = sets(problem);
    for _ in 0..ROUNDS {
        let before = cost;
        for set in &sets {
            let first = set.iter().map(|&group| earliest[group]).min().unwrap_or(1);
            let last = set.iter().map(|&group| latest[group]).max().unwrap_or(1);
            for target in first..=last {
                for changed in [later(sides, &stages, set, target), earlier(sides, &stages, set, target)] {
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

/// Groups that are moved together: each alone, the readers of each value, and those with state.
fn sets(problem: &Problem<'_>) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = (0..problem.groups.len()).map(|group| vec![group]).collect();
    let mut readers: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); problem.traced.nodes.len()];
    for (number, group) in problem.groups.iter().enumerate() {
        for operand in group.iter().flat_map(|&id| problem.traced.operands(id)) {
            readers[operand.index()].insert(number);
        }
    }
    let several = readers.into_iter().filter(|readers| readers.len() > 1).collect::<BTreeSet<_>>();
    sets.extend(several.into_iter().map(|readers| readers.into_iter().collect()));
    sets.push(problem.states.iter().flatten().copied().collect());
    sets
}

/// Moves whoever of the set is before `target` to it, and later what has to follow; none where that is nobody or too
/// far.
fn later(sides: &Sides, stages: &[u32], set: &[usize], target: u32) -> Option<Vec<u32>> {
    let moved: Vec<usize> = set.iter().copied().filter(|&group| stages[group] < target).collect();
    change(stages, &moved, target, |stages| sides.settle_later(stages))
}

/// Moves whoever is behind `target` to it, and earlier what has to come before.
fn earlier(sides: &Sides, stages: &[u32], set: &[usize], target: u32) -> Option<Vec<u32>> {
    let moved: Vec<usize> = set.iter().copied().filter(|&group| stages[group] > target).collect();
    change(stages, &moved, target, |stages| sides.settle_earlier(stages))
}

fn change(stages: &[u32], moved: &[usize], target: u32, settle: impl Fn(&mut [u32])) -> Option<Vec<u32>> {
    if moved.is_empty() {
        return None;
    }
    let mut changed = stages.to_vec();
    moved.iter().for_each(|&group| changed[group] = target);
    settle(&mut changed);
    changed.iter().all(|stage| (1..=LAST).contains(stage)).then_some(changed)
}
