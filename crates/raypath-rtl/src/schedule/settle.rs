//! When a group fits into a stage. The rules read the same from either end of the pipeline, so that going forwards and
//! going backwards are one piece of code: seen from the back, stage 10 is stage 1, and who reads a value is what it is
//! made of.

use super::LAST;
use super::problem::{Part, Problem, part};
use crate::graph::NodeId;

/// Comparators that may follow each other in a stage.
const COMPARATORS: u8 = 3;

/// The operation, seen from the front and from the back.
pub struct Sides {
    pub front: Side,
    pub back: Side,
}

/// An operation, seen from one end.
pub struct Side {
    /// Groups, each after those that it is made of.
    pub order: Vec<usize>,
    /// Values of each group in that order.
    members: Vec<Vec<NodeId>>,
    /// What each value is made of.
    near: Vec<Vec<NodeId>>,
    parts: Vec<Part>,
    group_of: Vec<usize>,
    /// Groups in which units follow each other whatever the stage is: loops that have to be.
    chains: Vec<bool>,
    is_back: bool,
}

/// What follows each other in a stage up to a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Level {
    /// An adder or a multiplier.
    unit: bool,
    compares: u8,
}

impl Sides {
    pub fn new(problem: &Problem<'_>) -> Self {
        Self { front: Side::new(problem, false), back: Side::new(problem, true) }
    }

    /// The first stage in which each group can be, units being plenty; beyond the last one where there are too few.
    pub fn earliest(&self) -> Vec<u32> {
        let mut stages = vec![1; self.front.order.len()];
        self.front.settle(&mut stages);
        stages
    }

    /// The last one likewise.
    pub fn latest(&self) -> Vec<u32> {
        let mut stages = vec![1; self.back.order.len()];
        self.back.settle(&mut stages);
        mirror(&mut stages);
        stages
    }

    /// Moves groups to later stages until each has what it is made of in time.
    pub fn settle_later(&self, stages: &mut [u32]) {
        self.front.settle(stages);
    }

    /// Moves groups to earlier stages until each is in time for who reads it.
    pub fn settle_earlier(&self, stages: &mut [u32]) {
        mirror(stages);
        self.back.settle(stages);
        mirror(stages);
    }
}

/// Stages, seen from the other end. One that is out of range stays so.
pub fn mirror(stages: &mut [u32]) {
    stages.iter_mut().for_each(|stage| *stage = (LAST + 1).wrapping_sub(*stage));
}

impl Side {
    fn new(problem: &Problem<'_>, is_back: bool) -> Self {
        let traced = problem.traced;
        let count = traced.nodes.len();
        let mut near = vec![Vec::new(); count];
        for id in problem.groups.iter().flatten() {
            for operand in problem.made_of(*id) {
                let (of, what) = if is_back { (operand, *id) } else { (*id, operand) };
                near[of.index()].push(what);
            }
        }
        let mut order: Vec<usize> = (0..problem.groups.len()).collect();
        let mut members = problem.groups.clone();
        if is_back {
            order.reverse();
            members.iter_mut().for_each(|members| members.reverse());
        }
        let parts = (0..count as u32).map(|id| part(traced, NodeId(id))).collect();
        let group_of = problem.group_of.iter().map(|group| group.unwrap_or(usize::MAX)).collect();
        let chains = vec![false; problem.groups.len()];
        let mut side = Self { order, members, near, parts, group_of, chains, is_back };
        let mut levels = side.levels();
        for group in 0..side.members.len() {
            let mut alone = vec![0; side.members.len()];
            alone[group] = 1;
            side.chains[group] = !side.enter(group, &alone, &mut levels);
        }
        side
    }

    pub fn levels(&self) -> Vec<Level> {
        vec![Level::default(); self.near.len()]
    }

    /// The stage that it counts as this one.
    pub fn stage(&self, stage: u32) -> u32 {
        if self.is_back { LAST + 1 - stage } else { stage }
    }

    /// The first stage in which a group can be, given those of the groups before it; not before `least`.
    pub fn first(&self, group: usize, least: u32, stages: &mut [u32], levels: &mut [Level]) -> u32 {
        let near = self.members[group].iter().flat_map(|id| &self.near[id.index()]);
        let others = near.map(|id| self.group_of[id.index()]).filter(|&other| other != group);
        stages[group] = others.map(|other| stages[other]).max().unwrap_or(1).max(least);
        if !self.enter(group, stages, levels) {
            stages[group] += 1;
            self.enter(group, stages, levels);
        }
        stages[group]
    }

    fn settle(&self, stages: &mut [u32]) {
        let mut levels = self.levels();
        for &group in &self.order {
            self.first(group, stages[group], stages, &mut levels);
        }
    }

    /// Works out the levels of a group in its stage, and whether it fits there.
    fn enter(&self, group: usize, stages: &[u32], levels: &mut [Level]) -> bool {
        let (mut fits, mut is_apart) = (true, true);
        for &id in &self.members[group] {
            let mut level = Level::default();
            for near in &self.near[id.index()] {
                if stages[self.group_of[near.index()]] == stages[group] {
                    let Level { unit, compares } = levels[near.index()];
                    is_apart &= self.group_of[near.index()] == group || levels[near.index()] == Level::default();
                    level = Level { unit: level.unit | unit, compares: level.compares.max(compares) };
                }
            }
            match self.parts[id.index()] {
                Part::Unit => {
                    fits &= level == Level::default();
                    level.unit = true;
                }
                Part::Compare => {
                    fits &= !level.unit && level.compares < COMPARATORS;
                    level.compares = level.compares.saturating_add(1);
                }
                Part::Logic => {}
            }
            levels[id.index()] = level;
        }
        // What has to be chained has no other units beside it.
        if self.chains[group] { is_apart } else { fits }
    }
}
