//! The floating-point units, and how many of each kind a step has.

use raypath_ops::{Direction, Narrowing};
use std::fmt;
use std::iter::Sum;
use std::ops::Add;

/// The kinds of floating-point units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UnitKind {
    /// Encoder: IEEE 754 to recoded.
    Encode,
    /// Adder: sum or difference.
    Add,
    /// Multiplier.
    Multiply,
    /// Comparator.
    Compare,
    /// Decoder: recoded to IEEE 754.
    Decode,
}

/// The number of units of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Units {
    /// Encoders, IEEE 754 to recoded.
    pub encode: usize,
    /// Adders.
    pub add: usize,
    /// Multipliers.
    pub multiply: usize,
    /// Comparators.
    pub compare: usize,
    /// Decoders, recoded to IEEE 754.
    pub decode: usize,
}

/// A unit of a step. A unit with a latency of several steps has a part in each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Unit {
    pub kind: UnitKind,
    /// The part, from 0.
    pub part: u32,
    /// The significands of its operands and its result.
    pub width: UnitWidth,
    /// Its number among the units of this kind, part and width in the step, from 0.
    pub number: usize,
}

/// The significands of a unit's operands and result. A narrow unit has short operands
/// ([`Widths`](super::widths::Widths)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UnitWidth {
    /// All have the significand of the format.
    Full,
    /// Operands are short, and the result is no number.
    Short,
    /// Operands are short, and the result is rounded so that it is short too.
    Rounding(Narrowing),
}

impl Unit {
    /// The stem of its instance name, such as `add_3` or `mul_toward_zero_3`.
    pub fn stem(self) -> String {
        let width = match self.width {
            UnitWidth::Full => "",
            UnitWidth::Short => "_narrow",
            UnitWidth::Rounding(Narrowing { direction: Direction::TowardZero, .. }) => "_toward_zero",
            UnitWidth::Rounding(Narrowing { direction: Direction::AwayFromZero, .. }) => "_away_from_zero",
        };
        format!("{}{width}_{}", self.kind.stem(), self.number)
    }
}

impl UnitKind {
    /// All kinds.
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

    /// The number of units of one kind, for modification.
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
