//! List scheduling: the most urgent group first, each in the first stage that has its operands and free units.

use super::problem::Problem;
use super::settle::{Side, Sides, mirror};
use crate::budget::{Budget, KINDS};
use crate::units::{UnitKind, Units, part};

/// As early as possible.
pub fn forwards(problem: &Problem<'_>, sides: &Sides, allowed: &Budget) -> Vec<u32> {
    list(problem, &sides.front, sides.latest(), allowed)
}

/// As late as possible.
pub fn backwards(problem: &Problem<'_>, sides: &Sides, allowed: &Budget) -> Vec<u32> {
    let mut last = sides.earliest();
    mirror(&mut last);
    let mut stages = list(problem, &sides.back, last, allowed);
    mirror(&mut stages);
    stages
}

/// From one side. Of a group, `last` is the last stage that leaves those after it time enough; where no stage until
/// then has units left, it takes the one that has the most, of those the first.
fn list(problem: &Problem<'_>, side: &Side, last: Vec<u32>, allowed: &Budget) -> Vec<u32> {
    // Groups that are equally urgent keep their order; no group is more urgent than what it is made of.
    let mut order = side.order.clone();
    order.sort_by_key(|&group| last[group]);
    let mut stages = vec![1; order.len()];
    let mut levels = side.levels();
    let mut used = vec![Units::default(); super::LAST as usize + 2];
    for group in order {
        let kinds: Vec<UnitKind> =
            problem.groups[group].iter().filter_map(|&id| part(problem.traced, id)).map(|(kind, _)| kind).collect();
        let allowed = |stage: u32| allowed.units(side.stage(stage));
        let most = |stage: &u32| kinds.iter().map(|&kind| allowed(*stage).of(kind)).max();
        let has_room = |stage: u32, used: &[Units]| {
            let (allowed, used) = (allowed(stage), used[stage as usize]);
            KINDS.iter().all(|&kind| {
                let more = kinds.iter().filter(|&&other| other == kind).count();
                more == 0 || used.of(kind).saturating_add(more) <= allowed.of(kind)
            })
        };
        let first = side.first(group, 1, &mut stages, &mut levels);
        let window = first..=last[group];
        let free = window.clone().find(|&stage| has_room(stage, &used));
        let chosen = free.or_else(|| window.rev().max_by_key(most)).unwrap_or(first);
        side.first(group, chosen, &mut stages, &mut levels);
        kinds.iter().for_each(|&kind| *used[stages[group] as usize].of_mut(kind) += 1);
    }
    stages
}
