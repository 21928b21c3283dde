//! The rules for placing groups in stages. They are symmetric, so the same code schedules forwards and backwards: in
//! the backward direction, stage 10 counts as stage 1, and the readers of a value count as its operands.

use super::problem::{Class, Problem, class};
use crate::ir::graph::NodeId;
use crate::ir::position::LAST_STAGE;

/// The greatest number of comparators in a row in a stage.
const MAX_COMPARATORS: u8 = 3;

/// The problem in both directions.
pub struct Directions {
    pub forward: Direction,
    pub backward: Direction,
}

/// The problem in one direction.
pub struct Direction {
    /// The groups, operands first.
    pub order: Vec<usize>,
    /// The values of each group, operands first.
    members: Vec<Vec<NodeId>>,
    /// The operands of each value.
    near: Vec<Vec<NodeId>>,
    classes: Vec<Class>,
    group_of: Vec<usize>,
    /// The groups with chains of units that cannot be divided, because they are loops through state.
    chains: Vec<bool>,
    is_backward: bool,
}

/// The units on the path from the beginning of a stage to a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Level {
    /// Whether there is an adder or a multiplier.
    unit: bool,
    /// The number of comparators.
    compares: u8,
}

impl Directions {
    pub fn new(problem: &Problem<'_>) -> Self {
        Self { forward: Direction::new(problem, false), backward: Direction::new(problem, true) }
    }

    /// The first possible stage of each group with unlimited units. It may be beyond the last stage.
    pub fn earliest(&self) -> Vec<u32> {
        let mut stages = vec![1; self.forward.order.len()];
        self.forward.settle(&mut stages);
        stages
    }

    /// The last possible stage of each group with unlimited units.
    pub fn latest(&self) -> Vec<u32> {
        let mut stages = vec![1; self.backward.order.len()];
        self.backward.settle(&mut stages);
        mirror(&mut stages);
        stages
    }

    /// Moves groups to later stages until each has its operands.
    pub fn settle_later(&self, stages: &mut [u32]) {
        self.forward.settle(stages);
    }

    /// Moves groups to earlier stages until each is available to its readers.
    pub fn settle_earlier(&self, stages: &mut [u32]) {
        mirror(stages);
        self.backward.settle(stages);
        mirror(stages);
    }
}

/// Renumbers stages for the other direction. A stage out of range stays out of range.
pub fn mirror(stages: &mut [u32]) {
    stages.iter_mut().for_each(|stage| *stage = (LAST_STAGE + 1).wrapping_sub(*stage));
}

impl Direction {
    fn new(problem: &Problem<'_>, is_backward: bool) -> Self {
        let graph = problem.graph;
        let count = graph.nodes.len();
        let mut near = vec![Vec::new(); count];
        for id in problem.groups.iter().flatten() {
            for operand in problem.placed_operands(*id) {
                let (of, what) = if is_backward { (operand, *id) } else { (*id, operand) };
                near[of.index()].push(what);
            }
        }
        let mut order: Vec<usize> = (0..problem.groups.len()).collect();
        let mut members = problem.groups.clone();
        if is_backward {
            order.reverse();
            members.iter_mut().for_each(|members| members.reverse());
        }
        let classes = (0..count as u32).map(|id| class(graph, NodeId(id))).collect();
        let group_of = problem.group_of.iter().map(|group| group.unwrap_or(usize::MAX)).collect();
        let chains = vec![false; problem.groups.len()];
        let mut direction = Self { order, members, near, classes, group_of, chains, is_backward };
        let mut levels = direction.levels();
        for group in 0..direction.members.len() {
            let mut alone = vec![0; direction.members.len()];
            alone[group] = 1;
            direction.chains[group] = !direction.enter(group, &alone, &mut levels);
        }
        direction
    }

    pub fn levels(&self) -> Vec<Level> {
        vec![Level::default(); self.near.len()]
    }

    /// The stage that has this number in this direction.
    pub fn stage(&self, stage: u32) -> u32 {
        if self.is_backward { LAST_STAGE + 1 - stage } else { stage }
    }

    /// Places a group in its first possible stage from `least`, given the stages of its operands, and returns the
    /// stage.
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

    /// Computes the levels of a group in its stage. Returns whether the group fits there.
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
            match self.classes[id.index()] {
                Class::Unit => {
                    fits &= level == Level::default();
                    level.unit = true;
                }
                Class::Compare => {
                    fits &= !level.unit && level.compares < MAX_COMPARATORS;
                    level.compares = level.compares.saturating_add(1);
                }
                Class::Logic => {}
            }
            levels[id.index()] = level;
        }
        // An indivisible chain shares its stage with no other unit of its operands.
        if self.chains[group] { is_apart } else { fits }
    }
}
