//! The specifications of the added operations.

use crate::AnyOperationSpec;
use raypath_ops::operations::key_compare::KeyCompare;
use raypath_ops::operations::octbox::Octbox;
use raypath_ops::operations::point_in_box::PointInBox;
use raypath_ops::operations::quantised_box::QuantisedBox;
use raypath_ops::operations::sphere::Sphere;
use raypath_rtl::alternatives;

/// The specifications of all added operations, in the order of [`raypath_ops::operations::NAMES`].
pub fn added_operations() -> Vec<AnyOperationSpec> {
    vec![
        AnyOperationSpec::known(KeyCompare, "a key against 36 separators: nodes of B-trees"),
        AnyOperationSpec::known(Octbox, "a ray against eight boxes a job"),
        AnyOperationSpec::known(PointInBox, "a point against four boxes: range search, point location"),
        AnyOperationSpec::known(QuantisedBox, "a ray against four boxes of 8 bits a bound: compressed wide nodes"),
        AnyOperationSpec::known(Sphere, "a ray against a sphere: particles, hair, bounding spheres"),
    ]
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
