//! Where a value lives in the registers of a boundary. Operations share the registers: at any time a boundary holds one
//! job, and its opcode says how to read it.

use crate::graph::{Kind, NodeId, PortBit, Traced};
use crate::units::Unit;
use std::collections::BTreeMap;

/// A place in the registers of one boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// The number register of this position.
    Number(usize),
    /// Bits of the flag register, from `low` upwards.
    Flags {
        /// The least significant bit.
        low: u32,
        /// How many bits.
        width: u32,
    },
}

/// What drives a value where a stage hands it on. Two values with the same origin are one net.
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
    /// Bits of the flag register.
    pub flags: u32,
    /// The place of each value, operation by operation.
    pub places: Vec<BTreeMap<NodeId, Place>>,
}

impl Layout {
    /// Finds places for what each operation carries. The registers are as many as the neediest operation needs. What
    /// passes through keeps its place, and a new value goes where another operation puts the same net, so that few
    /// multiplexers are needed.
    pub fn new(
        operations: &[Traced],
        carried: &[Vec<NodeId>],
        before: &Layout,
        origin: impl Fn(usize, NodeId) -> Origin,
    ) -> Self {
        let needs: Vec<Needs> = operations.iter().zip(carried).map(|(traced, ids)| Needs::new(traced, ids)).collect();
        let mut layout = Self {
            numbers: needs.iter().map(|needs| needs.numbers.len()).max().unwrap_or(0),
            flags: needs.iter().map(Needs::flag_bits).max().unwrap_or(0),
            places: vec![BTreeMap::new(); operations.len()],
        };
        // The neediest operation chooses first: it has the least choice.
        let mut order: Vec<usize> = (0..operations.len()).collect();
        order.sort_by_key(|&op| std::cmp::Reverse((needs[op].numbers.len(), needs[op].flag_bits())));
        let mut residents: BTreeMap<Origin, usize> = BTreeMap::new();
        for op in order {
            let old = |id: NodeId| before.places.get(op)?.get(&id).copied();
            let mut rooms = Rooms { free: vec![true; layout.numbers], places: BTreeMap::new() };
            place_numbers(&needs[op].numbers, old, |id| origin(op, id), &mut residents, &mut rooms);
            layout.places[op] = rooms.places;
            layout.places[op].extend(place_flags(&needs[op].flags, layout.flags, old));
        }
        layout
    }
}

/// What one operation carries over a boundary.
struct Needs {
    numbers: Vec<NodeId>,
    /// Small words and their widths.
    flags: Vec<(NodeId, u32)>,
}

impl Needs {
    fn new(traced: &Traced, ids: &[NodeId]) -> Self {
        let mut needs = Self { numbers: Vec::new(), flags: Vec::new() };
        for &id in ids {
            match traced.node(id).kind {
                Kind::Word(width) => needs.flags.push((id, width)),
                Kind::Ieee | Kind::Recoded | Kind::Order => needs.numbers.push(id),
            }
        }
        needs
    }

    fn flag_bits(&self) -> u32 {
        self.flags.iter().map(|(_, width)| width).sum()
    }
}

/// The number registers of one operation, while they are given away.
struct Rooms {
    free: Vec<bool>,
    places: BTreeMap<NodeId, Place>,
}

impl Rooms {
    /// Gives `id` this register if it is free and `id` has none.
    fn take(&mut self, id: NodeId, register: usize) -> bool {
        let takes = self.free.get(register) == Some(&true) && !self.places.contains_key(&id);
        if takes {
            self.free[register] = false;
            self.places.insert(id, Place::Number(register));
        }
        takes
    }
}

/// First whoever has a place already stays, then whoever finds its own net somewhere joins it, then the rest fill up.
fn place_numbers(
    ids: &[NodeId],
    old: impl Fn(NodeId) -> Option<Place>,
    origin: impl Fn(NodeId) -> Origin,
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
    for &id in ids {
        if let Some(register) = rooms.free.iter().position(|&free| free) {
            rooms.take(id, register);
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
    available: u32,
    old: impl Fn(NodeId) -> Option<Place>,
) -> BTreeMap<NodeId, Place> {
    let mut free = vec![true; available as usize];
    let mut places = BTreeMap::new();
    let mut order: Vec<&(NodeId, u32)> = ids.iter().collect();
    order.sort_by_key(|(id, _)| old(*id).is_none());
    for &&(id, width) in &order {
        let fits =
            |low: u32| free.get(low as usize..(low + width) as usize).is_some_and(|bits| bits.iter().all(|&bit| bit));
        let low = match old(id) {
            Some(Place::Flags { low, .. }) => Some(low).filter(|&low| fits(low)),
            _ => (0..available).find(|&low| fits(low)),
        };
        let Some(low) = low else { return pack(ids) };
        free[low as usize..(low + width) as usize].fill(false);
        places.insert(id, Place::Flags { low, width });
    }
    places
}

fn pack(ids: &[(NodeId, u32)]) -> BTreeMap<NodeId, Place> {
    let mut low = 0;
    let place = |&(id, width): &(NodeId, u32)| {
        low += width;
        (id, Place::Flags { low: low - width, width })
    };
    ids.iter().map(place).collect()
}
