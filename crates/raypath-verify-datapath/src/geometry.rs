//! The operations against exact arithmetic. `docs/reference/error-bounds.md` derives the bounds.

pub mod boxes;
mod needles;
pub mod patches;
pub mod sums;
pub mod triangle_distances;
mod vector;
pub mod visibility;
pub mod watertight;
