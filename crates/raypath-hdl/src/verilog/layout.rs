//! Columns and line breaks.

use crate::netlist::Module;
use crate::text::PAYLOAD;

/// The longest line.
pub const COLUMNS: usize = 100;

/// Lines of comment. A long text is broken at spaces and continues in the column after its last gap of two spaces.
pub fn comment(text: &str) -> Vec<String> {
    let text = text.replace(['\n', '\r'], " ");
    let hanging = text.trim_end().rfind("  ").map_or(0, |at| at + 2).min(COLUMNS / 2);
    break_line(format!("// {text}"), &format!("// {:hanging$}", ""))
}

/// A comment at a line's end.
pub fn remark(text: &str) -> String {
    format!(" // {}", text.replace(['\n', '\r'], " ")).trim_end().to_string()
}

/// The comment over a section.
pub fn title(text: &str) -> String {
    let text = format!("// ---- {}", text.replace(['\n', '\r'], " "));
    format!("  {:-<78}", text + " ").trim_end().to_string()
}

/// A number of bits, or the name of the parameter.
pub fn width_text(module: &Module, width: u32) -> String {
    if module.text().has_width_parameter && width == PAYLOAD { "Width".to_string() } else { width.to_string() }
}

/// The packed dimension of a word; nothing for a single bit.
pub fn range(module: &Module, width: u32) -> String {
    match width_text(module, width).as_str() {
        "1" => String::new(),
        "Width" => "[Width-1:0]".to_string(),
        _ => format!("[{}:0]", width - 1),
    }
}

/// The type of a word.
pub fn logic(module: &Module, width: u32) -> String {
    format!("logic {}", range(module, width)).trim_end().to_string()
}

/// Rows with aligned cells. An empty column takes no space.
pub fn table<const N: usize>(indent: &str, rows: &[[String; N]]) -> Vec<String> {
    let widths: [usize; N] = std::array::from_fn(|c| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0));
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).filter(|(_, width)| *width > 0);
        // Not by a width of `format!`, which is at most 65535.
        let padded = |(cell, width): (&String, usize)| cell.clone() + &" ".repeat(width - cell.chars().count());
        let text: Vec<String> = cells.map(padded).collect();
        format!("{indent}{}", text.join(" ")).trim_end().to_string()
    };
    rows.iter().map(line).collect()
}

/// Types and names in columns, each with a remark.
pub fn declarations(indent: &str, rows: &[(String, String, Option<String>)]) -> Vec<String> {
    each_declaration(indent, rows).concat()
}

/// The same, the lines of each row apart. A remark that does not fit beside its row is printed above it.
pub fn each_declaration(indent: &str, rows: &[(String, String, Option<String>)]) -> Vec<Vec<String>> {
    let cells: Vec<[String; 2]> = rows.iter().map(|(kind, name, _)| [kind.clone(), name.clone()]).collect();
    let lines = table(indent, &cells);
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let declaration =
        |(line, (.., note)): (String, &(_, _, Option<String>))| match note.as_ref().map(|note| remark(note)) {
            Some(note) if longest + 1 + note.chars().count() <= COLUMNS => vec![format!("{line:longest$} {note}")],
            Some(note) => {
                let note = note.trim_start().trim_start_matches("// ");
                let next = format!("{indent}// ");
                let above = comment(note).into_iter().flat_map(|line| break_line(format!("{indent}{line}"), &next));
                above.chain([line]).collect()
            }
            None => vec![line],
        };
    lines.into_iter().zip(rows).map(declaration).collect()
}

/// Breaks a line that is too long at spaces; what follows is indented by four more.
pub fn wrap(line: String) -> Vec<String> {
    let indent = line.len() - line.trim_start().len();
    break_line(line, &" ".repeat(indent + 4))
}

/// Breaks a line that is too long at spaces, not before the length of `next`, which begins each following line.
fn break_line(line: String, next: &str) -> Vec<String> {
    let from = next.len();
    let mut lines = Vec::new();
    let mut rest = line.trim_end().to_string();
    while rest.len() > COLUMNS {
        let last = rest.get(from..=COLUMNS).and_then(|within| within.rfind(' '));
        let Some(at) = last.or_else(|| rest.get(from..)?.find(' ')) else { break };
        let tail = format!("{next}{}", rest[from + at..].trim_start());
        rest.truncate(from + at);
        lines.push(rest.trim_end().to_string());
        rest = tail;
    }
    lines.push(rest);
    lines
}

/// Items in lines, each line as full as possible.
pub fn fill(indent: &str, items: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        match lines.last_mut().filter(|line| line.len() + 1 + item.len() <= COLUMNS) {
            Some(line) => {
                line.push(' ');
                line.push_str(item);
            }
            None => lines.push(format!("{indent}{item}")),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn a_cell_may_be_longer_than_a_width_of_format() {
        let long = "x".repeat(1 << 16);
        let rows = [["a".to_string(), long.clone()], ["bb".to_string(), "y".to_string()]];
        assert_eq!(table("  ", &rows), [format!("  a  {long}"), "  bb y".to_string()]);
    }
}
