//! Values that wait in memories: runs of registers that only pass a value on.
//!
//! In a pipeline that never stalls, a number that passes several boundaries in the same register, while no operation
//! does anything else with that register, needs no registers there: a memory keeps it as many cycles.

use super::layout::RegisterSlot;
use super::plan::Plan;
use std::collections::BTreeMap;

/// What is at a boundary in place of a number register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delay {
    /// A memory that shows the number after this number of cycles, at the boundary that ends the run.
    Memory(u32),
    /// Wires: the memory of an earlier boundary shows the number, or a register inside a unit has it.
    Wires,
}

/// For each boundary the number registers that it does not have. Runs are of `least` boundaries or more; 0 means that
/// there are none.
pub fn delays(plan: &Plan, least: u32) -> Vec<BTreeMap<usize, Delay>> {
    let mut delays = vec![BTreeMap::new(); plan.steps.len()];
    if least == 0 {
        return delays;
    }
    let most = plan.steps.iter().map(|step| step.layout.numbers).max().unwrap_or(0);
    for place in 0..most {
        let mut first = 0;
        while first < plan.last() {
            let mut end = first + 1;
            while end < plan.last() && passes(plan, end, place) {
                end += 1;
            }
            let length = (end - first) as u32;
            let is_there = place < plan.steps[first].layout.numbers;
            if is_there && length >= least {
                delays[first].insert(place, Delay::Memory(length));
                delays[first + 1..end].iter_mut().for_each(|delays| {
                    delays.insert(place, Delay::Wires);
                });
            }
            first = end;
        }
    }
    delays
}

/// Whether all that a step does with a number register is to pass it on, in the same encoding.
fn passes(plan: &Plan, step: usize, place: usize) -> bool {
    let (before, after) = (&plan.steps[step - 1].layout, &plan.steps[step].layout);
    let slot = RegisterSlot::Number(place);
    let here = |slots: &super::layout::Slots| slots.values().any(|own| *own == slot);
    plan.encoding(step - 1) == plan.encoding(step)
        && after.slots.iter().any(here)
        && plan.operations.iter().enumerate().all(|(op, graph)| {
            let is_from = |id| before.slot(op, id) == Some(slot);
            let is_read = plan.steps[step].made[op].iter().any(|&id| graph.operands(id).into_iter().any(is_from));
            let mut kept = after.slots[op].iter().filter(|(_, own)| **own == slot);
            !is_read && kept.all(|(id, _)| is_from(*id))
        })
}
