//! Jobs and outcomes of the paper's operations in their own types: the fast path of the functional model.

use crate::ports::{FromWords, Shapes, ToWords, canonical};
use crate::{
    Angular, AngularOutput, BeatInput, Binary32, Bundle, Concrete, Euclidean, EuclideanOutput, Operation, Path, Port,
    PortValue, RayBox, RayBoxInput, RayBoxOutput, RayTriangle, RayTriangleInput, RayTriangleOutput, Source,
};

/// The paper's operations. The discriminant is the opcode (`docs/integration/ports.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JobKind {
    /// A ray against a triangle.
    Triangle = 0,
    /// A ray against four boxes.
    Quadbox = 1,
    /// A beat of a Euclidean distance.
    Euclidean = 2,
    /// A beat of an angular distance.
    Angular = 3,
}

/// A job of one of the paper's operations over circuit `C`, with `E` Euclidean and `A` angular lanes. A job of a
/// distance is one beat.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum Job<const E: usize = 16, const A: usize = 8, C: Concrete = Binary32> {
    /// A ray against a triangle.
    Triangle(RayTriangleInput<C>),
    /// A ray against four boxes.
    Quadbox(RayBoxInput<C>),
    /// A beat of a Euclidean distance.
    Euclidean(BeatInput<C, E>),
    /// A beat of an angular distance.
    Angular(BeatInput<C, A>),
}

/// The outcome of a [`Job`]. Two are equal if all bits are. NaNs are canonical in outcomes from port values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<C: Concrete = Binary32> {
    /// A ray against a triangle.
    Triangle(RayTriangleOutput<C>),
    /// A ray against four boxes.
    Quadbox(RayBoxOutput<C>),
    /// A beat of a Euclidean distance.
    Euclidean(EuclideanOutput<C>),
    /// A beat of an angular distance.
    Angular(AngularOutput<C>),
}

impl JobKind {
    /// All of them, in order of their opcodes.
    pub const ALL: [Self; 4] = [Self::Triangle, Self::Quadbox, Self::Euclidean, Self::Angular];

    /// The two-bit opcode.
    pub fn opcode(self) -> u64 {
        self as u64
    }
}

names! {
    JobKind {
        Triangle = RayTriangle::NAME,
        Quadbox = RayBox::NAME,
        Euclidean = Euclidean::<16>::NAME,
        Angular = Angular::<8>::NAME
    },
    /// The error of a name that is not one of the paper's operations.
    ParseJobKindError, "'{0}' is not a valid kind of job, expected triangle, quadbox, euclidean or angular"
}

/// Evaluates an expression for the values of any variant of a job or an outcome.
macro_rules! each_variant {
    ($of:expr, $values:ident => $result:expr) => {
        match $of {
            Self::Triangle($values) => $result,
            Self::Quadbox($values) => $result,
            Self::Euclidean($values) => $result,
            Self::Angular($values) => $result,
        }
    };
}

/// The methods that jobs and outcomes share: each variant has the ports of its operation.
macro_rules! by_kind {
    ($type:ident[$($n:ident),*], $number:expr, $bits:expr) => {
        impl<$(const $n: usize,)* C: Concrete> $type<$($n,)* C> {
            /// The operation.
            pub fn kind(&self) -> JobKind {
                match self {
                    Self::Triangle(_) => JobKind::Triangle,
                    Self::Quadbox(_) => JobKind::Quadbox,
                    Self::Euclidean(_) => JobKind::Euclidean,
                    Self::Angular(_) => JobKind::Angular,
                }
            }

            /// The values of the operation's ports, with names. The opcode is not among them.
            pub fn ports(&self) -> Vec<PortValue> {
                let mut words = Vec::new();
                self.words(&mut words);
                let ports = <$type<$($n),*>>::shape(self.kind()).into_iter().zip(words);
                ports.map(|(Port { name, kind, .. }, bits)| PortValue { name, kind, bits }).collect()
            }

            /// Replaces the contents of `words` by the port values, in the order of [`ports`](Self::ports).
            pub fn words(&self, words: &mut Vec<u64>) {
                words.clear();
                let (path, sink) = (&mut Path::unnamed(), &mut ToWords::new(words, $bits));
                each_variant!(self, values => values.each(path, sink));
            }

            /// The value with these [`words`](Self::words). Missing words are 0, and bits beyond a port's width are
            /// ignored.
            pub fn from_words_in(circuit: C, kind: JobKind, words: &[u64]) -> Self {
                Self::build(kind, &mut Path::unnamed(), &mut FromWords::new(circuit, words, $number))
            }

            /// The value with the port values that `port` returns by name.
            pub fn from_ports_in(circuit: C, kind: JobKind, mut port: impl FnMut(&str) -> u64) -> Self {
                let words: Vec<u64> = <$type<$($n),*>>::shape(kind).iter().map(|of| port(&of.name)).collect();
                Self::from_words_in(circuit, kind, &words)
            }

            fn build<S: Source<C>>(kind: JobKind, path: &mut Path, source: &mut S) -> Self {
                match kind {
                    JobKind::Triangle => Self::Triangle(Bundle::build(path, source)),
                    JobKind::Quadbox => Self::Quadbox(Bundle::build(path, source)),
                    JobKind::Euclidean => Self::Euclidean(Bundle::build(path, source)),
                    JobKind::Angular => Self::Angular(Bundle::build(path, source)),
                }
            }
        }

        impl<$(const $n: usize),*> $type<$($n),*> {
            /// The value in binary32 with the port values that `port` returns by name.
            pub fn from_ports(kind: JobKind, port: impl FnMut(&str) -> u64) -> Self {
                Self::from_ports_in(Binary32, kind, port)
            }

            fn shape(kind: JobKind) -> Vec<Port> {
                let mut shapes = Shapes(Vec::new());
                Self::build(kind, &mut Path::default(), &mut shapes);
                shapes.0
            }
        }
    };
}

// A job's numbers reach the ports as they are, NaN payloads included; an outcome's NaN is the canonical one.
by_kind!(Job[E, A], Concrete::number, Concrete::raw_bits);
by_kind!(Outcome[], canonical, Concrete::bits);
