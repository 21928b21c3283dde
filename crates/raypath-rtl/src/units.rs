//! The units of a step.

use crate::graph::{Kind, NodeId, Op, Traced};
use std::fmt;
use std::iter::Sum;
use std::ops::Add;

/// The floating-point units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UnitKind {
    /// Binary32 to recoded.
    Encode,
    /// Sum or difference.
    Add,
    /// Product.
    Multiply,
    /// Comparison.
    Compare,
    /// Recoded to binary32.
    Decode,
}

/// How many units a step has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Units {
    /// Encoders, binary32 to recoded.
    pub encode: usize,
    /// Adders.
    pub add: usize,
    /// Multipliers.
    pub multiply: usize,
    /// Comparators.
    pub compare: usize,
    /// Decoders, recoded to binary32.
    pub decode: usize,
}

/// A unit of a step, or the part of one that the step has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Unit {
    pub kind: UnitKind,
    /// The part, from 0.
    pub part: u32,
    /// Which of the step's units of this kind and part, from 0.
    pub number: usize,
}

impl Unit {
    /// What its instance is called: `add_3`.
    pub fn stem(self) -> String {
        format!("{}_{}", self.kind.stem(), self.number)
    }
}

impl UnitKind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Encode, Self::Add, Self::Multiply, Self::Compare, Self::Decode];

    /// The stem of its module's name, `raypath_fp_<stem>_<format>`.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Encode => "encode",
            Self::Add => "add",
            Self::Multiply => "mul",
            Self::Compare => "compare",
            Self::Decode => "decode",
        }
    }
}

impl fmt::Display for UnitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Encode => "encoder",
            Self::Add => "adder",
            Self::Multiply => "multiplier",
            Self::Compare => "comparator",
            Self::Decode => "decoder",
        })
    }
}

impl Units {
    /// The number of units of one kind.
    pub fn of(self, kind: UnitKind) -> usize {
        match kind {
            UnitKind::Encode => self.encode,
            UnitKind::Add => self.add,
            UnitKind::Multiply => self.multiply,
            UnitKind::Compare => self.compare,
            UnitKind::Decode => self.decode,
        }
    }

    /// The number of units of one kind, to be changed.
    pub(crate) fn of_mut(&mut self, kind: UnitKind) -> &mut usize {
        match kind {
            UnitKind::Encode => &mut self.encode,
            UnitKind::Add => &mut self.add,
            UnitKind::Multiply => &mut self.multiply,
            UnitKind::Compare => &mut self.compare,
            UnitKind::Decode => &mut self.decode,
        }
    }
}

impl Add for Units {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            encode: self.encode + other.encode,
            add: self.add + other.add,
            multiply: self.multiply + other.multiply,
            compare: self.compare + other.compare,
            decode: self.decode + other.decode,
        }
    }
}

impl Sum for Units {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

/// The kind of unit that makes a value, and which of its parts.
pub fn part(traced: &Traced, id: NodeId) -> Option<(UnitKind, u32)> {
    match traced.node(id).op {
        Op::Add(..) | Op::Subtract(..) => Some((UnitKind::Add, 0)),
        Op::Multiply(..) => Some((UnitKind::Multiply, 0)),
        Op::Compare(..) => Some((UnitKind::Compare, 0)),
        Op::Continue(before) => match traced.node(before).kind {
            Kind::Cut(kind, part) => Some((kind, part + 1)),
            _ => None,
        },
        _ => None,
    }
}
