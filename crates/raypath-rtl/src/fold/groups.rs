//! Values of a stage that must be computed in one round, because they depend on each other.

use crate::ir::graph::{Kind, NodeId, Op, OperationGraph};
use crate::ir::liveness::PositionValues;
use crate::ir::position::Step;
use crate::ir::units::UnitKind;
use std::collections::{BTreeMap, BTreeSet};

/// A kind of units, and the part of them, from 0.
pub type UnitPart = (UnitKind, u32);

/// Units of a stage that depend on each other through its logic, and the logic that depends on them.
#[derive(Debug, Clone, Default)]
pub struct Group {
    /// The values that units compute.
    pub units: Vec<NodeId>,
    /// The number of units of each kind, or of their parts.
    pub kinds: BTreeMap<UnitPart, usize>,
    /// States that are read or written.
    pub states: Vec<usize>,
    /// The values that it reads from the registers before the stage.
    pub leaves: BTreeSet<NodeId>,
}

/// A value that is carried over the registers after a stage.
#[derive(Debug, Clone)]
pub struct Carried {
    pub id: NodeId,
    /// The group that it depends on. A value without a group is available in every round.
    pub group: Option<usize>,
    /// It goes to the next part of a unit, and cannot wait.
    pub is_inside_unit: bool,
    /// The values that it reads from the registers before the stage.
    pub leaves: BTreeSet<NodeId>,
}

/// The work of an operation in a stage.
#[derive(Debug, Clone, Default)]
pub struct Work {
    pub groups: Vec<Group>,
    pub carried: Vec<Carried>,
}

impl Work {
    /// The work in `step`, with `before` as the values in the registers before it.
    pub fn new(graph: &OperationGraph<Step>, step: Step, before: &PositionValues, here: &PositionValues) -> Self {
        let held: BTreeSet<NodeId> = before.carried.iter().copied().collect();
        let made: BTreeSet<NodeId> = here.made.iter().copied().filter(|id| !held.contains(id)).collect();
        let mut sets = Sets::new(graph.nodes.len() + graph.states.len());
        let state_set = |state: usize| graph.nodes.len() + state;
        let written: Vec<usize> = (0..graph.states.len()).filter(|&s| graph.states[s].written == step).collect();
        let mut anchored: BTreeSet<NodeId> = BTreeSet::new();
        for &id in &made {
            if graph.unit_part(id).is_some() {
                anchored.insert(id);
            }
            for operand in graph.operands(id) {
                if let Op::State(state) = graph.node(operand).op {
                    anchored.insert(id);
                    sets.join(id.index(), state_set(state));
                } else if anchored.contains(&operand) {
                    anchored.insert(id);
                    sets.join(id.index(), operand.index());
                }
            }
        }
        for &state in &written {
            let next = graph.states[state].next;
            if anchored.contains(&next) {
                sets.join(next.index(), state_set(state));
            }
        }
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        let mut groups: Vec<Group> = Vec::new();
        let mut group_of = |sets: &mut Sets, element: usize, groups: &mut Vec<Group>| {
            *numbers.entry(sets.root(element)).or_insert_with(|| {
                groups.push(Group::default());
                groups.len() - 1
            })
        };
        for &id in &anchored {
            let number = group_of(&mut sets, id.index(), &mut groups);
            let group = &mut groups[number];
            if let Some(part) = graph.unit_part(id) {
                group.units.push(id);
                *group.kinds.entry(part).or_default() += 1;
            }
            group.leaves.extend(leaves(graph, &held, id));
        }
        for &state in &written {
            let number = group_of(&mut sets, state_set(state), &mut groups);
            groups[number].states.push(state);
            groups[number].leaves.extend(leaves(graph, &held, graph.states[state].next));
        }
        let mut carried = Vec::new();
        for &id in &here.carried {
            let is_anchored = anchored.contains(&id) && !held.contains(&id);
            let group = is_anchored.then(|| group_of(&mut sets, id.index(), &mut groups));
            let is_inside_unit = matches!(graph.node(id).kind, Kind::Cut(..));
            carried.push(Carried { id, group, is_inside_unit, leaves: leaves(graph, &held, id) });
        }
        Self { groups, carried }
    }
}

/// The values in the registers before a stage that a value is computed from.
fn leaves(graph: &OperationGraph<Step>, held: &BTreeSet<NodeId>, id: NodeId) -> BTreeSet<NodeId> {
    let (mut found, mut seen, mut open) = (BTreeSet::new(), BTreeSet::new(), vec![id]);
    while let Some(id) = open.pop() {
        if held.contains(&id) {
            found.insert(id);
        } else if seen.insert(id) {
            open.extend(graph.operands(id));
        }
    }
    found
}

/// Disjoint sets of numbers.
struct Sets(Vec<usize>);

impl Sets {
    fn new(size: usize) -> Self {
        Self((0..size).collect())
    }

    fn root(&mut self, mut element: usize) -> usize {
        while self.0[element] != element {
            self.0[element] = self.0[self.0[element]];
            element = self.0[element];
        }
        element
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}
