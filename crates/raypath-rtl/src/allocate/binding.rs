//! Binding: assigns the values of a step to its units.
//!
//! Operations share the adders, multipliers and comparators of a step. Any unit of the right kind can compute a value,
//! and the operands of adders and multipliers can be exchanged. Both choices are made so that a unit's operand is the
//! same net for as many operations as possible, because different nets need a multiplexer.

use crate::allocate::layout::{Layout, Origin, RegisterSlot, Slots};
use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::liveness::PositionValues;
use crate::ir::position::Step;
use crate::ir::units::{Unit, UnitKind, UnitWidth};
use crate::ir::widths::Widths;
use std::collections::{BTreeMap, BTreeSet};

/// The unit that computes a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    pub unit: Unit,
    /// Whether the two operands are exchanged.
    pub swapped: bool,
}

/// The units of one operation's values in a step.
pub type Bindings = BTreeMap<NodeId, Binding>;

/// Binds the values of all operations in one step. `before` is the layout of the registers before the step.
pub fn bind(
    operations: &[OperationGraph<Step>],
    widths: &Widths,
    steps: &[&PositionValues],
    before: &Layout,
) -> Vec<Bindings> {
    let mut bindings = vec![Bindings::new(); operations.len()];
    let mut kinds: BTreeMap<(UnitKind, u32), Vec<Vec<NodeId>>> = BTreeMap::new();
    for (op, (graph, step)) in operations.iter().zip(steps).enumerate() {
        for &id in &step.made {
            if let Some(kind) = graph.unit_part(id) {
                kinds.entry(kind).or_insert_with(|| vec![Vec::new(); operations.len()])[op].push(id);
            }
        }
    }
    for ((kind, part), values) in kinds {
        if part > 0 {
            for (op, values) in values.iter().enumerate() {
                bind_next_parts(&operations[op], values, before.slots.get(op), &mut bindings[op]);
            }
            continue;
        }
        for (width, values) in by_width(operations, widths, values) {
            let first = Unit { kind, part, width, number: 0 };
            if values.iter().enumerate().any(|(op, values)| is_chained(&operations[op], steps[op], values)) {
                // In order, because another choice could make a combinational loop of two operations' chains.
                for (op, values) in values.iter().enumerate() {
                    let in_order = values
                        .iter()
                        .enumerate()
                        .map(|(number, &id)| (id, Binding { unit: Unit { number, ..first }, swapped: false }));
                    bindings[op].extend(in_order);
                }
            } else {
                bind_by_nets(operations, first, &values, before, &mut bindings);
            }
        }
    }
    bindings
}

/// The values by the width of the unit that computes each. A value that fits a narrow unit is computed by a full one if
/// another operation needs that anyway, as far as there are such units.
fn by_width(
    operations: &[OperationGraph<Step>],
    widths: &Widths,
    values: Vec<Vec<NodeId>>,
) -> BTreeMap<UnitWidth, Vec<Vec<NodeId>>> {
    let own = |op: usize, ids: &[NodeId]| -> Vec<UnitWidth> {
        ids.iter().map(|&id| widths.of_unit(op, &operations[op], id)).collect()
    };
    let own: Vec<Vec<UnitWidth>> = values.iter().enumerate().map(|(op, ids)| own(op, ids)).collect();
    let full = |widths: &Vec<UnitWidth>| widths.iter().filter(|&&width| width == UnitWidth::Full).count();
    let needed = own.iter().map(full).max().unwrap_or(0);
    let mut divided = BTreeMap::new();
    for (op, (ids, widths)) in values.iter().zip(&own).enumerate() {
        let mut room = needed - full(widths);
        for (&id, &width) in ids.iter().zip(widths) {
            let shares = width != UnitWidth::Full && room > 0;
            room -= usize::from(shares);
            let width = if shares { UnitWidth::Full } else { width };
            divided.entry(width).or_insert_with(|| vec![Vec::new(); values.len()])[op].push(id);
        }
    }
    divided
}

/// Binds values to the next parts of units: the part with the same number as the part before.
fn bind_next_parts(graph: &OperationGraph<Step>, values: &[NodeId], before: Option<&Slots>, bindings: &mut Bindings) {
    for &id in values {
        let slot = graph.operands(id).first().and_then(|begun| before?.get(begun));
        if let Some(&RegisterSlot::Cut(unit)) = slot {
            bindings.insert(id, Binding { unit: Unit { part: unit.part + 1, ..unit }, swapped: false });
        }
    }
}

/// Whether any of these values depends on another unit of the same step.
fn is_chained(graph: &OperationGraph<Step>, step: &PositionValues, values: &[NodeId]) -> bool {
    let made: BTreeSet<NodeId> = step.made.iter().copied().collect();
    let mut open: Vec<NodeId> = values.iter().flat_map(|&id| graph.operands(id)).collect();
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if made.contains(&id) && seen.insert(id) {
            if graph.unit_part(id).is_some() {
                return true;
            }
            open.extend(graph.operands(id));
        }
    }
    false
}

/// The nets at a unit's operand for the operations bound so far, and whether their signs are inverted.
type Nets = BTreeSet<(Origin, bool)>;

/// Binds values to the units where they add the fewest nets; the operation with the most values is first.
fn bind_by_nets(
    operations: &[OperationGraph<Step>],
    first: Unit,
    values: &[Vec<NodeId>],
    before: &Layout,
    bindings: &mut [Bindings],
) {
    let units = values.iter().map(Vec::len).max().unwrap_or(0);
    let mut nets: Vec<[Nets; 2]> = vec![Default::default(); units];
    let mut order: Vec<usize> = (0..operations.len()).collect();
    order.sort_by_key(|&op| std::cmp::Reverse(values[op].len()));
    for op in order {
        let graph = &operations[op];
        let mut candidates = Vec::new();
        for (index, &id) in values[op].iter().enumerate() {
            for swapped in [false, true] {
                let Some(operands) = operands(graph, op, id, swapped, before) else { continue };
                for (number, nets) in nets.iter().enumerate() {
                    let new =
                        operands.iter().zip(nets).filter(|(net, known)| !known.is_empty() && !known.contains(net));
                    candidates.push((new.count(), swapped, index.abs_diff(number), index, number, operands.clone()));
                }
            }
        }
        candidates.sort();
        let mut free = vec![true; units];
        for (_, swapped, _, index, number, operands) in candidates {
            let id = values[op][index];
            if free[number] && !bindings[op].contains_key(&id) {
                free[number] = false;
                bindings[op].insert(id, Binding { unit: Unit { number, ..first }, swapped });
                for (net, known) in operands.into_iter().zip(&mut nets[number]) {
                    known.insert(net);
                }
            }
        }
    }
}

/// The nets of a value's two operands; `None` if they are to be exchanged and cannot be.
fn operands(
    graph: &OperationGraph<Step>,
    op: usize,
    id: NodeId,
    swapped: bool,
    before: &Layout,
) -> Option<[(Origin, bool); 2]> {
    let (a, b, inverts) = match graph.node(id).op {
        Op::Add(a, b) | Op::Multiply(a, b) if swapped => (b, a, false),
        Op::Add(a, b) | Op::Multiply(a, b) => (a, b, false),
        Op::Subtract(a, b) if !swapped => (a, b, true),
        Op::Compare(a, b) if !swapped => (a, b, false),
        _ => return None,
    };
    let net = |id| match before.slot(op, id) {
        Some(slot) => Origin::Register(slot),
        None => Origin::Logic(op, id),
    };
    Some([(net(a), false), (net(b), inverts)])
}
