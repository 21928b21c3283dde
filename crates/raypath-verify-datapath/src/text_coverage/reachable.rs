//! Coverage points that cannot be reached, each with a proof from the text.

use raypath_hdl::verilog::Source;
use raypath_tools::{CoverageKind, CoveragePoint};
use std::collections::{BTreeMap, BTreeSet};

/// The text of a design, by module.
pub struct Text {
    modules: BTreeMap<String, Vec<String>>,
    /// The values of the package's enumerations, such as `2'd1`.
    values: BTreeMap<String, String>,
}

impl Text {
    pub fn new(sources: &[Source]) -> Self {
        let modules: BTreeMap<String, Vec<String>> = sources
            .iter()
            .map(|source| (source.name.clone(), source.text.lines().map(str::to_string).collect()))
            .collect();
        let lines = modules.values().flatten();
        let values = lines.filter_map(|line| {
            let (name, value) = line.trim().trim_end_matches(',').split_once('=')?;
            Some((name.trim().to_string(), value.trim().to_string())).filter(|(_, value)| literal(value).is_some())
        });
        let values = values.collect();
        Self { modules, values }
    }

    /// Whether a point is the `default` of a `case` that has an arm for each value of its selector. Languages and
    /// linters want that arm.
    pub fn is_default_of_complete_case(&self, point: &CoveragePoint) -> bool {
        let lines = self.modules.get(&point.module);
        let before = lines.and_then(|lines| lines.get(..point.line)).unwrap_or_default();
        let Some((default, before)) = before.split_last() else { return false };
        if point.kind != CoverageKind::Line || !default.trim().starts_with("default:") {
            return false;
        }
        let arms = before.iter().rev().take_while(|line| !line.trim().starts_with("case ("));
        let labels = arms.filter_map(|line| line.split_once(": ")).filter(|(labels, _)| !labels.contains('='));
        let labels = labels.flat_map(|(labels, _)| labels.split(','));
        let values: Option<BTreeSet<(u32, u64)>> = labels.map(|label| self.value(label.trim())).collect();
        let Some(values) = values else { return false };
        values.first().is_some_and(|&(width, _)| {
            width < 16 && values.len() == 1 << width && values.iter().all(|&(other, _)| other == width)
        })
    }

    /// The signal whose value 1 keeps a point from being reached: that of the condition of an `if`, if the point is its
    /// other side.
    pub fn always<'t>(&'t self, point: &CoveragePoint) -> Option<&'t str> {
        let line = self.modules.get(&point.module)?.get(point.line.checked_sub(1)?)?.trim();
        let condition = line.trim_start_matches("end ").trim_start_matches("else ").strip_prefix("if (")?;
        let condition = condition.strip_suffix(") begin").or_else(|| Some(condition.split_once(") ")?.0))?;
        (point.kind == CoverageKind::Branch && point.name == "else").then_some(condition)
    }

    /// The width and the value of a label.
    fn value(&self, label: &str) -> Option<(u32, u64)> {
        let name = label.rsplit("::").next()?;
        literal(label).or_else(|| literal(self.values.get(name)?))
    }
}

/// Width and value of a literal such as `2'd1`.
fn literal(text: &str) -> Option<(u32, u64)> {
    let (width, digits) = text.split_once('\'')?;
    let (base, digits) = digits.split_at_checked(1)?;
    let base = match base {
        "b" => 2,
        "d" => 10,
        "h" => 16,
        _ => return None,
    };
    let digits = digits.trim_end_matches(';').replace('_', "");
    Some((width.parse().ok()?, u64::from_str_radix(&digits, base).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACKAGE: &str =
        "package p;\n  typedef enum logic [0:0] {\n    OpA = 1'd0,\n    OpB = 1'd1\n  } op_e;\nendpackage\n";

    /// Whether the `default` of a module with these arms is out of reach.
    fn is_out_of_reach(arms: &[&str]) -> bool {
        let arms: Vec<String> = arms.iter().map(|arm| format!("      {arm}\n")).collect();
        let text =
            format!("module m;\n  always_comb begin\n    case (s)\n{}      default: x = b ? a : c;\n", arms.concat());
        let sources = [("p", PACKAGE.to_string()), ("m", text.clone())]
            .map(|(name, text)| Source { name: name.to_string(), text });
        let line = text.lines().count();
        let point = |kind, line| CoveragePoint { kind, module: "m".to_string(), line, name: String::new(), hits: 0 };
        let text = Text::new(&sources);
        assert!(!text.is_default_of_complete_case(&point(CoverageKind::Line, line - 1)));
        assert!(!text.is_default_of_complete_case(&point(CoverageKind::Branch, line)));
        text.is_default_of_complete_case(&point(CoverageKind::Line, line))
    }

    #[test]
    fn the_other_side_of_an_if_has_its_condition() {
        let text =
            "module m;\n    if (!rst_ni) begin\n    end else if (load) begin\n    end\n    else if (more) a_q <= b;\n";
        let text = Text::new(&[Source { name: "m".to_string(), text: text.to_string() }]);
        let always = |kind, line, name: &str| {
            let point = CoveragePoint { kind, module: "m".to_string(), line, name: name.to_string(), hits: 0 };
            text.always(&point).map(str::to_string)
        };
        assert_eq!(always(CoverageKind::Branch, 3, "else").as_deref(), Some("load"));
        assert_eq!(always(CoverageKind::Branch, 2, "else").as_deref(), Some("!rst_ni"));
        assert_eq!(always(CoverageKind::Branch, 3, "if"), None);
        assert_eq!(always(CoverageKind::Line, 3, "else"), None);
        assert_eq!(always(CoverageKind::Branch, 4, "else"), None);
        assert_eq!(always(CoverageKind::Branch, 5, "else").as_deref(), Some("more"));
    }

    #[test]
    fn only_the_default_of_a_complete_case_is_out_of_reach() {
        assert!(is_out_of_reach(&["p::OpA: x = a ? b : c;", "p::OpB: begin", "  x = b;", "end"]));
        assert!(is_out_of_reach(&["p::OpA, p::OpB: x = a;"]));
        assert!(is_out_of_reach(&["2'd0, 2'd1: x = a;", "2'd2: x = b;", "2'd3: x = c;"]));
        assert!(!is_out_of_reach(&["p::OpA: x = a;"]));
        assert!(!is_out_of_reach(&["p::OpA: x = a;", "p::OpC: x = b;"]));
        assert!(!is_out_of_reach(&["2'd0, 2'd1: x = a;", "2'd2: x = b;"]));
        assert!(!is_out_of_reach(&["2'd0, 2'd1: x = a;", "2'd2, 1'd1: x = b;"]));
        assert!(!is_out_of_reach(&[]));
    }
}
