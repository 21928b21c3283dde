//! Which unit of a step does what.
//!
//! Operations share units: the values that each makes in a step are spread over the same adders, multipliers and
//! comparators. Which of them makes which value is free, and so is the order of an adder's or a multiplier's operands.
//! Both are chosen so that a unit's operand is the same net for as many operations as possible, because a multiplexer
//! stands wherever it is not.

use crate::graph::{NodeId, Op, Traced};
use crate::liveness::Work;
use crate::place::{Layout, Origin, Place};
use crate::units::{Unit, UnitKind, part};
use std::collections::{BTreeMap, BTreeSet};

/// Where an operation's value is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    pub unit: Unit,
    /// The unit's first operand is the value's second, and the other way round.
    pub swapped: bool,
}

/// The units of one operation's values in a step.
pub type Bindings = BTreeMap<NodeId, Binding>;

/// Binds what all operations make in one step, whose registers before are `before`.
pub fn bind(operations: &[Traced], works: &[&Work], before: &Layout) -> Vec<Bindings> {
    let mut bindings = vec![Bindings::new(); operations.len()];
    let mut kinds: BTreeMap<(UnitKind, u32), Vec<Vec<NodeId>>> = BTreeMap::new();
    for (op, (traced, work)) in operations.iter().zip(works).enumerate() {
        for &id in &work.made {
            if let Some(kind) = part(traced, id) {
                kinds.entry(kind).or_insert_with(|| vec![Vec::new(); operations.len()])[op].push(id);
            }
        }
    }
    for ((kind, part), values) in kinds {
        if part > 0 {
            for (op, values) in values.iter().enumerate() {
                continued(&operations[op], values, before.places.get(op), &mut bindings[op]);
            }
        } else if values.iter().enumerate().any(|(op, values)| chained(&operations[op], works[op], values)) {
            // Another choice could make two operations' chains a circle.
            for (op, values) in values.iter().enumerate() {
                let in_order = values
                    .iter()
                    .enumerate()
                    .map(|(number, &id)| (id, Binding { unit: Unit { kind, part, number }, swapped: false }));
                bindings[op].extend(in_order);
            }
        } else {
            matched(operations, kind, &values, before, &mut bindings);
        }
    }
    bindings
}

/// A unit's next part is the one of the same number.
fn continued(traced: &Traced, values: &[NodeId], before: Option<&BTreeMap<NodeId, Place>>, bindings: &mut Bindings) {
    for &id in values {
        let place = traced.operands(id).first().and_then(|begun| before?.get(begun));
        if let Some(&Place::Cut(unit)) = place {
            bindings.insert(id, Binding { unit: Unit { part: unit.part + 1, ..unit }, swapped: false });
        }
    }
}

/// Whether any of these values is made of what another unit makes in the same step.
fn chained(traced: &Traced, work: &Work, values: &[NodeId]) -> bool {
    let made: BTreeSet<NodeId> = work.made.iter().copied().collect();
    let mut open: Vec<NodeId> = values.iter().flat_map(|&id| traced.operands(id)).collect();
    let mut seen = BTreeSet::new();
    while let Some(id) = open.pop() {
        if made.contains(&id) && seen.insert(id) {
            if part(traced, id).is_some() {
                return true;
            }
            open.extend(traced.operands(id));
        }
    }
    false
}

/// What stands at a unit's operand for the operations bound so far: nets, and whether their signs are inverted.
type Nets = BTreeSet<(Origin, bool)>;

/// The operation with the most values first; each value then goes where it adds the fewest nets.
fn matched(operations: &[Traced], kind: UnitKind, values: &[Vec<NodeId>], before: &Layout, bindings: &mut [Bindings]) {
    let units = values.iter().map(Vec::len).max().unwrap_or(0);
    let mut nets: Vec<[Nets; 2]> = vec![Default::default(); units];
    let mut order: Vec<usize> = (0..operations.len()).collect();
    order.sort_by_key(|&op| std::cmp::Reverse(values[op].len()));
    for op in order {
        let traced = &operations[op];
        let mut offers = Vec::new();
        for (place, &id) in values[op].iter().enumerate() {
            for swapped in [false, true] {
                let Some(operands) = operands(traced, op, id, swapped, before) else { continue };
                for (number, nets) in nets.iter().enumerate() {
                    let new =
                        operands.iter().zip(nets).filter(|(net, known)| !known.is_empty() && !known.contains(net));
                    offers.push((new.count(), swapped, place.abs_diff(number), place, number, operands.clone()));
                }
            }
        }
        offers.sort();
        let mut free = vec![true; units];
        for (_, swapped, _, place, number, operands) in offers {
            let id = values[op][place];
            if free[number] && !bindings[op].contains_key(&id) {
                free[number] = false;
                bindings[op].insert(id, Binding { unit: Unit { kind, part: 0, number }, swapped });
                for (net, known) in operands.into_iter().zip(&mut nets[number]) {
                    known.insert(net);
                }
            }
        }
    }
}

/// The nets of a value's two operands; none where they may not change places.
fn operands(traced: &Traced, op: usize, id: NodeId, swapped: bool, before: &Layout) -> Option<[(Origin, bool); 2]> {
    let (a, b, inverts) = match traced.node(id).op {
        Op::Add(a, b) | Op::Multiply(a, b) if swapped => (b, a, false),
        Op::Add(a, b) | Op::Multiply(a, b) => (a, b, false),
        Op::Subtract(a, b) if !swapped => (a, b, true),
        Op::Compare(a, b) if !swapped => (a, b, false),
        _ => return None,
    };
    let net = |id| match before.places.get(op).and_then(|places| places.get(&id)) {
        Some(&place) => Origin::Place(place),
        None => Origin::Logic(op, id),
    };
    Some([(net(a), false), (net(b), inverts)])
}
