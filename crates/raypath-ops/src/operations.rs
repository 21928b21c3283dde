//! Operations in addition to the paper's, one per file. A datapath has only those that are added to it.

pub mod key_compare;
pub mod octbox;
pub mod point_in_box;
pub mod quantised_box;
pub mod sphere;

use crate::Operation;

/// The names of all added operations.
pub const NAMES: [&str; 5] = [
    key_compare::KeyCompare::NAME,
    octbox::Octbox::NAME,
    point_in_box::PointInBox::NAME,
    quantised_box::QuantisedBox::NAME,
    sphere::Sphere::NAME,
];
