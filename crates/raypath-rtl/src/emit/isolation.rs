//! Operand isolation, with clock gates: the operands of a unit are zeros in jobs that do not use the unit but load the
//! registers that it reads. So the unit does not switch in such jobs.
//!
//! Comparators and conversions are not isolated, because they take less energy than the gates in front of them.

use crate::allocate::layout::{FLAG_REGISTER, RegisterSlot};
use crate::allocate::plan::Plan;
use crate::ir::graph::NodeId;
use crate::ir::units::{Unit, UnitKind};
use std::collections::BTreeSet;

/// The operations that use a unit, if jobs of others change its operands, so that it needs isolation.
pub fn users_to_isolate(plan: &Plan, step: usize, unit: Unit) -> Option<Vec<usize>> {
    let is_large = matches!(unit.kind, UnitKind::Add | UnitKind::Sum | UnitKind::Multiply);
    // The registers before the later parts of a unit have no other readers, and load for its users only.
    if !plan.microarchitecture.clock_gating || !is_large || unit.part > 0 {
        return None;
    }
    let own = plan.users(step, unit);
    let users: BTreeSet<usize> = own.iter().map(|&(op, _)| op).collect();
    let mut others = (0..plan.operations.len()).filter(|op| !users.contains(op));
    let (slots, units) = sources(plan, step, own);
    let before = step.checked_sub(1).map(|before| &plan.steps[before].layout)?;
    let is_disturbed = |op: usize| {
        let loads = before.slots[op].values().any(|slot| slots.iter().any(|read| is_same_register(*read, *slot)));
        loads || units.iter().any(|&unit| plan.users(step, unit).iter().any(|&(user, _)| user == op))
    };
    others.any(is_disturbed).then(|| users.iter().copied().collect())
}

/// The registers and the units of the step on which these values depend.
fn sources(plan: &Plan, step: usize, of: Vec<(usize, NodeId)>) -> (BTreeSet<RegisterSlot>, BTreeSet<Unit>) {
    let operands = |(op, id): (usize, NodeId)| plan.operations[op].operands(id).into_iter().map(move |id| (op, id));
    let (mut slots, mut units, mut seen) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut open: Vec<(usize, NodeId)> = of.into_iter().flat_map(operands).collect();
    while let Some((op, id)) = open.pop() {
        if !seen.insert((op, id)) {
            continue;
        }
        if let Some(slot) = step.checked_sub(1).and_then(|before| plan.steps[before].layout.slot(op, id)) {
            slots.insert(slot);
            continue;
        }
        if let Some(binding) = plan.steps[step].bindings[op].get(&id)
            && units.insert(binding.unit)
        {
            open.extend(plan.users(step, binding.unit).into_iter().flat_map(operands));
        }
        open.extend(operands((op, id)));
    }
    (slots, units)
}

/// Whether two slots are in registers that load together.
fn is_same_register(a: RegisterSlot, b: RegisterSlot) -> bool {
    match (a, b) {
        (RegisterSlot::Flags { low: a, .. }, RegisterSlot::Flags { low: b, .. }) => {
            a / FLAG_REGISTER == b / FLAG_REGISTER
        }
        _ => a == b,
    }
}
