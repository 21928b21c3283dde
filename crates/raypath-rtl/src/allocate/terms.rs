//! The order of the terms of sums, which does not matter for the result: operations that share an adder of several
//! terms take the same operand for the same register, so that it needs no multiplexer.

use crate::allocate::layout::{Layout, RegisterSlot};
use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::liveness::PositionValues;
use crate::ir::position::Step;
use std::collections::{BTreeMap, BTreeSet};

/// Reorders the terms of the sums that begin in a step. The sums of an operation use adders in their order. `before`
/// are the registers before the step.
pub fn align(operations: &mut [OperationGraph<Step>], here: &[&PositionValues], before: &Layout) {
    // The registers at each operand of an adder, by the number of terms and the number of the adder.
    let mut known: BTreeMap<(usize, usize), Vec<BTreeSet<RegisterSlot>>> = BTreeMap::new();
    for (op, (graph, values)) in operations.iter_mut().zip(here).enumerate() {
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        for &id in &values.made {
            let Op::Sum(terms) = &graph.node(id).op else { continue };
            let number = numbers.entry(terms.len()).or_insert(0);
            let places = known.entry((terms.len(), *number)).or_insert_with(|| vec![BTreeSet::new(); terms.len()]);
            *number += 1;
            let slots: Vec<_> = terms.iter().map(|&term| before.slot(op, term)).collect();
            let order = order(&slots, places);
            let aligned: Vec<NodeId> = order.iter().map(|&term| terms[term]).collect();
            for (place, &term) in places.iter_mut().zip(&order) {
                place.extend(slots[term]);
            }
            graph.nodes[id.index()].op = Op::Sum(aligned);
        }
    }
}

/// The term for each operand: one whose register is known there, or else the first that is left.
fn order(slots: &[Option<RegisterSlot>], places: &[BTreeSet<RegisterSlot>]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..slots.len()).collect();
    let mut take = |is_wanted: &dyn Fn(usize) -> bool| {
        let found = left.iter().position(|&term| is_wanted(term))?;
        Some(left.remove(found))
    };
    let known: Vec<Option<usize>> =
        places.iter().map(|place| take(&|term| slots[term].is_some_and(|slot| place.contains(&slot)))).collect();
    known.into_iter().map(|term| term.or_else(|| take(&|_| true)).unwrap_or_default()).collect()
}
