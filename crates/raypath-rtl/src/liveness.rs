//! What has to cross each register boundary, and what each stage has to make.

use crate::STAGES;
use crate::graph::{NodeId, Traced};
use std::collections::BTreeSet;

/// What one operation makes in a stage and hands on after it. Stage 0 makes nothing: it is the input's registers.
#[derive(Debug, Clone, Default)]
pub struct Work {
    /// Values made in this stage, operands before what is made of them.
    pub made: Vec<NodeId>,
    /// Values in the registers after this stage.
    pub carried: Vec<NodeId>,
}

/// The work of stages 0 to [`STAGES`], by going backwards from the outputs: a value is carried from the stage that makes
/// it to the last that reads it, and nowhere else; what nobody reads is not made.
pub fn work(traced: &Traced) -> Vec<Work> {
    let mut stages = vec![Work::default(); STAGES as usize + 1];
    let mut wanted: BTreeSet<NodeId> = traced.outputs.iter().map(|output| output.node).collect();
    for stage in (1..=STAGES).rev() {
        let work = &mut stages[stage as usize];
        work.carried = wanted.iter().copied().collect();
        let nexts = traced.states.iter().filter(|state| state.stage == stage).map(|state| state.next);
        wanted = needed_before(traced, stage, wanted.iter().copied().chain(nexts), &mut work.made);
    }
    stages[0].carried = wanted.into_iter().collect();
    stages
}

/// What must be in the registers before `stage` so that it has all of `wanted`; what it makes itself goes to `made`.
fn needed_before(
    traced: &Traced,
    stage: u32,
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
            // A test of what is made here is made here as well; whether others are, is decided below.
            let operand = traced.operands(id)[0];
            if traced.node(operand).stage == stage {
                here.insert(id);
                open.push(operand);
            } else {
                floating.insert(id);
            }
        } else if traced.node(id).stage == stage {
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
