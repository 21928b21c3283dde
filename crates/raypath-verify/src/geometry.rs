//! The operations against mathematics, with exact arithmetic as the judge. The bounds are derived in
//! `docs/reference/error-bounds.md`.

mod aim;
mod box_cases;
mod boxes;
mod campaign;
mod distances;
mod dyadic;
mod intersect;
mod mesh;
mod shapes;
mod sight;
mod slabs;
mod sums;
mod vector;
mod watertight;
mod wrong_distances;
mod wrong_sums;

use super::Item;

/// Ray against triangle: nothing slips between faces.
pub const WATERTIGHT: Item = Item {
    name: "watertight",
    claim: "no ray slips through an edge or vertex that is shared by faces which all look at it",
    oracle: "which faces look at a ray, and where it passes, by exact arithmetic",
    subject: &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"],
    run: watertight::verify,
};

/// Ray against box.
pub const BOXES: Item = Item {
    name: "boxes",
    claim: "a ray that enters a box by more than the rounding bound hits it, one that misses it by more does not, and \
            tmin is off by at most three roundings",
    oracle: "exact arithmetic on integers times powers of two",
    subject: &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"],
    run: boxes::verify,
};

/// Ray against triangle: the distance.
pub const TRIANGLE_DISTANCE: Item = Item {
    name: "triangle-distance",
    claim: "t_num, t_denom and, of a hit, their quotient are as near the exact ones as docs/reference/error-bounds.md says",
    oracle: "exact arithmetic on integers times powers of two",
    subject: &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"],
    run: distances::verify,
};

/// Distances between vectors.
pub const SUMS: Item = Item {
    name: "sums",
    claim: "Euclidean sums, dot products and norms are as near the exact ones as docs/reference/error-bounds.md says",
    oracle: "exact arithmetic on integers times powers of two",
    subject: &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"],
    run: sums::verify,
};
