//! What has to cross each register boundary, and what each step has to make.

use crate::graph::{NodeId, Traced};
use std::collections::BTreeSet;

/// What one operation makes in a step and hands on after it. Step 0 makes nothing: it is the input's registers.
#[derive(Debug, Clone, Default)]
pub struct Work {
    /// Values made in this step, operands before what is made of them.
    pub made: Vec<NodeId>,
    /// Values in the registers after this step.
    pub carried: Vec<NodeId>,
}

/// The work of steps 0 to `last`, by going backwards from the outputs: a value is carried from the step that makes it
/// to the last that reads it, and nowhere else; what nobody reads is not made.
pub fn work(traced: &Traced, last: u32) -> Vec<Work> {
    let mut steps = vec![Work::default(); last as usize + 1];
    let mut wanted: BTreeSet<NodeId> = traced.outputs.iter().map(|output| output.node).collect();
    for step in (1..=last).rev() {
        let work = &mut steps[step as usize];
        work.carried = wanted.iter().copied().collect();
        let nexts = traced.states.iter().filter(|state| state.written == step).map(|state| state.next);
        wanted = needed_before(traced, step, wanted.iter().copied().chain(nexts), &mut work.made);
    }
    steps[0].carried = wanted.into_iter().collect();
    steps
}

/// What must be in the registers before `step` so that it has all of `wanted`; what it makes itself goes to `made`.
fn needed_before(
    traced: &Traced,
    step: u32,
    wanted: impl Iterator<Item = NodeId>,
    made: &mut Vec<NodeId>,
) -> BTreeSet<NodeId> {
    let mut here = BTreeSet::new();
    let mut before = BTreeSet::new();
    let mut floating = BTreeSet::new();
    let mut open: Vec<NodeId> = wanted.collect();
    while let Some(id) = open.pop() {
        if traced.is_everywhere(id) {
            continue;
        }
        if traced.floats(id) {
            // A test of what is made here is made here as well, and one of an input in the first step; whether others
            // are, is decided below.
            let operand = traced.operands(id)[0];
            if traced.node(operand).stage.max(1) == step {
                here.insert(id);
                open.push(operand);
            } else {
                floating.insert(id);
            }
        } else if traced.node(id).stage == step {
            if here.insert(id) {
                open.extend(traced.operands(id));
            }
        } else {
            before.insert(id);
        }
    }
    for id in floating {
        // Where the number itself is at hand its test needs no register; else the test's one bit crosses for it.
        let at_hand = before.contains(&traced.operands(id)[0]);
        if at_hand {
            here.insert(id)
        } else {
            before.insert(id)
        };
    }
    made.extend(here);
    before
}
