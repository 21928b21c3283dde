//! Binding: assigns the values of a step to its units.
//!
//! Operations share the adders, multipliers and comparators of a step. Any unit of the right kind can compute a value,
//! and the operands of adders and multipliers can be exchanged. Both choices are made so that a unit's operand is the
//! same net for as many operations as possible, because different nets need a multiplexer.

use crate::allocate::alike::Alike;
use crate::allocate::layout::{Layout, Origin, RegisterSlot, Slots};
use crate::config::UnitSharing;
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

/// What the binder knows of a step.
pub struct StepValues<'a> {
    pub operations: &'a [OperationGraph<Step>],
    /// The significands of their numbers.
    pub widths: &'a Widths,
    /// The values of each operation.
    pub values: &'a [&'a PositionValues],
    /// The layout of the registers before the step.
    pub before: &'a Layout,
    /// Values that are the same net, for each operation.
    pub alike: &'a [Alike],
    /// Whether operations share units.
    pub sharing: UnitSharing,
}

/// Values of an operation that different units compute: all of a step, or those of a round.
type Round = (usize, Vec<NodeId>);

/// The values of each operation and round.
type ByRound = BTreeMap<(usize, u32), Vec<NodeId>>;

/// Binds the values of all operations in one step. A unit computes one value of an operation in each round.
pub fn bind(step: &StepValues<'_>, round: impl Fn(usize, NodeId) -> u32) -> Vec<Bindings> {
    let operations = step.operations;
    let mut bindings = vec![Bindings::new(); operations.len()];
    let mut kinds: BTreeMap<(UnitKind, u32), ByRound> = BTreeMap::new();
    for (op, (graph, values)) in operations.iter().zip(step.values).enumerate() {
        for &id in &values.made {
            if let Some(kind) = graph.unit_part(id) {
                kinds.entry(kind).or_default().entry((op, round(op, id))).or_default().push(id);
            }
        }
    }
    for ((kind, part), values) in kinds {
        let rounds: Vec<Round> = values.into_iter().map(|((op, _), values)| (op, values)).collect();
        if part > 0 {
            for (op, values) in &rounds {
                bind_next_parts(&operations[*op], values, step.before.slots.get(*op), &mut bindings[*op]);
            }
            continue;
        }
        let sets: Vec<&[Round]> = match step.sharing {
            UnitSharing::Shared => vec![&rounds],
            UnitSharing::Disjoint => rounds.chunk_by(|a, b| a.0 == b.0).collect(),
        };
        let mut number = 0;
        for set in sets {
            for (width, rounds) in by_width(step, set) {
                bind_set(step, Unit { kind, part, width, number }, &rounds, &mut bindings);
            }
            number += set.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
        }
    }
    bindings
}

/// Binds values to units with numbers from that of `first`.
fn bind_set(step: &StepValues<'_>, first: Unit, rounds: &[Round], bindings: &mut [Bindings]) {
    let is_chained = |(op, values): &Round| is_chained(&step.operations[*op], step.values[*op], values);
    if first.kind != UnitKind::Sum && !rounds.iter().any(is_chained) {
        return bind_by_nets(step, first, rounds, bindings);
    }
    // In order, because another choice could make a combinational loop of two operations' chains. Sums too: their terms
    // are in the order that suits the unit of this number ([`align`](super::terms::align)).
    for (op, values) in rounds {
        let in_order = values.iter().enumerate().map(|(index, &id)| {
            let unit = Unit { number: first.number + index, ..first };
            (id, Binding { unit, swapped: !step.widths.fits(first.width, *op, &step.operations[*op], id, false) })
        });
        bindings[*op].extend(in_order);
    }
}

/// The values by the width of the unit that computes each. A value that fits a narrow unit is computed by a full one if
/// another operation or round needs that anyway, as far as there are such units.
fn by_width(step: &StepValues<'_>, rounds: &[Round]) -> BTreeMap<UnitWidth, Vec<Round>> {
    let own = |(op, ids): &Round| -> Vec<UnitWidth> {
        ids.iter().map(|&id| step.widths.of_unit(*op, &step.operations[*op], id)).collect()
    };
    let own: Vec<Vec<UnitWidth>> = rounds.iter().map(own).collect();
    let full = |widths: &Vec<UnitWidth>| widths.iter().filter(|&&width| width == UnitWidth::Full).count();
    let needed = own.iter().map(full).max().unwrap_or(0);
    let mut divided: BTreeMap<UnitWidth, Vec<Round>> = BTreeMap::new();
    for (round, ((_, ids), widths)) in rounds.iter().zip(&own).enumerate() {
        let mut room = needed - full(widths);
        for (&id, &width) in ids.iter().zip(widths) {
            let shares = width != UnitWidth::Full && room > 0;
            room -= usize::from(shares);
            let width = if shares { UnitWidth::Full } else { width };
            let empty = || rounds.iter().map(|(op, _)| (*op, Vec::new())).collect();
            divided.entry(width).or_insert_with(empty)[round].1.push(id);
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

/// A unit for a value. The order is that of preference: the fields decide from the first to the last.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// How many operands of the unit would get a net more, which is an input more of their multiplexers.
    new_nets: usize,
    /// Whether the value's operands are exchanged.
    swapped: bool,
    /// How far the unit's number is from the value's place in its round, so that values keep their order.
    displacement: usize,
    /// The value's place in its round.
    value: usize,
    /// The unit's number in the set.
    unit: usize,
    /// The nets at the operands.
    nets: [(Origin, bool); 2],
}

/// Binds values to the units where they add the fewest nets; the round with the most values is first.
fn bind_by_nets(step: &StepValues<'_>, first: Unit, rounds: &[Round], bindings: &mut [Bindings]) {
    let units = rounds.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let mut nets: Vec<[Nets; 2]> = vec![Default::default(); units];
    let mut order: Vec<&Round> = rounds.iter().collect();
    order.sort_by_key(|(_, values)| std::cmp::Reverse(values.len()));
    for round in order {
        let (op, values) = round;
        let mut free = vec![true; units];
        for Candidate { swapped, value, unit, nets: operands, .. } in candidates(step, first.width, round, &nets) {
            let id = values[value];
            if free[unit] && !bindings[*op].contains_key(&id) {
                free[unit] = false;
                let bound = Unit { number: first.number + unit, ..first };
                bindings[*op].insert(id, Binding { unit: bound, swapped });
                for (net, known) in operands.into_iter().zip(&mut nets[unit]) {
                    known.insert(net);
                }
            }
        }
    }
}

/// All units for all values of a round, the best first. `nets` are those at the units so far.
fn candidates(step: &StepValues<'_>, width: UnitWidth, (op, values): &Round, nets: &[[Nets; 2]]) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for (value, &id) in values.iter().enumerate() {
        for swapped in [false, true] {
            if !step.widths.fits(width, *op, &step.operations[*op], id, swapped) {
                continue;
            }
            let Some(operands) = operands(step, *op, id, swapped) else { continue };
            for (unit, known) in nets.iter().enumerate() {
                let is_new = |(net, known): &(_, &Nets)| !known.is_empty() && !known.contains(*net);
                let new_nets = operands.iter().zip(known).filter(is_new).count();
                let displacement = value.abs_diff(unit);
                candidates.push(Candidate { new_nets, swapped, displacement, value, unit, nets: operands.clone() });
            }
        }
    }
    candidates.sort();
    candidates
}

/// The nets of a value's two operands; `None` if they are to be exchanged and cannot be.
fn operands(step: &StepValues<'_>, op: usize, id: NodeId, swapped: bool) -> Option<[(Origin, bool); 2]> {
    let (a, b, inverts) = match step.operations[op].node(id).op {
        Op::Add(a, b) | Op::Multiply(a, b) if swapped => (b, a, false),
        Op::Add(a, b) | Op::Multiply(a, b) => (a, b, false),
        Op::Subtract(a, b) if !swapped => (a, b, true),
        Op::Compare(a, b) if !swapped => (a, b, false),
        _ => return None,
    };
    let net = |id| match step.before.slot(op, id) {
        Some(slot) => Origin::Register(slot),
        None => Origin::Logic(op, *step.alike.get(op).and_then(|alike| alike.get(&id)).unwrap_or(&id)),
    };
    Some([(net(a), false), (net(b), inverts)])
}
