//! The operations against exact arithmetic. `docs/reference/error-bounds.md` derives the bounds.

mod aimed_rays;
mod box_intersection;
pub mod boxes;
mod campaign;
mod mesh;
mod outer_boxes;
mod pipeline;
mod shapes;
pub mod sums;
pub mod triangle_distances;
mod vector;
mod visibility;
pub mod watertight;
