//! Stimulus and oracle of each added operation.

pub mod key_compare;
pub mod octbox;
pub mod point_in_box;
pub mod quantised_box;
pub mod sphere;

use crate::AnyOperationSpec;

/// The specifications of all added operations, in the order of [`raypath_ops::operations::NAMES`].
pub fn added_operations() -> Vec<AnyOperationSpec> {
    vec![key_compare::spec(), octbox::spec(), point_in_box::spec(), quantised_box::spec(), sphere::spec()]
}
