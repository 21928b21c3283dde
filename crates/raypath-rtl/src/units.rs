//! Which unit of a stage does what: the k-th adder of every operation is the same adder.

use crate::graph::{NodeId, Op, Traced};
use crate::liveness::Work;
use std::collections::BTreeMap;
use std::fmt;

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

/// How many units a stage has.
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

/// A unit of a stage, by kind and number.
pub type Unit = (UnitKind, usize);

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

/// The unit that makes each of an operation's values in one stage.
pub fn assign(traced: &Traced, work: &Work) -> BTreeMap<NodeId, Unit> {
    let mut used = Units::default();
    let mut units = BTreeMap::new();
    for &id in &work.made {
        if let Some(kind) = kind(&traced.node(id).op) {
            let next = used.of_mut(kind);
            units.insert(id, (kind, *next));
            *next += 1;
        }
    }
    units
}

fn kind(op: &Op) -> Option<UnitKind> {
    match op {
        Op::Encode(_) => Some(UnitKind::Encode),
        Op::Add(..) | Op::Subtract(..) => Some(UnitKind::Add),
        Op::Multiply(..) => Some(UnitKind::Multiply),
        Op::Compare(..) => Some(UnitKind::Compare),
        Op::Decode(_) => Some(UnitKind::Decode),
        _ => None,
    }
}
