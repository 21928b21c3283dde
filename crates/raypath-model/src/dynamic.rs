//! Arithmetic in a format that is chosen at run time.

use crate::soft::{Soft, SoftNumber};
use raypath_float::Format;
use raypath_ops::{Binary32, Circuit, Concrete, Flagged, Narrowing, Relation, Single, Test, known_bits_and_words};
use std::cell::Cell;
use std::cmp::Ordering;

/// One of three circuits, chosen at run time, so that operations are compiled once and not for each of the three.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dynamic<'f> {
    /// Native binary32.
    Native,
    /// Binary32 with exception flags.
    Flagged(Flagged<'f>),
    /// Software arithmetic in another format.
    Soft(Soft),
}

impl<'f> Dynamic<'f> {
    /// The circuit for `format`. In binary32, `raised` collects the exceptions of additions and multiplications.
    pub fn new(format: Format, raised: Option<&'f Cell<u64>>) -> Self {
        match raised {
            _ if format != Format::BINARY32 => Self::Soft(Soft { format }),
            Some(raised) => Self::Flagged(Flagged { raised }),
            None => Self::Native,
        }
    }
}

fn single(number: SoftNumber) -> Single {
    Binary32.number(number.0)
}

fn number(single: Single) -> SoftNumber {
    SoftNumber(Binary32.raw_bits(single))
}

/// Evaluates `$native` for binary32, and `$by_soft` for the software circuit `$soft`.
macro_rules! either {
    ($circuit:expr, $native:expr, $soft:ident => $by_soft:expr) => {
        match $circuit {
            Dynamic::Native | Dynamic::Flagged(_) => $native,
            Dynamic::Soft($soft) => $by_soft,
        }
    };
}

/// Declares methods of arithmetic, of which only the circuit with exception flags differs from the native one.
macro_rules! arithmetic {
    ($($method:ident)*) => {$(
        #[inline(never)]
        fn $method(self, a: SoftNumber, b: SoftNumber) -> SoftNumber {
            match self {
                Self::Native => number(Binary32.$method(single(a), single(b))),
                Self::Flagged(flagged) => number(flagged.$method(single(a), single(b))),
                Self::Soft(soft) => soft.$method(a, b),
            }
        }
    )*};
}

// Not inlined, because the inlined code of all operations takes long to compile.
impl Circuit for Dynamic<'_> {
    type Num = SoftNumber;
    type Bit = bool;
    type Word = u32;
    type Order = Option<Ordering>;

    #[inline(never)]
    fn constant(self, value: f32) -> SoftNumber {
        either!(self, number(Single(value)), soft => soft.constant(value))
    }
    #[inline(never)]
    fn ulps(self, ulps: u32) -> SoftNumber {
        either!(self, number(Binary32.ulps(ulps)), soft => soft.ulps(ulps))
    }
    arithmetic! { add subtract multiply }

    #[inline(never)]
    fn sum(self, terms: &[SoftNumber]) -> SoftNumber {
        let soft = match self {
            Self::Native | Self::Flagged(_) => Soft { format: Format::BINARY32 },
            Self::Soft(soft) => soft,
        };
        soft.sum(terms)
    }

    #[inline(never)]
    fn residue(self, product: SoftNumber, a: SoftNumber, b: SoftNumber) -> u32 {
        either!(self, Binary32.residue(single(product), single(a), single(b)), soft => soft.residue(product, a, b))
    }
    #[inline(never)]
    fn negate(self, a: SoftNumber) -> SoftNumber {
        either!(self, number(Binary32.negate(single(a))), soft => soft.negate(a))
    }
    #[inline(never)]
    fn narrow(self, a: SoftNumber, to: Narrowing) -> SoftNumber {
        either!(self, number(Binary32.narrow(single(a), to)), soft => soft.narrow(a, to))
    }
    #[inline(never)]
    fn compare(self, a: SoftNumber, b: SoftNumber) -> Option<Ordering> {
        either!(self, single(a).0.partial_cmp(&single(b).0), soft => soft.compare(a, b))
    }
    #[inline(never)]
    fn relation(self, order: Option<Ordering>, relation: Relation) -> bool {
        Soft { format: Format::BINARY32 }.relation(order, relation)
    }
    #[inline(never)]
    fn number_of(self, width: u32, word: u32) -> SoftNumber {
        either!(self, number(Binary32.number_of(width, word)), soft => soft.number_of(width, word))
    }
    #[inline(never)]
    fn test(self, test: Test, a: SoftNumber) -> bool {
        either!(self, Binary32.test(test, single(a)), soft => soft.test(test, a))
    }

    known_bits_and_words!();
}

impl Concrete for Dynamic<'_> {
    fn number(self, ieee_bits: u64) -> SoftNumber {
        either!(self, number(Binary32.number(ieee_bits)), soft => soft.number(ieee_bits))
    }
    fn bits(self, number: SoftNumber) -> u64 {
        either!(self, Binary32.bits(single(number)), soft => soft.bits(number))
    }
    fn raw_bits(self, number: SoftNumber) -> u64 {
        number.0
    }
}
