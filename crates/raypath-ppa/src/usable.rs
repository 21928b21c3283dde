//! Which cells of a library a measurement can use: allowed cells with safe names and valid numbers.

use crate::liberty::Group;

/// Parts of the names of cells that synthesis must not choose, in libraries that do not mark them (`dont_use : true`):
/// sky130 contains cells for power gating and for probes.
const EXCLUDED: [&str; 2] = ["__lpflow_", "__probe"];

/// The range of areas and capacitances, in any unit.
pub const NUMBERS: std::ops::RangeInclusive<f64> = 0.0..=1e12;

/// Whether a measurement may use a cell.
pub fn is_usable(cell: &Group<'_>) -> bool {
    let marked = cell.attribute("dont_use") == Some("true") || EXCLUDED.iter().any(|part| cell.name().contains(part));
    !marked && is_name(cell.name()) && cell.of_kind("pin").all(|pin| is_name(pin.name()))
}

/// Whether a name is an identifier. Names of cells and pins go into scripts for Yosys and OpenSTA, where brackets,
/// dollars, semicolons and line ends would be commands.
fn is_name(name: &str) -> bool {
    let first = name.bytes().next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == b'_')
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// Describes a cell's area, or a pin's capacitance, that is not a valid number. None if all are valid.
pub fn invalid_number(cell: &Group<'_>) -> Option<String> {
    let is_number = |text: &str| text.parse().is_ok_and(|number| NUMBERS.contains(&number));
    let wrong = |group: &Group<'_>, attribute| {
        let text = group.attribute(attribute).filter(|text| !is_number(text))?;
        Some(format!("{attribute} '{}' in cell {}", shortened(text), cell.name()))
    };
    wrong(cell, "area").or_else(|| cell.of_kind("pin").find_map(|pin| wrong(pin, "capacitance")))
}

/// The first 40 characters of a text from a file, escaped for a message.
fn shortened(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}
