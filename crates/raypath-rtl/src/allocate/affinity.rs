//! Affinity: how well two values of different operations share a register, judged by the units that read them.

use crate::allocate::layout::Slots;
use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::position::Step;
use crate::ir::units::UnitKind;
use std::collections::BTreeMap;

/// The units that read each value of an operation, in the first step in which any does.
#[derive(Debug)]
pub struct Affinity(BTreeMap<NodeId, Vec<UnitRead>>);

/// A read of a value by a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct UnitRead {
    step: Step,
    kind: UnitKind,
    /// The operand, if the unit's operands cannot be exchanged.
    operand: Option<usize>,
    /// The unit's other operand.
    other_operand: NodeId,
}

impl Affinity {
    pub fn new(graph: &OperationGraph<Step>) -> Self {
        let mut reads: BTreeMap<NodeId, Vec<UnitRead>> = BTreeMap::new();
        for id in graph.ids() {
            let operands = graph.operands(id);
            let (Some((kind, 0)), &[a, b]) = (graph.unit_part(id), operands.as_slice()) else { continue };
            let ordered = matches!(graph.node(id).op, Op::Subtract(..) | Op::Compare(..));
            for (operand, value, other_operand) in [(0, a, b), (1, b, a)] {
                let step = graph.node(id).position;
                let read = UnitRead { step, kind, operand: ordered.then_some(operand), other_operand };
                let known = reads.entry(value).or_default();
                let first = known.first().map_or(step, |first| first.step);
                if step < first {
                    known.clear();
                }
                if step <= first {
                    known.push(read);
                }
            }
        }
        Self(reads)
    }

    /// The number of units that read a value in the step that reads it first.
    pub fn count(&self, id: NodeId) -> usize {
        self.0.get(&id).map_or(0, Vec::len)
    }

    /// The score of a shared register for two values of different operations: 0 if no unit can read both from one
    /// register without a multiplexer. It rises with the number of such units, and more if their other operands share a
    /// register.
    pub fn score(&self, id: NodeId, slots: &Slots, other: &Self, other_id: NodeId, other_slots: &Slots) -> usize {
        let (Some(ours), Some(theirs)) = (self.0.get(&id), other.0.get(&other_id)) else { return 0 };
        let match_each_other = |a: &UnitRead, b: &UnitRead| {
            (a.step, a.kind) == (b.step, b.kind)
                && (a.operand == b.operand || a.operand.is_none() || b.operand.is_none())
        };
        let others_share = |a: &UnitRead, b: &UnitRead| {
            let (slot, other) = (slots.get(&a.other_operand), other_slots.get(&b.other_operand));
            slot.is_some() && slot == other
        };
        if !ours.iter().any(|a| theirs.iter().any(|b| match_each_other(a, b))) {
            return 0;
        }
        let both = ours.iter().any(|a| theirs.iter().any(|b| match_each_other(a, b) && others_share(a, b)));
        ours.len().min(theirs.len()) + if both { 100 } else { 0 }
    }

    /// How well two values of a folded pipeline share a register: whether the same kind of unit reads both, and
    /// beside the same operand if they are of one operation.
    pub fn similarity(&self, id: NodeId, other: &Self, other_id: NodeId, is_same_operation: bool) -> usize {
        let (Some(ours), Some(theirs)) = (self.0.get(&id), other.0.get(&other_id)) else { return 0 };
        let similar = |a: &UnitRead, b: &UnitRead| {
            let is_same_port = (a.step, a.kind, a.operand) == (b.step, b.kind, b.operand);
            let is_beside_same = is_same_operation && a.other_operand == b.other_operand;
            usize::from(is_same_port) * if is_beside_same { 10 } else { 2 }
        };
        ours.iter().flat_map(|a| theirs.iter().map(move |b| similar(a, b))).max().unwrap_or(0)
    }
}
