//! The package `raypath_unit_pkg`: names of kinds, statuses and flags.

use crate::blocks::KINDS;
use crate::codes::Codes;
use crate::query::{instance_flags, ray_flags};
use crate::state::{answer, request, status};
use crate::step::UnitFeatures;
use raypath_hdl::Builder;
use raypath_hdl::text::{Enumeration, Package, Structure};
use std::sync::Arc;

/// The types, and the codes of each.
const TYPES: [(&str, Codes); 6] = [
    ("status_e", status::CODES),
    ("ray_flag_e", ray_flags::CODES),
    ("child_kind_e", KINDS),
    ("instance_flag_e", instance_flags::CODES),
    ("answer_e", answer::CODES),
    ("request_e", request::CODES),
];

/// Lets the text of a module refer to the package.
pub fn refer_to_package(m: &Builder, features: UnitFeatures) {
    m.package(&Arc::new(package(features, Vec::new())));
}

/// The package with these structures. Linters report a type that no module of the unit uses.
pub fn package(features: UnitFeatures, structures: Vec<Structure>) -> Package {
    let enumeration = |(name, codes): (&str, Codes)| {
        let labels: Vec<_> = codes.labels().collect();
        let greatest = labels.iter().map(|label| label.value).max().unwrap_or(1);
        Enumeration { name: name.to_string(), doc: Some(codes.doc.to_string()), width: greatest.ilog2() + 1, labels }
    };
    let has_instance_flags = features.instances && features.has_flags();
    let types = TYPES.into_iter().filter(|(name, _)| has_instance_flags || *name != "instance_flag_e");
    Package {
        name: "raypath_unit_pkg".to_string(),
        doc: vec!["Names of kinds, statuses and flags of the traversal unit.".to_string()],
        enumerations: types.map(enumeration).collect(),
        structures,
    }
}
