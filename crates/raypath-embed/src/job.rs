//! Jobs and outcomes of a pipeline.

use crate::Error;
use crate::layout::{AngularResult, Bounds, EuclideanResult, QuadboxResult, Ray, TriangleResult, Vertices};
use raypath_model::{State, StateWords, state};
use raypath_ops::{self as ops, BeatInput, Binary32, Flags, Num};
use raypath_rtl::alternatives;
use raypath_sim::OperationId;
use std::mem::discriminant;

/// A job.
#[derive(Debug, Clone, Copy)]
pub enum Job<'j> {
    /// A ray against four boxes.
    Quadbox {
        /// The ray.
        ray: &'j Ray,
        /// The boxes.
        boxes: &'j [Bounds; 4],
    },
    /// A ray against a triangle.
    Triangle {
        /// The ray.
        ray: &'j Ray,
        /// The triangle.
        triangle: &'j Vertices,
    },
    /// A beat of a Euclidean distance, with as many coordinates as the datapath has lanes.
    Euclidean(Beat<'j>),
    /// A beat of an angular distance, with half as many coordinates as the datapath has lanes.
    Angular(Beat<'j>),
    /// A job of any operation: the words at its ports, with numbers in the layout of the datapath's format.
    Words {
        /// The operation's opcode.
        opcode: u64,
        /// A word for each input port.
        inputs: &'j [u64],
    },
    /// The time of a job without its values. Accumulators do not change.
    Timing {
        /// The operation's opcode.
        opcode: u64,
    },
}

/// A beat of a distance.
#[derive(Debug, Clone, Copy)]
pub struct Beat<'j> {
    /// The query's coordinates.
    pub a: &'j [f32],
    /// The candidate's coordinates.
    pub b: &'j [f32],
    /// Bit i says whether lane i counts.
    pub mask: u64,
    /// The sums restart at zero after this beat.
    pub reset_accum: bool,
}

/// The outcome of a job with the tag of its offer.
// The layout of C's `raypath_result`, so that an outcome is copied without a branch on its kind.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tagged {
    /// The tag of the offer.
    pub tag: u64,
    /// The outcome.
    pub outcome: Outcome,
}

/// The outcome of a job. The numbers are C's `RAYPATH_JOB_…`.
#[repr(C, i32)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Of a ray against a triangle.
    Triangle(TriangleResult) = 0,
    /// Of a ray against four boxes.
    Quadbox(QuadboxResult) = 1,
    /// Of a beat of a Euclidean distance.
    Euclidean(EuclideanResult) = 2,
    /// Of a beat of an angular distance.
    Angular(AngularResult) = 3,
    /// Of a job that was offered as words, by its opcode. The pipeline keeps the words.
    Words(u64) = 4,
    /// Of a job without values: its opcode.
    Timing(u64) = 5,
}

state! {
    TriangleResult { t_num, t_denom, triangle_hit }
    QuadboxResult { tmin, is_intersect, box_index }
    EuclideanResult { accumulator, reset_accum }
    AngularResult { dot_product, norm, reset_accum }
}

impl State for Outcome {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let kinds = [
            Self::Triangle(TriangleResult::default()),
            Self::Quadbox(QuadboxResult::default()),
            Self::Euclidean(EuclideanResult::default()),
            Self::Angular(AngularResult::default()),
            Self::Words(0),
            Self::Timing(0),
        ];
        let is_same = |other: &Self| discriminant(other) == discriminant(self);
        let before = kinds.iter().position(is_same).unwrap_or(0);
        let mut number = before;
        number.pass(words);
        match kinds.get(number) {
            Some(_) if number == before => {}
            Some(kind) => *self = *kind,
            None => return words.refuse(),
        }
        match self {
            Self::Triangle(result) => result.pass(words),
            Self::Quadbox(result) => result.pass(words),
            Self::Euclidean(result) => result.pass(words),
            Self::Angular(result) => result.pass(words),
            Self::Words(opcode) | Self::Timing(opcode) => opcode.pass(words),
        }
    }
}

impl<const N: usize> From<Beat<'_>> for BeatInput<Binary32, N> {
    /// Lanes without coordinates are 0.
    fn from(Beat { a, b, mask, reset_accum }: Beat<'_>) -> Self {
        let mask = Flags::from_mask(mask);
        Self { euclidean: ops::Beat { a: lanes(a), b: lanes(b), mask, reset_accum: reset_accum.into() } }
    }
}

/// Coordinates as lanes; those beyond the end are 0.
#[inline(always)]
pub(crate) fn lanes<const N: usize>(of: &[f32]) -> [Num<Binary32>; N] {
    match of.first_chunk() {
        Some(of) => copied(of),
        None => some_lanes(of),
    }
}

// A loop, because the compiler makes a few vector moves of it, and a call for each number of `array::map`.
#[inline(always)]
fn copied<const N: usize>(of: &[f32; N]) -> [Num<Binary32>; N] {
    let mut lanes = [0.0.into(); N];
    lanes.iter_mut().zip(of).for_each(|(lane, number)| *lane = (*number).into());
    lanes
}

#[cold]
fn some_lanes<const N: usize>(of: &[f32]) -> [Num<Binary32>; N] {
    std::array::from_fn(|lane| of.get(lane).copied().unwrap_or(0.0).into())
}

impl From<ops::Outcome> for Outcome {
    #[inline]
    fn from(outcome: ops::Outcome) -> Self {
        match outcome {
            ops::Outcome::Quadbox(output) => Self::Quadbox(output.into()),
            ops::Outcome::Triangle(output) => Self::Triangle(output.into()),
            ops::Outcome::Euclidean(output) => Self::Euclidean(output.into()),
            ops::Outcome::Angular(output) => Self::Angular(output.into()),
        }
    }
}

/// The operation with this opcode.
pub(crate) fn operation(operations: &[OperationId], opcode: u64) -> Result<OperationId, Error> {
    let found = operations.iter().copied().find(|found| found.opcode() == opcode);
    found.ok_or_else(|| no_operation(operations, &format!("opcode {opcode}")))
}

/// The error of a name or opcode that is not one of these operations.
#[cold]
pub(crate) fn no_operation(operations: &[OperationId], name: &str) -> Error {
    let names: Vec<&str> = operations.iter().map(|operation| operation.name()).collect();
    Error::Operation { name: name.to_string(), expected: alternatives(&names) }
}
