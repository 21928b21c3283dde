//! What will be done with a value: where it should live so that units find it where other operations have theirs.

use crate::graph::{NodeId, Op, Traced};
use crate::place::Place;
use crate::units::{UnitKind, part};
use std::collections::BTreeMap;

/// For every value of an operation, the units that read it first.
#[derive(Debug)]
pub struct Demands(BTreeMap<NodeId, Vec<Demand>>);

/// A unit that reads a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Demand {
    step: u32,
    kind: UnitKind,
    /// At which operand, where the two may not change places.
    operand: Option<usize>,
    /// The unit's other operand.
    companion: NodeId,
}

impl Demands {
    pub fn new(traced: &Traced) -> Self {
        let mut demands: BTreeMap<NodeId, Vec<Demand>> = BTreeMap::new();
        for id in traced.ids() {
            let operands = traced.operands(id);
            let (Some((kind, 0)), &[a, b]) = (part(traced, id), operands.as_slice()) else { continue };
            let ordered = matches!(traced.node(id).op, Op::Subtract(..) | Op::Compare(..));
            for (operand, value, companion) in [(0, a, b), (1, b, a)] {
                let step = traced.node(id).stage;
                let demand = Demand { step, kind, operand: ordered.then_some(operand), companion };
                let known = demands.entry(value).or_default();
                let first = known.first().map_or(step, |first| first.step);
                if step < first {
                    known.clear();
                }
                if step <= first {
                    known.push(demand);
                }
            }
        }
        Self(demands)
    }

    /// How many units read a value in the step that reads it first.
    pub fn count(&self, id: NodeId) -> usize {
        self.0.get(&id).map_or(0, Vec::len)
    }

    /// How well two values of different operations would share a register: 0 where no unit reads both alike, more where
    /// their companions share one too, and the more units the better.
    pub fn match_of(
        &self,
        id: NodeId,
        places: &BTreeMap<NodeId, Place>,
        other: &Self,
        other_id: NodeId,
        other_places: &BTreeMap<NodeId, Place>,
    ) -> usize {
        let (Some(ours), Some(theirs)) = (self.0.get(&id), other.0.get(&other_id)) else { return 0 };
        let alike = |a: &Demand, b: &Demand| {
            (a.step, a.kind) == (b.step, b.kind)
                && (a.operand == b.operand || a.operand.is_none() || b.operand.is_none())
        };
        let together = |a: &Demand, b: &Demand| {
            let (place, other) = (places.get(&a.companion), other_places.get(&b.companion));
            place.is_some() && place == other
        };
        if !ours.iter().any(|a| theirs.iter().any(|b| alike(a, b))) {
            return 0;
        }
        let both = ours.iter().any(|a| theirs.iter().any(|b| alike(a, b) && together(a, b)));
        ours.len().min(theirs.len()) + if both { 100 } else { 0 }
    }
}
