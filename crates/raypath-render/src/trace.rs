//! Tracing of rays: the traversal of one ray as a state machine, and the tracing of many rays in parallel.

mod tracer;
mod traversal;

pub use tracer::{Tracer, trace_any, trace_closest};
pub use traversal::Traversal;

use raypath_ops::Rules;
use raypath_traversal::state::status;
use std::iter::Sum;
use std::ops::{Add, AddAssign};
use thiserror::Error;

/// Options of tracing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tracing {
    /// The rules of the box and triangle tests at their edges.
    pub rules: Rules,
    /// Whether rays can hit triangles from behind. The datapath tests counter-clockwise faces only, so this takes a
    /// second job for each triangle, with two vertices exchanged.
    pub two_sided: bool,
}

/// The hit that a ray looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// The closest hit; of several at the same distance, the triangle with the lowest index.
    Closest,
    /// Any hit, as for shadow rays. Traversal ends after the first leaf with a hit.
    Any,
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The index of the triangle in the mesh.
    pub triangle: u32,
    /// Whether the ray hits the back of the triangle.
    pub from_behind: bool,
    /// The numerator of the distance from the datapath.
    pub t_num: f32,
    /// The denominator of the distance from the datapath.
    pub t_denom: f32,
    /// The distance `t_num / t_denom`, rounded to binary32, in units of the direction's length.
    pub t: f32,
    /// The number of the instance, in a scene with instances.
    pub instance: Option<u32>,
}

/// The jobs and fetches of tracing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Box jobs, of four boxes each.
    pub quadbox: u64,
    /// Jobs for the fronts of triangles.
    pub triangle: u64,
    /// Jobs for the backs of triangles, in two-sided tracing.
    pub behind: u64,
    /// Fetches of nodes.
    pub nodes: u64,
    /// Fetches of leaves.
    pub leaves: u64,
    /// Rays that the traversal unit ended with an error.
    pub errors: UnitErrors,
}

/// Rays that the traversal unit ended with an error, by status: what they hit is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Error)]
#[error(
    "what {} rays hit is not known: the traversal unit ended {failed} with an error (an instance makes the direction \
     too short to invert, or the ray visits more than 2^24 nodes or triangles) and refused {refused}",
    failed + refused
)]
pub struct UnitErrors {
    /// Refused: the direction cannot be inverted, or a value is not finite.
    pub refused: u64,
    /// An instance makes the direction too short to invert, the memory reported an error, or the scene is not a tree
    /// that the unit reads.
    pub failed: u64,
}

/// The reason why rays were not traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum TraceError {
    /// The progress callback returned false.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The traversal unit ended rays with an error.
    #[error(transparent)]
    Unit(#[from] UnitErrors),
}

/// The error of work that its progress callback stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("stopped")]
pub struct Stopped;

impl UnitErrors {
    /// The error of a ray that ends with this status, if it is one.
    pub(crate) fn of(status: u32) -> Self {
        Self { refused: (status == status::REFUSED).into(), failed: (status >= status::MEMORY).into() }
    }

    /// These and others.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { refused: self.refused + other.refused, failed: self.failed + other.failed }
    }

    /// An error if there are any.
    pub(crate) fn check(self) -> Result<(), Self> {
        if self == Self::default() { Ok(()) } else { Err(self) }
    }
}

impl Counts {
    /// The number of all jobs.
    pub fn jobs(&self) -> u64 {
        self.quadbox + self.triangle + self.behind
    }
}

impl Add for Counts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            quadbox: self.quadbox + other.quadbox,
            triangle: self.triangle + other.triangle,
            behind: self.behind + other.behind,
            nodes: self.nodes + other.nodes,
            leaves: self.leaves + other.leaves,
            errors: self.errors.and(other.errors),
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), Self::add)
    }
}
