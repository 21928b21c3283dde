//! What all fuzz targets are: one of `raypath verify parsers`, by its name.

use raypath::verify::parsers::TARGETS;

/// Reads bytes as a format. A panic is a finding.
pub fn parse(name: &str, bytes: &[u8]) {
    for target in TARGETS.iter().filter(|target| target.name == name) {
        (target.parse)(bytes);
    }
}
