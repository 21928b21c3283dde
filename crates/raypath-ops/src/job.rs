//! Jobs and their outcomes as values: what goes in at the datapath's ports and what comes out.

use crate::binary32::Binary32;
use crate::bundle::{Bundle, Field, Path, Sink, Source};
use crate::circuit::{Bit, Circuit, Num};
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

/// One job (one beat), with `E` Euclidean and `A` angular lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum Job<const E: usize = 16, const A: usize = 8> {
    /// Ray against a triangle.
    Triangle(RayTriangleInput<Binary32>),
    /// Ray against four boxes.
    Quadbox(RayBoxInput<Binary32>),
    /// A beat of a Euclidean distance.
    Euclidean(EuclideanInput<Binary32, E>),
    /// A beat of an angular distance.
    Angular(AngularInput<Binary32, A>),
}

/// What the datapath answers to a job. Equal where all bits are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Ray against a triangle.
    Triangle(RayTriangleOutput<Binary32>),
    /// Ray against four boxes.
    Quadbox(RayBoxOutput<Binary32>),
    /// A beat of a Euclidean distance.
    Euclidean(EuclideanOutput<Binary32>),
    /// A beat of an angular distance.
    Angular(AngularOutput<Binary32>),
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
    /// A binary32 number.
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
    ($type:ident $(<$(const $n:ident: usize),*>)?, $bits:expr) => {
        impl $(<$(const $n: usize),*>)? $type $(<$($n),*>)? {
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

            /// The one of this kind whose ports have the values that `port` gives by name.
            pub fn from_ports(kind: JobKind, port: impl FnMut(&str) -> u64) -> Self {
                let (path, source) = (&mut Path::default(), &mut FromPorts(port));
                match kind {
                    JobKind::Triangle => Self::Triangle(Bundle::build(path, source)),
                    JobKind::Quadbox => Self::Quadbox(Bundle::build(path, source)),
                    JobKind::Euclidean => Self::Euclidean(Bundle::build(path, source)),
                    JobKind::Angular => Self::Angular(Bundle::build(path, source)),
                }
            }
        }
    };
}

by_kind!(Job<const E: usize, const A: usize>, raw_bits);
by_kind!(Outcome, Num::to_bits);

/// A job's numbers reach the ports as they are, NaN payloads included.
fn raw_bits(number: Num<Binary32>) -> u32 {
    f32::from(number).to_bits()
}

fn ports(bundle: &impl Bundle<Binary32>, bits: fn(Num<Binary32>) -> u32) -> Vec<PortValue> {
    let mut sink = ToPorts { ports: Vec::new(), bits };
    bundle.each(&mut Path::default(), &mut sink);
    sink.ports
}

struct ToPorts {
    ports: Vec<PortValue>,
    bits: fn(Num<Binary32>) -> u32,
}

impl ToPorts {
    fn push(&mut self, field: Field<'_>, kind: PortKind, bits: u64) {
        self.ports.push(PortValue { name: field.name.to_string(), kind, bits });
    }
}

impl Sink<Binary32> for ToPorts {
    fn num(&mut self, field: Field<'_>, value: Num<Binary32>) {
        self.push(field, PortKind::Number, (self.bits)(value).into());
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Binary32>) {
        let bit = u64::from(bool::from(value));
        match (field.bit, self.ports.last_mut()) {
            (Some((index, _)), Some(port)) if index > 0 => port.bits |= bit << index,
            _ => self.push(field, PortKind::Flags, bit),
        }
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: u32) {
        self.push(field, PortKind::Word, value.into());
    }
}

struct FromPorts<F>(F);

impl<F: FnMut(&str) -> u64> Source<Binary32> for FromPorts<F> {
    fn num(&mut self, field: Field<'_>) -> Num<Binary32> {
        Num::from_bits((self.0)(field.name) as u32)
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Binary32> {
        let index = field.bit.map_or(0, |(index, _)| index);
        ((self.0)(field.name) >> index & 1 == 1).into()
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Binary32, <Binary32 as Circuit>::Word) {
        (Binary32, (self.0)(field.name) as u32 & (u32::MAX >> (32 - width)))
    }
}
