//! Jobs and their outcomes as values: what goes in at the datapath's ports and what comes out.

use crate::binary32::Binary32;
use crate::bundle::{Bundle, Field, Path, Sink, Source};
use crate::circuit::{Bit, Num};
use crate::concrete::Concrete;
use crate::distance::{Angular, AngularInput, AngularOutput, Euclidean, EuclideanInput, EuclideanOutput};
use crate::operation::Operation;
use crate::ray_box::{RayBox, RayBoxInput, RayBoxOutput};
use crate::ray_triangle::{RayTriangle, RayTriangleInput, RayTriangleOutput};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// The operations of the paper; the discriminant is the opcode (`docs/ports.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JobKind {
    /// Ray against a triangle.
    Triangle = 0,
    /// Ray against four boxes.
    Quadbox = 1,
    /// A beat of a Euclidean distance.
    Euclidean = 2,
    /// A beat of an angular distance.
    Angular = 3,
}

/// One job (one beat) in the numbers of circuit `C`, with `E` Euclidean and `A` angular lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum Job<const E: usize = 16, const A: usize = 8, C: Concrete = Binary32> {
    /// Ray against a triangle.
    Triangle(RayTriangleInput<C>),
    /// Ray against four boxes.
    Quadbox(RayBoxInput<C>),
    /// A beat of a Euclidean distance.
    Euclidean(EuclideanInput<C, E>),
    /// A beat of an angular distance.
    Angular(AngularInput<C, A>),
}

/// What the datapath answers to a job. Equal where all bits are equal; made from ports, NaNs are canonical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<C: Concrete = Binary32> {
    /// Ray against a triangle.
    Triangle(RayTriangleOutput<C>),
    /// Ray against four boxes.
    Quadbox(RayBoxOutput<C>),
    /// A beat of a Euclidean distance.
    Euclidean(EuclideanOutput<C>),
    /// A beat of an angular distance.
    Angular(AngularOutput<C>),
}

/// The value of one port, in the bits that it has there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortValue {
    /// The port without its direction suffix: `ray_origin_x`.
    pub name: String,
    /// What its bits mean.
    pub kind: PortKind,
    /// Its bits.
    pub bits: u64,
}

/// What a port's bits mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortKind {
    /// A number, in IEEE 754's layout.
    Number,
    /// One bit, or one bit for each of several places.
    Flags,
    /// An unsigned word.
    Word,
}

impl JobKind {
    /// All of them, in order of their opcodes.
    pub const ALL: [Self; 4] = [Self::Triangle, Self::Quadbox, Self::Euclidean, Self::Angular];

    /// The two-bit opcode.
    pub fn opcode(self) -> u64 {
        self as u64
    }

    /// The name of its operation.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangle => RayTriangle::NAME,
            Self::Quadbox => RayBox::NAME,
            Self::Euclidean => Euclidean::<16>::NAME,
            Self::Angular => Angular::<8>::NAME,
        }
    }
}

impl fmt::Display for JobKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for JobKind {
    type Err = ParseJobKindError;
    fn from_str(name: &str) -> Result<Self, ParseJobKindError> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| ParseJobKindError(name.to_string()))
    }
}

/// A name that is no kind of job.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no kind of job, expected triangle, quadbox, euclidean or angular")]
pub struct ParseJobKindError(String);

/// What a job and an outcome have in common: one variant a kind, each holding the ports of its operation.
macro_rules! by_kind {
    ($type:ident[$($n:ident),*], $number:expr, $bits:expr) => {
        impl<$(const $n: usize,)* C: Concrete> $type<$($n,)* C> {
            /// Which operation it belongs to.
            pub fn kind(&self) -> JobKind {
                match self {
                    Self::Triangle(_) => JobKind::Triangle,
                    Self::Quadbox(_) => JobKind::Quadbox,
                    Self::Euclidean(_) => JobKind::Euclidean,
                    Self::Angular(_) => JobKind::Angular,
                }
            }

            /// The values of its ports; the opcode is not among them, and ports of other operations are zero.
            pub fn ports(&self) -> Vec<PortValue> {
                match self {
                    Self::Triangle(values) => ports(values, $bits),
                    Self::Quadbox(values) => ports(values, $bits),
                    Self::Euclidean(values) => ports(values, $bits),
                    Self::Angular(values) => ports(values, $bits),
                }
            }

            /// The bits of its ports, in the order of [`ports`](Self::ports), in place of what `words` held. Fast.
            pub fn words(&self, words: &mut Vec<u64>) {
                words.clear();
                let (path, sink) = (&mut Path::unnamed(), &mut ToWords { words, bits: $bits });
                match self {
                    Self::Triangle(values) => values.each(path, sink),
                    Self::Quadbox(values) => values.each(path, sink),
                    Self::Euclidean(values) => values.each(path, sink),
                    Self::Angular(values) => values.each(path, sink),
                }
            }

            /// The one of this kind whose [`words`](Self::words) are these; what is missing is 0, and bits beyond a
            /// port's width are ignored. Fast.
            pub fn from_words_in(circuit: C, kind: JobKind, words: &[u64]) -> Self {
                let words = words.iter();
                let (path, source) = (&mut Path::unnamed(), &mut FromWords { circuit, words, last: 0, number: $number });
                match kind {
                    JobKind::Triangle => Self::Triangle(Bundle::build(path, source)),
                    JobKind::Quadbox => Self::Quadbox(Bundle::build(path, source)),
                    JobKind::Euclidean => Self::Euclidean(Bundle::build(path, source)),
                    JobKind::Angular => Self::Angular(Bundle::build(path, source)),
                }
            }

            /// The one of this kind whose ports have the values that `port` gives by name.
            pub fn from_ports_in(circuit: C, kind: JobKind, port: impl FnMut(&str) -> u64) -> Self {
                let (path, source) = (&mut Path::default(), &mut FromPorts { circuit, port, number: $number });
                match kind {
                    JobKind::Triangle => Self::Triangle(Bundle::build(path, source)),
                    JobKind::Quadbox => Self::Quadbox(Bundle::build(path, source)),
                    JobKind::Euclidean => Self::Euclidean(Bundle::build(path, source)),
                    JobKind::Angular => Self::Angular(Bundle::build(path, source)),
                }
            }
        }

        impl<$(const $n: usize),*> $type<$($n),*> {
            /// The one of this kind whose ports have the values that `port` gives by name, in binary32.
            pub fn from_ports(kind: JobKind, port: impl FnMut(&str) -> u64) -> Self {
                Self::from_ports_in(Binary32, kind, port)
            }
        }
    };
}

// A job's numbers reach the ports as they are, NaN payloads included; an outcome's NaN is the canonical one.
by_kind!(Job[E, A], Concrete::number, Concrete::raw_bits);
by_kind!(Outcome[], canonical, Concrete::bits);

fn canonical<C: Concrete>(circuit: C, bits: u64) -> C::Num {
    circuit.number(circuit.bits(circuit.number(bits)))
}

fn ports<C: Concrete>(bundle: &impl Bundle<C>, bits: fn(C, C::Num) -> u64) -> Vec<PortValue> {
    let mut sink = ToPorts { ports: Vec::new(), bits };
    bundle.each(&mut Path::default(), &mut sink);
    sink.ports
}

struct ToPorts<C: Concrete> {
    ports: Vec<PortValue>,
    bits: fn(C, C::Num) -> u64,
}

impl<C: Concrete> ToPorts<C> {
    fn push(&mut self, field: Field<'_>, kind: PortKind, bits: u64) {
        self.ports.push(PortValue { name: field.name.to_string(), kind, bits });
    }
}

impl<C: Concrete> Sink<C> for ToPorts<C> {
    fn num(&mut self, field: Field<'_>, value: Num<C>) {
        self.push(field, PortKind::Number, (self.bits)(value.circuit, value.value));
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<C>) {
        let bit = u64::from(value.value);
        match (field.bit, self.ports.last_mut()) {
            (Some((index, _)), Some(port)) if index > 0 => port.bits |= bit << index,
            _ => self.push(field, PortKind::Flags, bit),
        }
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: u32) {
        self.push(field, PortKind::Word, value.into());
    }
}

struct FromPorts<C: Concrete, F> {
    circuit: C,
    port: F,
    number: fn(C, u64) -> C::Num,
}

impl<C: Concrete, F: FnMut(&str) -> u64> Source<C> for FromPorts<C, F> {
    fn num(&mut self, field: Field<'_>) -> Num<C> {
        Num::new(self.circuit, (self.number)(self.circuit, (self.port)(field.name)))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<C> {
        let index = field.bit.map_or(0, |(index, _)| index);
        Bit::new(self.circuit, (self.port)(field.name) >> index & 1 == 1)
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (C, u32) {
        (self.circuit, (self.port)(field.name) as u32 & (u32::MAX >> (32 - width)))
    }
}

/// Leaves in order, without names.
struct ToWords<'w, C: Concrete> {
    words: &'w mut Vec<u64>,
    bits: fn(C, C::Num) -> u64,
}

impl<C: Concrete> Sink<C> for ToWords<'_, C> {
    #[inline]
    fn num(&mut self, _: Field<'_>, value: Num<C>) {
        self.words.push((self.bits)(value.circuit, value.value));
    }
    #[inline]
    fn bit(&mut self, field: Field<'_>, value: Bit<C>) {
        let bit = u64::from(value.value);
        match (field.bit, self.words.last_mut()) {
            (Some((index, _)), Some(word)) if index > 0 => *word |= bit << index,
            _ => self.words.push(bit),
        }
    }
    #[inline]
    fn word(&mut self, _: Field<'_>, _width: u32, value: u32) {
        self.words.push(value.into());
    }
}

struct FromWords<'w, C: Concrete> {
    circuit: C,
    words: std::slice::Iter<'w, u64>,
    /// The word whose bits are being read.
    last: u64,
    number: fn(C, u64) -> C::Num,
}

impl<C: Concrete> FromWords<'_, C> {
    #[inline]
    fn next(&mut self) -> u64 {
        self.words.next().copied().unwrap_or(0)
    }
}

impl<C: Concrete> Source<C> for FromWords<'_, C> {
    #[inline]
    fn num(&mut self, _: Field<'_>) -> Num<C> {
        let bits = self.next();
        Num::new(self.circuit, (self.number)(self.circuit, bits))
    }
    #[inline]
    fn bit(&mut self, field: Field<'_>) -> Bit<C> {
        let index = field.bit.map_or(0, |(index, _)| index);
        if index == 0 {
            self.last = self.next();
        }
        Bit::new(self.circuit, self.last >> index & 1 == 1)
    }
    #[inline]
    fn word(&mut self, _: Field<'_>, width: u32) -> (C, u32) {
        (self.circuit, self.next() as u32 & (u32::MAX >> (32 - width)))
    }
}
