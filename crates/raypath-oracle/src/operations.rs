//! The specifications of the added operations.

use crate::AnyOperationSpec;
use raypath_ops::JobKind;
use raypath_ops::operations::NAMES;
use raypath_ops::operations::key_compare::KeyCompare;
use raypath_ops::operations::octbox::Octbox;
use raypath_ops::operations::point_in_box::PointInBox;
use raypath_ops::operations::quantised_box::QuantisedBox;
use raypath_ops::operations::sphere::Sphere;
use raypath_rtl::alternatives;
use std::sync::{PoisonError, RwLock};

/// The operations of the crates that this program is made of, besides raypath's own.
static OWN: RwLock<Vec<AnyOperationSpec>> = RwLock::new(Vec::new());

/// Adds an operation of one's own to [`added_operations`] in this process, so that commands and bindings find it by its
/// name.
///
/// # Errors
/// A name that an operation has.
pub fn add_operation(spec: impl Into<AnyOperationSpec>) -> Result<(), String> {
    let (spec, mut own) = (spec.into(), OWN.write().unwrap_or_else(PoisonError::into_inner));
    let names = NAMES.into_iter().chain(JobKind::ALL.map(JobKind::name)).chain(own.iter().map(AnyOperationSpec::name));
    if names.into_iter().any(|name| name == spec.name()) {
        return Err(format!("there is an operation '{}', expected another name", spec.name()));
    }
    own.push(spec);
    Ok(())
}

/// The specifications of all added operations, in the order of [`raypath_ops::operations::NAMES`], then those of
/// [`add_operation`].
pub fn added_operations() -> Vec<AnyOperationSpec> {
    let mut all = vec![
        AnyOperationSpec::known(KeyCompare, "a key against 36 separators: nodes of B-trees"),
        AnyOperationSpec::known(Octbox, "a ray against eight boxes a job"),
        AnyOperationSpec::known(PointInBox, "a point against four boxes: range search, point location"),
        AnyOperationSpec::known(QuantisedBox, "a ray against four boxes of 8 bits a bound: compressed wide nodes"),
        AnyOperationSpec::known(Sphere, "a ray against a sphere: particles, hair, bounding spheres"),
    ];
    all.extend_from_slice(&OWN.read().unwrap_or_else(PoisonError::into_inner));
    all
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
