//! Columns and line breaks.

/// The longest line that is not broken.
const COLUMNS: usize = 100;

/// A line of comment.
pub fn comment(text: &str) -> String {
    format!("// {}", text.replace(['\n', '\r'], " ")).trim_end().to_string()
}

/// A comment at a line's end.
pub fn remark(text: &str) -> String {
    format!(" {}", comment(text))
}

/// The comment over a section.
pub fn title(text: &str) -> String {
    format!("  {:-<78}", comment(&format!("---- {text}")) + " ").trim_end().to_string()
}

/// The packed dimension of a word; nothing for a single bit.
pub fn range(width: u32) -> String {
    if width == 1 { String::new() } else { format!("[{}:0]", width - 1) }
}

/// Rows with their cells under each other. A column that is empty throughout takes no space.
pub fn table<const N: usize>(indent: &str, rows: &[[String; N]]) -> Vec<String> {
    let widths: [usize; N] = std::array::from_fn(|c| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0));
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).filter(|(_, width)| *width > 0);
        let text: Vec<String> = cells.map(|(cell, width)| format!("{cell:width$}")).collect();
        format!("{indent}{}", text.join(" ")).trim_end().to_string()
    };
    rows.iter().map(line).collect()
}

/// Breaks a line that is too long at spaces; what follows is indented by four more.
pub fn wrap(line: String) -> Vec<String> {
    let indent = line.len() - line.trim_start().len();
    let mut lines = Vec::new();
    let mut rest = line;
    while rest.len() > COLUMNS {
        let start = rest.len() - rest.trim_start().len();
        let within = rest[start..COLUMNS].rfind(' ').or_else(|| rest[start..].find(' '));
        let Some(at) = within else { break };
        let tail = format!("{:1$}{2}", "", indent + 4, rest[start + at..].trim_start());
        rest.truncate(start + at);
        lines.push(rest.trim_end().to_string());
        rest = tail;
    }
    lines.push(rest);
    lines
}
