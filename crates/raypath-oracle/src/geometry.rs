//! Geometry without rounding: numbers that are integers times powers of two, and the intersection of a ray and a box.

mod box_intersection;
pub mod dyadic;

pub use box_intersection::{ExactIntersection, Fraction};
