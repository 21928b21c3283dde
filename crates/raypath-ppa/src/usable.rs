//! What of a cell library can be used: cells that may be chosen, names that are harmless, numbers that are numbers.

use crate::liberty::Group;

/// Cells that no synthesiser should take on its own, where the library does not say so itself (`dont_use : true`):
/// sky130 has cells for power gating and for probes among the others.
const NEVER_USED: [&str; 2] = ["__lpflow_", "__probe"];

/// Areas and capacitances, in whatever unit.
pub const NUMBERS: std::ops::RangeInclusive<f64> = 0.0..=1e12;

/// Whether a measurement may use a cell.
pub fn is_used(cell: &Group<'_>) -> bool {
    let marked = cell.attribute("dont_use") == Some("true") || NEVER_USED.iter().any(|part| cell.name().contains(part));
    !marked && is_name(cell.name()) && cell.of_kind("pin").all(|pin| is_name(pin.name()))
}

/// A name that is one everywhere. Cells and pins stand by theirs in scripts of Yosys and OpenSTA, where brackets, dollars,
/// semicolons or a line's end would be commands.
fn is_name(name: &str) -> bool {
    let first = name.bytes().next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == b'_')
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// A cell's area, or the capacitance of one of its pins, that is no number, in words.
pub fn no_number(cell: &Group<'_>) -> Option<String> {
    let is_number = |text: &str| text.parse().is_ok_and(|number| NUMBERS.contains(&number));
    let wrong = |group: &Group<'_>, attribute| {
        let text = group.attribute(attribute).filter(|text| !is_number(text))?;
        Some(format!("{attribute} '{}' in cell {}", shortened(text), cell.name()))
    };
    wrong(cell, "area").or_else(|| cell.of_kind("pin").find_map(|pin| wrong(pin, "capacitance")))
}

/// The beginning of a text that somebody else wrote, fit for a message.
fn shortened(text: &str) -> String {
    text.chars().take(40).flat_map(char::escape_debug).collect()
}
