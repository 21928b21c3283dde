//! Liveness: the values that each position computes, and those that cross each register boundary.

use crate::ir::graph::{NodeId, OperationGraph};
use crate::ir::position::Position;
use std::collections::BTreeSet;

/// The values of one operation at a position. Position 0, the input's registers, computes nothing.
#[derive(Debug, Clone, Default)]
pub struct PositionValues {
    /// Values computed here, operands first.
    pub made: Vec<NodeId>,
    /// Live values in the registers after this position.
    pub carried: Vec<NodeId>,
}

/// The values of positions 0 to `last`, by a backward pass from the outputs. A value is carried from the position that
/// computes it to the last that reads it. Dead values are not computed.
pub fn analyse<P: Position>(graph: &OperationGraph<P>, last: u32) -> Vec<PositionValues> {
    let mut positions = vec![PositionValues::default(); last as usize + 1];
    let mut live: BTreeSet<NodeId> = graph.outputs.iter().map(|output| output.node).collect();
    for number in (1..=last).rev() {
        let position = P::at(number);
        let values = &mut positions[number as usize];
        values.carried = live.iter().copied().collect();
        let nexts = graph.states.iter().filter(|state| state.written == position).map(|state| state.next);
        live = live_before(graph, position, live.iter().copied().chain(nexts), &mut values.made);
    }
    positions[0].carried = live.into_iter().collect();
    positions
}

/// The values that must be in the registers before `position` so that all of `needed` are available after it. Adds the
/// values that `position` computes to `made`.
fn live_before<P: Position>(
    graph: &OperationGraph<P>,
    position: P,
    needed: impl Iterator<Item = NodeId>,
    made: &mut Vec<NodeId>,
) -> BTreeSet<NodeId> {
    let mut here = BTreeSet::new();
    let mut before = BTreeSet::new();
    let mut movable = BTreeSet::new();
    let mut open: Vec<NodeId> = needed.collect();
    while let Some(id) = open.pop() {
        if graph.is_everywhere(id) {
            continue;
        }
        if graph.is_movable(id) {
            // A test is computed with its operand, and a test of an input in the first position. The other tests are
            // placed below.
            let operand = graph.operands(id)[0];
            if graph.node(operand).position.max(P::at(1)) == position {
                here.insert(id);
                open.push(operand);
            } else {
                movable.insert(id);
            }
        } else if graph.node(id).position == position {
            if here.insert(id) {
                open.extend(graph.operands(id));
            }
        } else {
            before.insert(id);
        }
    }
    for id in movable {
        // If the number itself is in the registers, its test needs no register. If not, the test's bit crosses instead.
        if before.contains(&graph.operands(id)[0]) {
            here.insert(id);
        } else {
            before.insert(id);
        }
    }
    made.extend(here);
    before
}
