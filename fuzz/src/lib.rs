//! The fuzz targets: each is a target of `raypath verify parsers`, by its name.

use raypath_verify::parsers::TARGETS;

/// Parses bytes with the target of this name. A panic is a finding.
pub fn parse(name: &str, bytes: &[u8]) {
    for target in TARGETS.iter().filter(|target| target.name == name) {
        (target.parse)(bytes);
    }
}
