//! What is counted in a simulation: blocks executed and branches taken, by Verilator, and bits that changed.

use crate::ToolError;
use std::collections::BTreeMap;

/// What a coverage point counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CoverageKind {
    /// An arm of a `case`, or another block of statements, was executed.
    Line,
    /// A side of an `if` was taken.
    Branch,
    /// A bit of a signal changed, in either direction. Verilator does not count these here.
    Toggle,
}

impl CoverageKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Line, Self::Branch, Self::Toggle];

    /// The kind's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Branch => "branch",
            Self::Toggle => "toggle",
        }
    }
}

/// A coverage point of a module, with the sum of the counts of all instances.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoveragePoint {
    /// What it counts.
    pub kind: CoverageKind,
    /// The module's name.
    pub module: String,
    /// The line in the module's file, from 1; 0 for a bit.
    pub line: usize,
    /// The bit of a toggle, `num_q[3]`; otherwise "if", "else", "case" or "block".
    pub name: String,
    /// How often it was reached.
    pub hits: u64,
}

/// Reads what Verilator's `VerilatedCovContext::write` writes: for each point of each instance a line with fields, each
/// \x01, a key, \x02 and a value, and a count.
///
/// # Errors
/// A text of another form.
pub fn points(bytes: &[u8]) -> Result<Vec<CoveragePoint>, ToolError> {
    let text = String::from_utf8_lossy(bytes);
    let mut points: BTreeMap<Key, u64> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (key, hits) = point(line).ok_or_else(|| {
            ToolError::unexpected("Verilator's coverage", line.replace(['\x01', '\x02'], " "), "a coverage point")
        })?;
        *points.entry(key).or_default() += hits;
    }
    let point = |((kind, module, line, _, name), hits)| CoveragePoint { kind, module, line, name, hits };
    Ok(points.into_iter().map(point).collect())
}

/// Kind, module, line, column and name.
type Key = (CoverageKind, String, usize, usize, String);

fn point(line: &str) -> Option<(Key, u64)> {
    let (fields, hits) = line.strip_prefix("C '")?.rsplit_once("' ")?;
    let field = |key: &str| {
        let mut fields = fields.split('\x01').filter_map(|field| field.split_once('\x02'));
        fields.find(|(name, _)| *name == key).map(|(_, value)| value)
    };
    let (page, module) = field("page")?.split_once('/')?;
    let kind = CoverageKind::ALL.into_iter().find(|kind| page.strip_prefix("v_") == Some(kind.name()))?;
    // Instances with other parameters have names of their own for the module.
    let module = module.split("__").next()?.to_string();
    let key = (kind, module, field("l")?.parse().ok()?, field("n")?.parse().ok()?, field("o")?.to_string());
    Some((key, hits.trim().parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_instances_are_added() {
        let point = |instance: &str, name: &str, hits: u64| {
            let page = "v_line/m__W9";
            let fields = [("l", "12"), ("n", "3"), ("page", page), ("o", name), ("h", instance)];
            let fields: String = fields.iter().map(|(key, value)| format!("\x01{key}\x02{value}")).collect();
            format!("C '{fields}' {hits}\n")
        };
        let text = ["# x\n", &point("TOP.u_0", "case", 3), &point("TOP.u_1", "case", 4), &point("TOP", "block", 0)];
        let found: Vec<(String, u64)> =
            points(text.concat().as_bytes()).expect("points").into_iter().map(|it| (it.name, it.hits)).collect();
        assert_eq!(found, [("block".to_string(), 0), ("case".to_string(), 7)]);
        assert!(points(b"C 'nothing' 1").is_err() && points(b"nothing").is_err());
    }
}
