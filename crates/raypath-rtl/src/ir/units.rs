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
    /// Adder of three or more terms, which rounds once.
    Sum,
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
    /// Adders of three or more terms.
    pub sum: usize,
    /// Multipliers.
    pub multiply: usize,
    /// Comparators.
    pub compare: usize,
    /// Decoders, recoded to IEEE 754.
    pub decode: usize,
}

/// The steps of an adder of `terms` terms, at least 3. The stage that an operation marks is that of the last.
pub fn sum_steps(terms: u32) -> u32 {
    if terms == 3 { 2 } else { 3 }
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

/// The significands of a unit's operands and result, or the number of its operands. A narrow unit has short operands
/// ([`Widths`](super::widths::Widths)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum UnitWidth {
    /// All have the significand of the format.
    Full,
    /// Operands are short, and the result is no number.
    Short,
    /// Operands are short, and the result is rounded so that it is short too.
    Rounding(Narrowing),
    /// The second operand has a significand of at most this number of bits; the others have that of the format.
    ShortFactor(u32),
    /// All have the significand of the format, and the unit has this number of operands.
    Terms(u32),
}

impl Unit {
    /// The stem of its instance name, such as `add_3` or `mul_toward_zero_3`.
    pub fn stem(self) -> String {
        let width: String = match self.width {
            UnitWidth::Full => "".into(),
            UnitWidth::Short => "_narrow".into(),
            UnitWidth::ShortFactor(_) => "_by_short".into(),
            UnitWidth::Rounding(Narrowing { direction: Direction::TowardZero, .. }) => "_toward_zero".into(),
            UnitWidth::Rounding(Narrowing { direction: Direction::AwayFromZero, .. }) => "_away_from_zero".into(),
            // With the part, because a step may have parts of sums that began in different steps.
            UnitWidth::Terms(terms) => format!("_of_{terms}_part_{}", self.part + 1),
        };
        format!("{}{width}_{}", self.kind.stem(), self.number)
    }
}

impl UnitKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [Self::Encode, Self::Add, Self::Sum, Self::Multiply, Self::Compare, Self::Decode];

    /// The stem of its module's name, `raypath_fp_<stem>_<format>`.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Encode => "encode",
            Self::Add => "add",
            Self::Sum => "sum",
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
            Self::Sum => "adder of several terms",
            Self::Multiply => "multiplier",
            Self::Compare => "comparator",
            Self::Decode => "decoder",
        })
    }
}

impl Units {
    /// The number of units of one kind.
    pub fn of(mut self, kind: UnitKind) -> usize {
        *self.of_mut(kind)
    }

    /// A function of both numbers of units of each kind.
    pub fn join(mut self, other: Self, each: impl Fn(usize, usize) -> usize) -> Self {
        for kind in UnitKind::ALL {
            *self.of_mut(kind) = each(self.of(kind), other.of(kind));
        }
        self
    }

    /// The number of units of one kind, for modification.
    pub(crate) fn of_mut(&mut self, kind: UnitKind) -> &mut usize {
        match kind {
            UnitKind::Encode => &mut self.encode,
            UnitKind::Add => &mut self.add,
            UnitKind::Sum => &mut self.sum,
            UnitKind::Multiply => &mut self.multiply,
            UnitKind::Compare => &mut self.compare,
            UnitKind::Decode => &mut self.decode,
        }
    }
}

impl Add for Units {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.join(other, usize::add)
    }
}

impl Sum for Units {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}
