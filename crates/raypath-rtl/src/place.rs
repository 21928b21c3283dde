//! Where a value lives in the registers of a boundary. At any time a boundary holds one job, and its opcode says how to
//! read it; so operations share the registers, unless the configuration keeps them apart.

use crate::config::Sharing;
use crate::demand::Demands;
use crate::graph::{Kind, NodeId, PortBit, Traced};
use crate::units::Unit;
use std::collections::{BTreeMap, BTreeSet};

/// A place in the registers of one boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// The number register of this position.
    Number(usize),
    /// Bits of the flag registers, from `low` upwards.
    Flags {
        /// The least significant bit.
        low: u32,
        /// How many bits.
        width: u32,
    },
    /// The registers of a unit's cut.
    Cut(Unit),
}

/// Bits of one flag register; what needs more has several. A value never lies across two.
pub const FLAG_REGISTER: u32 = 64;

/// What drives a value where a step hands it on. Two values with the same origin are one net.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Origin {
    /// An input port.
    Port(PortBit),
    /// Registers of the boundary before.
    Place(Place),
    /// A unit's result.
    Unit(Unit),
    /// Logic of one operation.
    Logic(usize, NodeId),
}

/// Who lives where at one boundary.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Number registers.
    pub numbers: usize,
    /// Bits of the flag registers.
    pub flags: u32,
    /// Units whose cut this boundary is.
    pub cuts: BTreeSet<Unit>,
    /// The place of each value, operation by operation.
    pub places: Vec<BTreeMap<NodeId, Place>>,
}

impl Layout {
    /// Finds places for what each operation carries. Shared registers are as many as the neediest operation needs. What
    /// passes through keeps its place, and a new value goes where another operation puts the same net, so that few
    /// multiplexers are needed.
    pub fn new(
        sharing: Sharing,
        operations: &[Traced],
        carried: &[Vec<NodeId>],
        demands: &[Demands],
        before: &Layout,
        origin: impl Fn(usize, NodeId) -> Origin,
    ) -> Self {
        let needs: Vec<Needs> = operations.iter().zip(carried).map(|(traced, ids)| Needs::new(traced, ids)).collect();
        let mut layout = Self { places: vec![BTreeMap::new(); operations.len()], ..Self::default() };
        // The neediest operation chooses first: it has the least choice.
        let mut order: Vec<usize> = (0..operations.len()).collect();
        order.sort_by_key(|&op| std::cmp::Reverse((needs[op].numbers.len(), needs[op].flag_bits())));
        let mut residents: BTreeMap<Origin, usize> = BTreeMap::new();
        let most_numbers = needs.iter().map(|needs| needs.numbers.len()).max().unwrap_or(0);
        let most_flags = needs.iter().map(Needs::flag_bits).max().unwrap_or(0);
        for op in order {
            let old = |id: NodeId| before.places.get(op)?.get(&id).copied();
            let (numbers, flags) = match sharing {
                Sharing::Union => (0..most_numbers, 0..most_flags),
                Sharing::Segregated => {
                    residents.clear();
                    let own_numbers = layout.numbers..layout.numbers + needs[op].numbers.len();
                    (own_numbers, layout.flags..end(&pack(&needs[op].flags, layout.flags), layout.flags))
                }
            };
            let mut rooms = Rooms::new(numbers.clone());
            let shares = sharing == Sharing::Union;
            let fit = |id: NodeId, register: usize, places: &BTreeMap<NodeId, Place>| {
                let others = layout.places.iter().enumerate().filter(|_| shares);
                let there = others.flat_map(|(other, theirs)| {
                    let found = theirs.iter().filter(|(_, place)| **place == Place::Number(register));
                    found.map(move |(&id, _)| (other, id, theirs))
                });
                there.map(|(other, o, theirs)| demands[op].match_of(id, places, &demands[other], o, theirs)).sum()
            };
            let mut ids = needs[op].numbers.clone();
            ids.sort_by_key(|&id| std::cmp::Reverse(demands[op].count(id)));
            place_numbers(&ids, old, |id| origin(op, id), fit, &mut residents, &mut rooms);
            let placed = place_flags(&needs[op].flags, flags.clone(), old);
            layout.numbers = layout.numbers.max(numbers.end);
            layout.flags = layout.flags.max(end(&placed, 0));
            layout.places[op] = rooms.places;
            layout.places[op].extend(placed);
            for &id in &needs[op].cuts {
                if let Origin::Unit(unit) = origin(op, id) {
                    layout.places[op].insert(id, Place::Cut(unit));
                    layout.cuts.insert(unit);
                }
            }
        }
        layout
    }

    /// Widths of the flag registers.
    pub fn flag_registers(&self) -> impl Iterator<Item = u32> {
        let flags = self.flags;
        (0..flags.div_ceil(FLAG_REGISTER)).map(move |index| (flags - index * FLAG_REGISTER).min(FLAG_REGISTER))
    }
}

/// What one operation carries over a boundary.
struct Needs {
    numbers: Vec<NodeId>,
    /// Small words and their widths.
    flags: Vec<(NodeId, u32)>,
    /// What is on its way through units.
    cuts: Vec<NodeId>,
}

impl Needs {
    fn new(traced: &Traced, ids: &[NodeId]) -> Self {
        let mut needs = Self { numbers: Vec::new(), flags: Vec::new(), cuts: Vec::new() };
        for &id in ids {
            match traced.node(id).kind {
                Kind::Word(width) => needs.flags.push((id, width)),
                Kind::Cut(..) => needs.cuts.push(id),
                Kind::Number | Kind::Order => needs.numbers.push(id),
            }
        }
        needs
    }

    fn flag_bits(&self) -> u32 {
        end(&pack(&self.flags, 0), 0)
    }
}

/// The number registers of one operation, while they are given away.
struct Rooms {
    free: BTreeSet<usize>,
    places: BTreeMap<NodeId, Place>,
}

impl Rooms {
    fn new(registers: std::ops::Range<usize>) -> Self {
        Self { free: registers.collect(), places: BTreeMap::new() }
    }

    /// Gives `id` this register if it is free and `id` has none.
    fn take(&mut self, id: NodeId, register: usize) {
        if !self.places.contains_key(&id) && self.free.remove(&register) {
            self.places.insert(id, Place::Number(register));
        }
    }
}

/// First whoever has a place already stays, then whoever finds its own net somewhere joins it, then the rest go where
/// they fit best.
fn place_numbers(
    ids: &[NodeId],
    old: impl Fn(NodeId) -> Option<Place>,
    origin: impl Fn(NodeId) -> Origin,
    fit: impl Fn(NodeId, usize, &BTreeMap<NodeId, Place>) -> usize,
    residents: &mut BTreeMap<Origin, usize>,
    rooms: &mut Rooms,
) {
    for &id in ids {
        if let Some(Place::Number(register)) = old(id) {
            rooms.take(id, register);
        }
    }
    for &id in ids {
        if let Some(&register) = residents.get(&origin(id)) {
            rooms.take(id, register);
        }
    }
    // Those that fit nowhere in particular come last, so that they take nobody's place.
    for least in [1, 0] {
        for &id in ids.iter().filter(|id| least == 0 || old(**id).is_none()) {
            let fits = rooms.free.iter().rev().map(|&register| (fit(id, register, &rooms.places), register));
            match fits.max_by_key(|(fit, _)| *fit) {
                Some((fit, register)) if fit >= least => rooms.take(id, register),
                _ => {}
            }
        }
    }
    for (&id, place) in &rooms.places {
        if let Place::Number(register) = place {
            residents.entry(origin(id)).or_insert(*register);
        }
    }
}

/// Whoever has bits already keeps them if the rest still fits; else all are packed in order, which always fits.
fn place_flags(
    ids: &[(NodeId, u32)],
    available: std::ops::Range<u32>,
    old: impl Fn(NodeId) -> Option<Place>,
) -> BTreeMap<NodeId, Place> {
    let mut free: BTreeSet<u32> = available.clone().collect();
    let mut places = BTreeMap::new();
    let mut order: Vec<&(NodeId, u32)> = ids.iter().collect();
    order.sort_by_key(|(id, _)| old(*id).is_none());
    for &&(id, width) in &order {
        let fits = |low: u32| (low..low + width).all(|bit| free.contains(&bit)) && in_one_register(low, width);
        let low = match old(id) {
            Some(Place::Flags { low, .. }) => Some(low).filter(|&low| fits(low)),
            _ => available.clone().find(|&low| fits(low)),
        };
        let Some(low) = low else { return pack(ids, available.start) };
        (low..low + width).for_each(|bit| {
            free.remove(&bit);
        });
        places.insert(id, Place::Flags { low, width });
    }
    places
}

/// One after the other, from bit `first`.
fn pack(ids: &[(NodeId, u32)], first: u32) -> BTreeMap<NodeId, Place> {
    let mut next = first;
    let place = |&(id, width): &(NodeId, u32)| {
        if !in_one_register(next, width) {
            next = next.next_multiple_of(FLAG_REGISTER);
        }
        let low = next;
        next += width;
        (id, Place::Flags { low, width })
    };
    ids.iter().map(place).collect()
}

fn in_one_register(low: u32, width: u32) -> bool {
    low / FLAG_REGISTER == (low + width - 1) / FLAG_REGISTER
}

/// The bit after the last of those that are given away, `first` if there are none.
fn end(places: &BTreeMap<NodeId, Place>, first: u32) -> u32 {
    let ends = places.values().filter_map(|place| match place {
        Place::Flags { low, width } => Some(low + width),
        _ => None,
    });
    ends.max().unwrap_or(first)
}
