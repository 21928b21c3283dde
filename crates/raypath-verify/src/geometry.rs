//! The operations against exact arithmetic. `docs/reference/error-bounds.md` derives the bounds.

mod aimed_rays;
mod box_cases;
mod box_intersection;
mod boxes;
mod campaign;
mod dyadic;
mod implementations;
mod mesh;
mod shapes;
mod sums;
mod triangle_distances;
mod vector;
mod visibility;
mod watertight;

use crate::verdict::Item;

/// The sources that each result of this module depends on.
const SUBJECT: &[&str] = &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"];

/// Ray against triangle: no ray passes between adjacent faces.
pub const WATERTIGHT: Item = Item {
    name: "watertight",
    claim: "a ray through an edge or vertex shared by faces that all face the ray hits at least one of them",
    oracle: "which faces face the ray, and where it passes them, by exact arithmetic",
    subject: SUBJECT,
    run: watertight::verify,
};

/// Ray against box.
pub const BOXES: Item = Item {
    name: "boxes",
    claim: "a ray that crosses a box by more than the rounding bound hits it, a ray that misses it by more does not, \
            and tmin has an error of at most three roundings",
    oracle: "exact arithmetic on integers times powers of two",
    subject: SUBJECT,
    run: boxes::verify,
};

/// Ray against triangle: the distance of the intersection.
pub const TRIANGLE_DISTANCE: Item = Item {
    name: "triangle-distance",
    claim: "t_num, t_denom and, for hits, their quotient have errors within the bounds of \
            docs/reference/error-bounds.md",
    oracle: "exact arithmetic on integers times powers of two",
    subject: SUBJECT,
    run: triangle_distances::verify,
};

/// Distances between vectors.
pub const SUMS: Item = Item {
    name: "sums",
    claim: "Euclidean sums, dot products and norms have errors within the bounds of docs/reference/error-bounds.md",
    oracle: "exact arithmetic on integers times powers of two",
    subject: SUBJECT,
    run: sums::verify,
};
