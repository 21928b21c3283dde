//! List scheduling: in order of urgency, each group in the first stage with its operands and free units.

use super::budget::{Budget, KINDS};
use super::problem::Problem;
use super::settle::{Direction, Directions, mirror};
use crate::ir::position::LAST_STAGE;
use crate::ir::units::{UnitKind, Units};

/// The schedule with every group as early as possible.
pub fn forwards(problem: &Problem<'_>, directions: &Directions, allowed: &Budget) -> Vec<u32> {
    list(problem, &directions.forward, directions.latest(), allowed)
}

/// The schedule with every group as late as possible.
pub fn backwards(problem: &Problem<'_>, directions: &Directions, allowed: &Budget) -> Vec<u32> {
    let mut last = directions.earliest();
    mirror(&mut last);
    let mut stages = list(problem, &directions.backward, last, allowed);
    mirror(&mut stages);
    stages
}

/// Schedules in one direction. `last` is the last possible stage of each group. If no stage until then has free units,
/// the group is placed in the first of the stages with the most units.
fn list(problem: &Problem<'_>, direction: &Direction, last: Vec<u32>, allowed: &Budget) -> Vec<u32> {
    // The sort is stable, and a group is never more urgent than its operands.
    let mut order = direction.order.clone();
    order.sort_by_key(|&group| last[group]);
    let mut stages = vec![1; order.len()];
    let mut levels = direction.levels();
    let mut used = vec![Units::default(); LAST_STAGE as usize + 2];
    for group in order {
        let kinds: Vec<UnitKind> =
            problem.groups[group].iter().filter_map(|&id| problem.graph.unit_part(id)).map(|(kind, _)| kind).collect();
        let allowed = |stage: u32| allowed.units(direction.stage(stage));
        let most = |stage: &u32| kinds.iter().map(|&kind| allowed(*stage).of(kind)).max();
        let has_room = |stage: u32, used: &[Units]| {
            let (allowed, used) = (allowed(stage), used[stage as usize]);
            KINDS.iter().all(|&kind| {
                let more = kinds.iter().filter(|&&other| other == kind).count();
                more == 0 || used.of(kind).saturating_add(more) <= allowed.of(kind)
            })
        };
        let first = direction.first(group, 1, &mut stages, &mut levels);
        let window = first..=last[group];
        let free = window.clone().find(|&stage| has_room(stage, &used));
        let chosen = free.or_else(|| window.rev().max_by_key(most)).unwrap_or(first);
        direction.first(group, chosen, &mut stages, &mut levels);
        kinds.iter().for_each(|&kind| *used[stages[group] as usize].of_mut(kind) += 1);
    }
    stages
}
