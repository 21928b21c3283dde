//! Packages as text.

use super::head_comment;
use super::layout::{comment, table};
use crate::text::{Enumeration, Package, Structure};

/// The SystemVerilog text of a package. The lines of `banner` become its head comment, followed by the package's own.
pub fn print_package(package: &Package, banner: &[String]) -> String {
    let mut lines = head_comment(banner, &package.doc);
    lines.push(format!("package {};", package.name));
    lines.extend(package.enumerations.iter().flat_map(enumeration));
    lines.extend(package.structures.iter().flat_map(structure));
    lines.extend([String::new(), format!("endpackage : {}", package.name)]);
    lines.into_iter().map(|line| line + "\n").collect()
}

fn enumeration(enumeration: &Enumeration) -> Vec<String> {
    let width = enumeration.width;
    let last = enumeration.labels.len().saturating_sub(1);
    let row = |(place, label): (usize, &crate::Label)| {
        [label.name.clone(), format!("= {width}'d{}{}", label.value, if place < last { "," } else { "" })]
    };
    let kind = if width == 1 { "logic".to_string() } else { format!("logic [{}:0]", width - 1) };
    let mut lines = vec![String::new()];
    lines.extend(enumeration.doc.iter().flat_map(|doc| comment(doc)).map(|line| format!("  {line}")));
    lines.push(format!("  typedef enum {kind} {{"));
    lines.extend(table("    ", &enumeration.labels.iter().enumerate().map(row).collect::<Vec<_>>()));
    lines.push(format!("  }} {};", enumeration.name));
    lines
}

fn structure(structure: &Structure) -> Vec<String> {
    let mut lines = vec![String::new()];
    lines.extend(structure.doc.iter().flat_map(|doc| comment(doc)).map(|line| format!("  {line}")));
    lines.push("  typedef struct packed {".to_string());
    let rows: Vec<_> = structure.fields.iter().map(|(kind, name)| [kind.clone(), format!("{name};")]).collect();
    lines.extend(table("    ", &rows));
    lines.push(format!("  }} {};", structure.name));
    lines
}
