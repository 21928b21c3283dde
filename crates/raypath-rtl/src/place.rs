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
        carried: &[&[NodeId]],
        before: &Layout,
        origin: impl Fn(usize, NodeId) -> Origin,
    ) -> Self {
        let mut layout = Self { places: vec![BTreeMap::new(); operations.len()], ..Self::default() };
        let parts: Vec<(Vec<NodeId>, Vec<NodeId>)> = operations
            .iter()
            .zip(carried)
            .map(|(traced, ids)| ids.iter().partition(|id| !matches!(traced.node(**id).kind, Kind::Word(_))))
            .collect();
        let flag_bits = |op: usize| parts[op].1.iter().map(|&id| width(&operations[op], id)).sum::<u32>();
        layout.numbers = parts.iter().map(|(numbers, _)| numbers.len()).max().unwrap_or(0);
        layout.flags = (0..operations.len()).map(flag_bits).max().unwrap_or(0);

        // The neediest operation chooses first: it has the least choice.
        let mut order: Vec<usize> = (0..operations.len()).collect();
        order.sort_by_key(|&op| std::cmp::Reverse((parts[op].0.len(), flag_bits(op))));
        let mut residents: BTreeMap<Origin, usize> = BTreeMap::new();
        for op in order {
            let old = before.places.get(op);
            let numbers = place_numbers(&parts[op].0, layout.numbers, old, |id| origin(op, id), &mut residents);
            let widths: Vec<(NodeId, u32)> = parts[op].1.iter().map(|&id| (id, width(&operations[op], id))).collect();
            layout.places[op].extend(numbers);
            layout.places[op].extend(place_flags(&widths, layout.flags, old));
        }
        layout
    }
}

fn width(traced: &Traced, id: NodeId) -> u32 {
    match traced.node(id).kind {
        Kind::Word(width) => width,
        Kind::Ieee | Kind::Recoded | Kind::Order => 0,
    }
}

/// First whoever has a place already stays, then whoever finds its own net somewhere joins it, then the rest fill up.
fn place_numbers(
    ids: &[NodeId],
    available: usize,
    old: Option<&BTreeMap<NodeId, Place>>,
    origin: impl Fn(NodeId) -> Origin,
    residents: &mut BTreeMap<Origin, usize>,
) -> BTreeMap<NodeId, Place> {
    let mut free = vec![true; available];
    let mut places = BTreeMap::new();
    let stays = |id: NodeId, _: &BTreeMap<Origin, usize>, _: &[bool]| match old?.get(&id)? {
        Place::Number(place) => Some(*place),
        Place::Flags { .. } => None,
    };
    let joins = |id: NodeId, residents: &BTreeMap<Origin, usize>, _: &[bool]| residents.get(&origin(id)).copied();
    let fills = |_: NodeId, _: &BTreeMap<Origin, usize>, free: &[bool]| free.iter().position(|&free| free);
    type Choice<'c> = &'c dyn Fn(NodeId, &BTreeMap<Origin, usize>, &[bool]) -> Option<usize>;
    for choice in [&stays as Choice<'_>, &joins, &fills] {
        for &id in ids {
            if places.contains_key(&id) {
                continue;
            }
            if let Some(place) = choice(id, residents, &free).filter(|&place| free.get(place) == Some(&true)) {
                free[place] = false;
                residents.entry(origin(id)).or_insert(place);
                places.insert(id, Place::Number(place));
            }
        }
    }
    places
}

/// Whoever has bits already keeps them if the rest still fits; else all are packed in order.
fn place_flags(
    ids: &[(NodeId, u32)],
    available: u32,
    old: Option<&BTreeMap<NodeId, Place>>,
) -> BTreeMap<NodeId, Place> {
    let stays = |id: &NodeId| match old?.get(id)? {
        Place::Flags { low, .. } => Some(*low),
        Place::Number(_) => None,
    };
    pack(ids, available, stays).or_else(|| pack(ids, available, |_| None)).unwrap_or_default()
}

fn pack(
    ids: &[(NodeId, u32)],
    available: u32,
    stays: impl Fn(&NodeId) -> Option<u32>,
) -> Option<BTreeMap<NodeId, Place>> {
    let mut free = vec![true; available as usize];
    let mut places = BTreeMap::new();
    let mut order: Vec<&(NodeId, u32)> = ids.iter().collect();
    order.sort_by_key(|(id, _)| stays(id).is_none());
    for (id, width) in order {
        let fits =
            |low: u32| free.get(low as usize..(low + width) as usize).is_some_and(|bits| bits.iter().all(|&b| b));
        let low = match stays(id) {
            Some(low) => Some(low).filter(|&low| fits(low)),
            None => (0..available).find(|&low| fits(low)),
        }?;
        free[low as usize..(low + width) as usize].fill(false);
        places.insert(*id, Place::Flags { low, width: *width });
    }
    Some(places)
}
