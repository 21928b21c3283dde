//! The registers of a boundary, and the values that each operation keeps in them.

use crate::ir::graph::{NodeId, PortBit};
use crate::ir::units::Unit;
use std::collections::{BTreeMap, BTreeSet};

/// A slot in the registers of one boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RegisterSlot {
    /// The number register with this index.
    Number(usize),
    /// Bits of the flag registers, from `low` upwards.
    Flags {
        /// The least significant bit.
        low: u32,
        /// The number of bits.
        width: u32,
    },
    /// The registers between two parts of a unit.
    Cut(Unit),
}

/// The greatest width of a flag register. More bits make several registers, and no value lies across two.
pub const FLAG_REGISTER: u32 = 64;

/// The driver of a value at the end of a step. Two values with the same origin are one net.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Origin {
    /// An input port.
    Port(PortBit),
    /// Registers of the boundary before.
    Register(RegisterSlot),
    /// A unit's result.
    Unit(Unit),
    /// Logic of one operation.
    Logic(usize, NodeId),
}

/// The slots of one operation's values.
pub type Slots = BTreeMap<NodeId, RegisterSlot>;

/// The registers of a boundary and the slots of the values in them.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// The number of number registers.
    pub numbers: usize,
    /// Bits of the flag registers.
    pub flags: u32,
    /// The units that are cut at this boundary.
    pub cuts: BTreeSet<Unit>,
    /// The slots of each operation's values.
    pub slots: Vec<Slots>,
}

impl Layout {
    /// The widths of the flag registers.
    pub fn flag_registers(&self) -> impl Iterator<Item = u32> {
        let flags = self.flags;
        (0..flags.div_ceil(FLAG_REGISTER)).map(move |index| (flags - index * FLAG_REGISTER).min(FLAG_REGISTER))
    }

    /// The slot of an operation's value, if it is in the registers.
    pub fn slot(&self, op: usize, id: NodeId) -> Option<RegisterSlot> {
        self.slots.get(op)?.get(&id).copied()
    }
}
