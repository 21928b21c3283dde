//! Stimulus and oracle of each added operation.

pub mod key_compare;
pub mod octbox;
pub mod point_in_box;
pub mod quantised_box;
pub mod sphere;

use crate::AnyOperationSpec;
use raypath_rtl::alternatives;

/// The specifications of all added operations, in the order of [`raypath_ops::operations::NAMES`].
pub fn added_operations() -> Vec<AnyOperationSpec> {
    vec![key_compare::spec(), octbox::spec(), point_in_box::spec(), quantised_box::spec(), sphere::spec()]
}

/// The specification of the added operation of this name.
///
/// # Errors
/// Another name; the message lists the names that were expected.
pub fn added_operation(name: &str) -> Result<AnyOperationSpec, String> {
    let all = added_operations();
    let names: Vec<&str> = all.iter().map(AnyOperationSpec::name).collect();
    let expected = format!("expected {}", alternatives(&names));
    all.into_iter().find(|spec| spec.name() == name).ok_or(expected)
}
