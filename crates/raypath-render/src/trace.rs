//! Tracing rays: a machine for one ray, and a fast path for many.

mod batch;
mod traversal;

pub use batch::{Tracer, trace_any, trace_closest};
pub use traversal::Traversal;

use raypath_ops::Rules;
use std::iter::Sum;
use std::ops::{Add, AddAssign};

/// How rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tracing {
    /// The rules on the edges.
    pub rules: Rules,
    /// Whether triangles can be hit from behind too. The datapath sees counter-clockwise faces only, so each triangle is
    /// then a second job, with two of its vertices exchanged.
    pub two_sided: bool,
}

/// What a ray is traced for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// The closest hit; of several at the same distance, that of the triangle with the lowest index.
    Closest,
    /// Any hit: whether something is in the way. The ray ends with the first leaf in which it hits something.
    Any,
}

/// What a ray hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Which triangle of the mesh.
    pub triangle: u32,
    /// Whether from behind.
    pub from_behind: bool,
    /// The numerator of the distance, as the datapath gives it.
    pub t_num: f32,
    /// Its denominator.
    pub t_denom: f32,
    /// The distance in units of the direction's length, `t_num / t_denom`, rounded once.
    pub t: f32,
}

/// What tracing cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Jobs of four boxes.
    pub quadbox: u64,
    /// Triangle jobs from the front.
    pub triangle: u64,
    /// Triangle jobs from behind, the second of two-sided tracing.
    pub behind: u64,
    /// Nodes fetched from memory.
    pub nodes: u64,
    /// Leaves fetched from memory.
    pub leaves: u64,
}

impl Counts {
    /// All jobs.
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
