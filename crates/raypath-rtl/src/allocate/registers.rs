//! Register allocation at one boundary. A boundary holds one job at a time, and the job's opcode determines the meaning
//! of the registers. So operations share registers, unless the configuration separates them.

use crate::allocate::affinity::Affinity;
use crate::allocate::layout::{FLAG_REGISTER, Layout, Origin, RegisterSlot, Slots};
use crate::config::Sharing;
use crate::ir::graph::{Kind, NodeId, OperationGraph};
use crate::ir::position::Step;
use std::collections::{BTreeMap, BTreeSet};

/// Allocates the registers of a boundary to the values that each operation carries over it. The number of shared
/// registers is that of the operation with the greatest need. A value that passes through keeps its slot. A new value
/// gets a slot in which another operation has the same net, which saves a multiplexer.
pub fn allocate(
    sharing: Sharing,
    operations: &[OperationGraph<Step>],
    carried: &[Vec<NodeId>],
    affinities: &[Affinity],
    before: &Layout,
    origin: impl Fn(usize, NodeId) -> Origin,
) -> Layout {
    let values: Vec<LiveValues> =
        operations.iter().zip(carried).map(|(graph, ids)| LiveValues::new(graph, ids)).collect();
    let mut layout = Layout { slots: vec![Slots::new(); operations.len()], ..Layout::default() };
    // The operation with the greatest need is first, because it has the least choice.
    let mut order: Vec<usize> = (0..operations.len()).collect();
    order.sort_by_key(|&op| std::cmp::Reverse((values[op].numbers.len(), values[op].flag_bits())));
    let mut registers: BTreeMap<Origin, usize> = BTreeMap::new();
    let max_numbers = values.iter().map(|values| values.numbers.len()).max().unwrap_or(0);
    let max_flags = values.iter().map(LiveValues::flag_bits).max().unwrap_or(0);
    for op in order {
        let old = |id: NodeId| before.slot(op, id);
        let (numbers, flags) = match sharing {
            Sharing::Union => (0..max_numbers, 0..max_flags),
            Sharing::Segregated => {
                registers.clear();
                let own_numbers = layout.numbers..layout.numbers + values[op].numbers.len();
                (own_numbers, layout.flags..end(&pack(&values[op].flags, layout.flags), layout.flags))
            }
        };
        let mut allocator = RegisterAllocator::new(numbers.clone());
        let shares = sharing == Sharing::Union;
        let score = |id: NodeId, register: usize, slots: &Slots| {
            let others = layout.slots.iter().enumerate().filter(|_| shares);
            let there = others.flat_map(|(other, theirs)| {
                let found = theirs.iter().filter(|(_, slot)| **slot == RegisterSlot::Number(register));
                found.map(move |(&id, _)| (other, id, theirs))
            });
            there.map(|(other, o, theirs)| affinities[op].score(id, slots, &affinities[other], o, theirs)).sum()
        };
        let mut ids = values[op].numbers.clone();
        ids.sort_by_key(|&id| std::cmp::Reverse(affinities[op].count(id)));
        allocator.allocate(&ids, old, |id| origin(op, id), score, &mut registers);
        let flag_slots = allocate_flags(&values[op].flags, flags.clone(), old);
        layout.numbers = layout.numbers.max(numbers.end);
        layout.flags = layout.flags.max(end(&flag_slots, 0));
        layout.slots[op] = allocator.slots;
        layout.slots[op].extend(flag_slots);
        for &id in &values[op].cuts {
            if let Origin::Unit(unit) = origin(op, id) {
                layout.slots[op].insert(id, RegisterSlot::Cut(unit));
                layout.cuts.insert(unit);
            }
        }
    }
    layout
}

/// The values that one operation carries over a boundary.
struct LiveValues {
    numbers: Vec<NodeId>,
    /// Words and their widths.
    flags: Vec<(NodeId, u32)>,
    /// Intermediate results inside units.
    cuts: Vec<NodeId>,
}

impl LiveValues {
    fn new(graph: &OperationGraph<Step>, ids: &[NodeId]) -> Self {
        let mut values = Self { numbers: Vec::new(), flags: Vec::new(), cuts: Vec::new() };
        for &id in ids {
            match graph.node(id).kind {
                Kind::Word(width) => values.flags.push((id, width)),
                Kind::Cut(..) => values.cuts.push(id),
                Kind::Number | Kind::Order => values.numbers.push(id),
            }
        }
        values
    }

    fn flag_bits(&self) -> u32 {
        end(&pack(&self.flags, 0), 0)
    }
}

/// The allocation of number registers to the values of one operation.
struct RegisterAllocator {
    free: BTreeSet<usize>,
    slots: Slots,
}

impl RegisterAllocator {
    fn new(registers: std::ops::Range<usize>) -> Self {
        Self { free: registers.collect(), slots: Slots::new() }
    }

    /// Allocates a register to a value if the register is free and the value has none.
    fn take(&mut self, id: NodeId, register: usize) {
        if !self.slots.contains_key(&id) && self.free.remove(&register) {
            self.slots.insert(id, RegisterSlot::Number(register));
        }
    }

    /// Allocates registers to values: first the register that a value has already, then the register where another
    /// operation has the same net, then the free register with the greatest score. `registers` are the registers by
    /// net.
    fn allocate(
        &mut self,
        ids: &[NodeId],
        old: impl Fn(NodeId) -> Option<RegisterSlot>,
        origin: impl Fn(NodeId) -> Origin,
        score: impl Fn(NodeId, usize, &Slots) -> usize,
        registers: &mut BTreeMap<Origin, usize>,
    ) {
        for &id in ids {
            if let Some(RegisterSlot::Number(register)) = old(id) {
                self.take(id, register);
            }
        }
        for &id in ids {
            if let Some(&register) = registers.get(&origin(id)) {
                self.take(id, register);
            }
        }
        // Values without a preference come last, so that they take no preferred register.
        for least in [1, 0] {
            for &id in ids.iter().filter(|id| least == 0 || old(**id).is_none()) {
                let scores = self.free.iter().rev().map(|&register| (score(id, register, &self.slots), register));
                match scores.max_by_key(|(score, _)| *score) {
                    Some((score, register)) if score >= least => self.take(id, register),
                    _ => {}
                }
            }
        }
        for (&id, slot) in &self.slots {
            if let RegisterSlot::Number(register) = slot {
                registers.entry(origin(id)).or_insert(*register);
            }
        }
    }
}

/// Allocates flag bits to words. A word keeps its bits if all others still fit; if not, all are packed in order, which
/// always fits.
fn allocate_flags(
    ids: &[(NodeId, u32)],
    available: std::ops::Range<u32>,
    old: impl Fn(NodeId) -> Option<RegisterSlot>,
) -> Slots {
    let mut free: BTreeSet<u32> = available.clone().collect();
    let mut slots = Slots::new();
    let mut order: Vec<&(NodeId, u32)> = ids.iter().collect();
    order.sort_by_key(|(id, _)| old(*id).is_none());
    for &&(id, width) in &order {
        let fits = |low: u32| (low..low + width).all(|bit| free.contains(&bit)) && is_in_one_register(low, width);
        let low = match old(id) {
            Some(RegisterSlot::Flags { low, .. }) => Some(low).filter(|&low| fits(low)),
            _ => available.clone().find(|&low| fits(low)),
        };
        let Some(low) = low else { return pack(ids, available.start) };
        (low..low + width).for_each(|bit| {
            free.remove(&bit);
        });
        slots.insert(id, RegisterSlot::Flags { low, width });
    }
    slots
}

/// Allocates flag bits to words in order, from bit `first`.
fn pack(ids: &[(NodeId, u32)], first: u32) -> Slots {
    let mut next = first;
    let slot = |&(id, width): &(NodeId, u32)| {
        if !is_in_one_register(next, width) {
            next = next.next_multiple_of(FLAG_REGISTER);
        }
        let low = next;
        next += width;
        (id, RegisterSlot::Flags { low, width })
    };
    ids.iter().map(slot).collect()
}

fn is_in_one_register(low: u32, width: u32) -> bool {
    low / FLAG_REGISTER == (low + width - 1) / FLAG_REGISTER
}

/// The bit after the last allocated flag bit; `first` if there is none.
fn end(slots: &Slots, first: u32) -> u32 {
    let ends = slots.values().filter_map(|slot| match slot {
        RegisterSlot::Flags { low, width } => Some(low + width),
        _ => None,
    });
    ends.max().unwrap_or(first)
}
