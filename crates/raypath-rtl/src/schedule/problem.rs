//! The scheduling problem: groups of values that share a stage, and their dependences.

use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::position::Stage;
use std::collections::{BTreeMap, BTreeSet};

/// The scheduling problem of an operation. Dead values are left out, and so are movable tests, whose stages follow from
/// those of the other values.
pub struct Problem<'g> {
    pub graph: &'g OperationGraph<Stage>,
    /// Values that share a stage, operands first. Groups are in topological order.
    pub groups: Vec<Vec<NodeId>>,
    /// The group of each value that is to be scheduled.
    pub group_of: Vec<Option<usize>>,
    /// The group that reads and writes each state; `None` if no group does.
    pub states: Vec<Option<usize>>,
}

impl<'g> Problem<'g> {
    pub fn new(graph: &'g OperationGraph<Stage>) -> Self {
        let nexts: BTreeSet<NodeId> = graph.states.iter().map(|state| state.next).collect();
        let live = graph.live();
        let placed: Vec<bool> = graph
            .ids()
            .map(|id| live[id.index()] && graph.is_computed(id) && (!graph.is_movable(id) || nexts.contains(&id)))
            .collect();
        let colocated = colocated(graph, &placed);
        let mut problem =
            Self { graph, groups: Vec::new(), group_of: vec![None; graph.nodes.len()], states: Vec::new() };
        problem.sort(&placed, &colocated);
        // A constant that is the next value of a state has no group, but the readers of that state have one.
        let of_next = |next: NodeId| {
            let mut group = graph.ids().filter(|&id| colocated.first(id) == colocated.first(next));
            group.find_map(|id| problem.group_of[id.index()])
        };
        problem.states = graph.states.iter().map(|state| of_next(state.next)).collect();
        problem
    }

    /// The scheduled operands of a value. A movable test is replaced by its operand.
    pub fn placed_operands(&self, id: NodeId) -> Vec<NodeId> {
        let operands = self.graph.operands(id).into_iter().filter_map(|operand| {
            let is_placed = |id: &NodeId| self.group_of[id.index()].is_some();
            let tested = self.graph.operands(operand).first().copied().filter(|_| self.graph.is_movable(operand));
            Some(operand).filter(is_placed).or(tested.filter(is_placed))
        });
        operands.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// The present stages of the groups.
    pub fn stages_of_groups(&self) -> Vec<u32> {
        self.groups.iter().map(|group| self.graph.node(group[0]).position.0).collect()
    }

    /// The stage of every value, given the stage of each group.
    pub fn stages_of_nodes(&self, stages: &[u32]) -> Vec<Stage> {
        let mut of_nodes = vec![Stage(0); self.graph.nodes.len()];
        for id in self.graph.ids() {
            let operands = self.graph.operands(id);
            of_nodes[id.index()] = match (self.group_of[id.index()], self.graph.node(id).op.clone()) {
                (Some(group), _) => Stage(stages[group]),
                (None, Op::Input(_)) => Stage(0),
                // Movable values and constants: as early as possible.
                _ => operands.iter().map(|operand| of_nodes[operand.index()]).max().unwrap_or(Stage(1)).max(Stage(1)),
            };
        }
        // A state whose next value is a constant is written in the stage that reads it.
        for (state, group) in self.graph.states.iter().zip(&self.states) {
            if let (true, &Some(group)) = (self.graph.is_everywhere(state.next), group) {
                of_nodes[state.next.index()] = Stage(stages[group]);
            }
        }
        of_nodes
    }

    /// The names of the units on a longest chain of values, first to last.
    pub fn longest_chain(&self, stages: &[u32]) -> Vec<String> {
        let mut chain = Vec::new();
        let mut at = (0..self.groups.len()).max_by_key(|&group| stages[group]);
        while let Some(group) = at {
            for &id in self.groups[group].iter().rev().filter(|&&id| class(self.graph, id) != Class::Logic) {
                let relation = self.groups[group].iter().find(|&&reader| self.graph.operands(reader).contains(&id));
                let named = [Some(id), relation.copied()].into_iter().flatten();
                let mut named = named.filter(|&id| self.graph.node(id).name.is_some());
                chain.push(self.graph.name_of(named.next().unwrap_or(id)));
            }
            let before = self.groups[group].iter().flat_map(|&id| self.placed_operands(id));
            let before = before.filter_map(|id| self.group_of[id.index()]).filter(|&other| other != group);
            at = before.max_by_key(|&group| (stages[group], group));
        }
        chain.reverse();
        chain
    }

    /// Sorts the groups topologically; independent groups keep the order of the graph.
    fn sort(&mut self, placed: &[bool], colocated: &DisjointSets) {
        let mut members: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
        for id in self.graph.ids().filter(|id| placed[id.index()]) {
            members.entry(colocated.first(id)).or_default().push(id);
        }
        let keys: Vec<NodeId> = members.keys().copied().collect();
        for (number, members) in members.values().enumerate() {
            members.iter().for_each(|id| self.group_of[id.index()] = Some(number));
        }
        let before: Vec<BTreeSet<usize>> = keys
            .iter()
            .enumerate()
            .map(|(number, key)| {
                let read = members[key].iter().flat_map(|&id| self.placed_operands(id));
                read.filter_map(|id| self.group_of[id.index()]).filter(|&other| other != number).collect()
            })
            .collect();
        let mut waits: Vec<usize> = before.iter().map(BTreeSet::len).collect();
        let mut after = vec![Vec::new(); keys.len()];
        for (number, before) in before.iter().enumerate() {
            before.iter().for_each(|&other| after[other].push(number));
        }
        let mut ready: BTreeSet<usize> = (0..keys.len()).filter(|&number| waits[number] == 0).collect();
        while let Some(number) = ready.pop_first() {
            for &other in &after[number] {
                waits[other] -= 1;
                if waits[other] == 0 {
                    ready.insert(other);
                }
            }
            let group = &members[&keys[number]];
            group.iter().for_each(|id| self.group_of[id.index()] = Some(self.groups.len()));
            self.groups.push(group.clone());
        }
    }
}

/// The contribution of a value to the path through a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// An adder or a multiplier.
    Unit,
    /// A comparator.
    Compare,
    /// Logic.
    Logic,
}

/// The class of a value.
pub fn class(graph: &OperationGraph<Stage>, id: NodeId) -> Class {
    match &graph.node(id).op {
        op if op.rounds() => Class::Unit,
        Op::Compare(..) => Class::Compare,
        _ => Class::Logic,
    }
}

/// The values that must share a stage: a comparison and its relations; the readers of a state, its next value, and the
/// values between them.
fn colocated(graph: &OperationGraph<Stage>, placed: &[bool]) -> DisjointSets {
    let mut sets = DisjointSets((0..graph.nodes.len()).collect());
    let placed = || graph.ids().filter(|id| placed[id.index()]);
    for id in placed() {
        if let Op::Relation(order, _) = graph.node(id).op {
            sets.join(order, id);
        }
    }
    let mut loops = BTreeSet::new();
    for (number, state) in graph.states.iter().enumerate() {
        let is_read = |id: &NodeId| graph.operands(*id).iter().any(|&o| graph.node(o).op == Op::State(number));
        for reader in placed().filter(is_read).filter(|_| !matches!(graph.node(state.next).op, Op::Input(_))) {
            sets.join(state.next, reader);
            loops.insert(state.next);
        }
    }
    while loops.iter().any(|&next| close(graph, &mut sets, next)) {}
    sets
}

/// Adds the values between the members of a group to the group. Returns whether there were any.
fn close(graph: &OperationGraph<Stage>, sets: &mut DisjointSets, member: NodeId) -> bool {
    let edges: Vec<(NodeId, NodeId)> = graph
        .ids()
        .filter(|&id| graph.is_computed(id))
        .flat_map(|id| graph.operands(id).into_iter().map(move |operand| (operand, id)))
        .filter(|&(operand, _)| graph.is_computed(operand))
        .map(|(operand, id)| (sets.first(operand), sets.first(id)))
        .filter(|(operand, id)| operand != id)
        .collect();
    let own = sets.first(member);
    let after = reached(own, edges.iter().copied());
    let before = reached(own, edges.iter().map(|&(operand, id)| (id, operand)));
    let between: Vec<NodeId> = after.intersection(&before).copied().filter(|&id| id != own).collect();
    between.iter().for_each(|&id| sets.join(own, id));
    !between.is_empty()
}

/// The values that a path of edges leads to.
fn reached(start: NodeId, edges: impl Iterator<Item = (NodeId, NodeId)>) -> BTreeSet<NodeId> {
    let mut next: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
    for (from, to) in edges {
        next.entry(from).or_default().push(to);
    }
    let (mut reached, mut open) = (BTreeSet::new(), vec![start]);
    while let Some(id) = open.pop() {
        let new = next.get(&id).into_iter().flatten().filter(|&&id| reached.insert(id));
        open.extend(new.copied());
    }
    reached
}

/// Disjoint sets of values. The first value of a set represents it.
struct DisjointSets(Vec<usize>);

impl DisjointSets {
    fn first(&self, id: NodeId) -> NodeId {
        let mut at = id.index();
        while self.0[at] != at {
            at = self.0[at];
        }
        NodeId(at as u32)
    }

    fn join(&mut self, a: NodeId, b: NodeId) {
        let (a, b) = (self.first(a).index(), self.first(b).index());
        self.0[a.max(b)] = a.min(b);
    }
}
