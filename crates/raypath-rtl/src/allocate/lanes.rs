//! Register allocation at one boundary of a folded pipeline. A register holds a value for the positions of its life
//! only, so the values of several rounds share it, and those of several operations. A value inside a unit has the
//! registers of that unit.

use crate::allocate::affinity::Affinity;
use crate::allocate::layout::{FLAG_REGISTER, Layout, Origin, RegisterSlot, Slots};
use crate::config::Sharing;
use crate::fold::{Life, Rounds};
use crate::ir::graph::{Kind, NodeId, OperationGraph};
use crate::ir::position::Step;
use std::cmp::Reverse;

/// A register, or some bits of one.
struct Lane {
    slot: RegisterSlot,
    /// From the first life to the last; shorter than the interval, so that two jobs never need it at once.
    hull: Life,
    values: Vec<Value>,
}

#[derive(Clone)]
struct Value {
    op: usize,
    id: NodeId,
    life: Life,
    origin: Origin,
}

/// Allocates the registers after `step` to the values that each operation carries over it.
pub fn allocate(
    sharing: Sharing,
    operations: &[OperationGraph<Step>],
    rounds: &Rounds,
    step: usize,
    affinities: &[Affinity],
    origin: impl Fn(usize, NodeId) -> Origin,
) -> Layout {
    let mut layout = Layout { slots: vec![Slots::new(); operations.len()], ..Layout::default() };
    let mut lanes: Vec<Lane> = Vec::new();
    // The operation with the greatest need is first, because it has the least choice.
    let mut order: Vec<usize> = (0..operations.len()).collect();
    order.sort_by_key(|&op| Reverse(rounds.lives[op][step].len()));
    for op in order {
        let mut values: Vec<(NodeId, Life)> = rounds.lives[op][step].iter().map(|(&id, &life)| (id, life)).collect();
        values.sort_by_key(|&(id, life)| (life.first, id));
        for (id, life) in values {
            let kind = operations[op].node(id).kind;
            let value = Value { op, id, life, origin: origin(op, id) };
            if let (Kind::Cut(..), Origin::Unit(unit)) = (kind, &value.origin) {
                layout.cuts.insert(*unit);
                layout.slots[op].insert(id, RegisterSlot::Cut(*unit));
                continue;
            }
            let scores = lanes.iter().enumerate().filter(|(_, lane)| lane.has_room(&value, kind, sharing, rounds));
            let scores = scores.map(|(number, lane)| (lane.score(&value, affinities), Reverse(number)));
            let number = match scores.max() {
                Some((_, Reverse(number))) => number,
                None => {
                    let slot = new_slot(&mut layout, kind);
                    lanes.push(Lane { slot, hull: life, values: Vec::new() });
                    lanes.len() - 1
                }
            };
            let lane = &mut lanes[number];
            lane.hull = lane.hull.hull(life);
            lane.values.push(value);
            layout.slots[op].insert(id, lane.slot);
        }
    }
    layout
}

fn new_slot(layout: &mut Layout, kind: Kind) -> RegisterSlot {
    let Kind::Word(width) = kind else {
        layout.numbers += 1;
        return RegisterSlot::Number(layout.numbers - 1);
    };
    let mut low = layout.flags;
    if low / FLAG_REGISTER != (low + width - 1) / FLAG_REGISTER {
        low = low.next_multiple_of(FLAG_REGISTER);
    }
    layout.flags = low + width;
    RegisterSlot::Flags { low, width }
}

impl Lane {
    fn has_room(&self, value: &Value, kind: Kind, sharing: Sharing, rounds: &Rounds) -> bool {
        let is_same_kind = match (self.slot, kind) {
            (RegisterSlot::Flags { width: own, .. }, Kind::Word(width)) => own == width,
            (RegisterSlot::Number(_), Kind::Number | Kind::Order) => true,
            _ => false,
        };
        let is_free = |other: &Value| match other.op == value.op {
            true => !other.life.overlaps(value.life),
            false => sharing == Sharing::Union,
        };
        is_same_kind && self.hull.hull(value.life).length() <= rounds.interval && self.values.iter().all(is_free)
    }

    /// How many multiplexers a value in this register saves: those before the register, and those of its readers.
    fn score(&self, value: &Value, affinities: &[Affinity]) -> usize {
        let comes_alike = self.values.iter().any(|other| other.origin == value.origin);
        let stays_alike = self.values.iter().any(|other| (other.life.length() == 1) == (value.life.length() == 1));
        let similar = self.values.iter().map(|other| {
            affinities[value.op].similarity(value.id, &affinities[other.op], other.id, other.op == value.op)
        });
        similar.max().unwrap_or(0) + if comes_alike { 20 } else { 0 } + usize::from(stays_alike)
    }
}
