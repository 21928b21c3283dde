//! What is to be scheduled: groups of values that share a stage, and what each is made of.

use super::is_made;
use crate::graph::{NodeId, Op, Traced};
use std::collections::{BTreeMap, BTreeSet};

/// An operation as the scheduler sees it. What nobody reads is left out, and so are tests that float: where they are
/// made follows from the rest.
pub struct Problem<'t> {
    pub traced: &'t Traced,
    /// Values that share a stage, operands first; groups come after those that they read.
    pub groups: Vec<Vec<NodeId>>,
    /// The group of each value that has a stage to be found.
    pub group_of: Vec<Option<usize>>,
    /// The group that reads and writes each state; none where that needs no stage.
    pub states: Vec<Option<usize>>,
}

impl<'t> Problem<'t> {
    pub fn new(traced: &'t Traced) -> Self {
        let nexts: BTreeSet<NodeId> = traced.states.iter().map(|state| state.next).collect();
        let live = traced.live();
        let placed: Vec<bool> = traced
            .ids()
            .map(|id| live[id.index()] && is_made(traced, id) && (!traced.floats(id) || nexts.contains(&id)))
            .collect();
        let fellows = fellows(traced, &placed);
        let mut problem =
            Self { traced, groups: Vec::new(), group_of: vec![None; traced.nodes.len()], states: Vec::new() };
        problem.sort(&placed, &fellows);
        // A constant that becomes state has no group, but fellows that read that state.
        let of_next = |next: NodeId| {
            let mut fellows = traced.ids().filter(|&id| fellows.first(id) == fellows.first(next));
            fellows.find_map(|id| problem.group_of[id.index()])
        };
        problem.states = traced.states.iter().map(|state| of_next(state.next)).collect();
        problem
    }

    /// The values with a stage that a value is made of; a test that floats stands for what it tests.
    pub fn made_of(&self, id: NodeId) -> Vec<NodeId> {
        let operands = self.traced.operands(id).into_iter().filter_map(|operand| {
            let is_placed = |id: &NodeId| self.group_of[id.index()].is_some();
            let tested = self.traced.operands(operand).first().copied().filter(|_| self.traced.floats(operand));
            Some(operand).filter(is_placed).or(tested.filter(is_placed))
        });
        operands.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// The stages that groups have in the record.
    pub fn stages_of_groups(&self) -> Vec<u32> {
        self.groups.iter().map(|group| self.traced.node(group[0]).stage).collect()
    }

    /// The stage of every value, given those of groups.
    pub fn stages_of_nodes(&self, stages: &[u32]) -> Vec<u32> {
        let mut of_nodes: Vec<u32> = vec![0; self.traced.nodes.len()];
        for id in self.traced.ids() {
            let operands = self.traced.operands(id);
            of_nodes[id.index()] = match (self.group_of[id.index()], self.traced.node(id).op.clone()) {
                (Some(group), _) => stages[group],
                (None, Op::Input(_)) => 0,
                // As early as can be: what floats, what is everywhere.
                _ => operands.iter().map(|operand| of_nodes[operand.index()]).max().unwrap_or(0).max(1),
            };
        }
        // State that becomes a constant does so where it is read.
        for (state, group) in self.traced.states.iter().zip(&self.states) {
            if let (true, &Some(group)) = (self.traced.is_everywhere(state.next), group) {
                of_nodes[state.next.index()] = stages[group];
            }
        }
        of_nodes
    }

    /// The units along a chain of values that ends in the last of these stages, first to last.
    pub fn longest_chain(&self, stages: &[u32]) -> Vec<String> {
        let mut chain = Vec::new();
        let mut at = (0..self.groups.len()).max_by_key(|&group| stages[group]);
        while let Some(group) = at {
            for &id in self.groups[group].iter().rev().filter(|&&id| part(self.traced, id) != Part::Logic) {
                let relation = self.groups[group].iter().find(|&&reader| self.traced.operands(reader).contains(&id));
                let named = [Some(id), relation.copied()].into_iter().flatten();
                let mut named = named.filter(|&id| self.traced.node(id).name.is_some());
                chain.push(self.traced.name_of(named.next().unwrap_or(id)));
            }
            let before = self.groups[group].iter().flat_map(|&id| self.made_of(id));
            let before = before.filter_map(|id| self.group_of[id.index()]).filter(|&other| other != group);
            at = before.max_by_key(|&group| (stages[group], group));
        }
        chain.reverse();
        chain
    }

    /// Puts groups into an order in which each comes after those that it reads, otherwise as recorded.
    fn sort(&mut self, placed: &[bool], fellows: &Fellows) {
        let mut members: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
        for id in self.traced.ids().filter(|id| placed[id.index()]) {
            members.entry(fellows.first(id)).or_default().push(id);
        }
        let keys: Vec<NodeId> = members.keys().copied().collect();
        for (number, members) in members.values().enumerate() {
            members.iter().for_each(|id| self.group_of[id.index()] = Some(number));
        }
        let before: Vec<BTreeSet<usize>> = keys
            .iter()
            .enumerate()
            .map(|(number, key)| {
                let read = members[key].iter().flat_map(|&id| self.made_of(id));
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

/// What a value is to a stage's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// An adder or a multiplier.
    Unit,
    Compare,
    Logic,
}

pub fn part(traced: &Traced, id: NodeId) -> Part {
    match &traced.node(id).op {
        op if op.rounds() => Part::Unit,
        Op::Compare(..) => Part::Compare,
        _ => Part::Logic,
    }
}

/// A comparison and its relations share a stage; so do all that read a state, its next value, and what lies between.
fn fellows(traced: &Traced, placed: &[bool]) -> Fellows {
    let mut fellows = Fellows((0..traced.nodes.len()).collect());
    let placed = || traced.ids().filter(|id| placed[id.index()]);
    for id in placed() {
        if let Op::Relation(order, _) = traced.node(id).op {
            fellows.join(order, id);
        }
    }
    let mut loops = BTreeSet::new();
    for (number, state) in traced.states.iter().enumerate() {
        let is_read = |id: &NodeId| traced.operands(*id).iter().any(|&o| traced.node(o).op == Op::State(number));
        for reader in placed().filter(is_read).filter(|_| !matches!(traced.node(state.next).op, Op::Input(_))) {
            fellows.join(state.next, reader);
            loops.insert(state.next);
        }
    }
    while loops.iter().any(|&next| close(traced, &mut fellows, next)) {}
    fellows
}

/// Joins what lies between members of a group to it; whether there was something.
fn close(traced: &Traced, fellows: &mut Fellows, member: NodeId) -> bool {
    let edges: Vec<(NodeId, NodeId)> = traced
        .ids()
        .filter(|&id| is_made(traced, id))
        .flat_map(|id| traced.operands(id).into_iter().map(move |operand| (operand, id)))
        .filter(|&(operand, _)| is_made(traced, operand))
        .map(|(operand, id)| (fellows.first(operand), fellows.first(id)))
        .filter(|(operand, id)| operand != id)
        .collect();
    let own = fellows.first(member);
    let reach = |along: &dyn Fn((NodeId, NodeId)) -> (NodeId, NodeId)| {
        let mut next: BTreeMap<NodeId, Vec<NodeId>> = BTreeMap::new();
        for (from, to) in edges.iter().copied().map(along) {
            next.entry(from).or_default().push(to);
        }
        let (mut reached, mut open) = (BTreeSet::new(), vec![own]);
        while let Some(id) = open.pop() {
            let new = next.get(&id).into_iter().flatten().filter(|&&id| reached.insert(id));
            open.extend(new.copied());
        }
        reached
    };
    let (after, before) = (reach(&|edge| edge), reach(&|(operand, id)| (id, operand)));
    let between: Vec<NodeId> = after.intersection(&before).copied().filter(|&id| id != own).collect();
    between.iter().for_each(|&id| fellows.join(own, id));
    !between.is_empty()
}

/// Sets of values, each known by its first.
struct Fellows(Vec<usize>);

impl Fellows {
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
