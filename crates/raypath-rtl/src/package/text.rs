//! Lines of SystemVerilog.

use raypath_hdl::verilog::LICENSE;

/// The banner of a file, with the licence.
pub fn licensed(banner: &[String]) -> Vec<String> {
    std::iter::once(LICENSE.to_string()).chain(banner.iter().cloned()).collect()
}

/// A comment at the head of a file: the licence, the lines of `banner`, then those of `doc`. `mark` begins a comment.
pub fn head(mark: &str, banner: &[String], doc: &[String]) -> String {
    let banner = licensed(banner);
    let gap = (!banner.is_empty() && !doc.is_empty()).then(String::new);
    let lines = banner.iter().cloned().chain(gap).chain(doc.iter().cloned());
    lines.map(|line| format!("{mark} {}", line.replace(['\n', '\r'], " ")).trim_end().to_string() + "\n").collect()
}

/// The type of a word of `width` bits.
pub fn packed(width: u32) -> String {
    if width == 1 { "logic".to_string() } else { format!("logic [{}:0]", width - 1) }
}

/// Rows of two aligned columns.
pub fn columns(indent: &str, rows: &[(String, String)]) -> Vec<String> {
    let width = rows.iter().map(|(first, _)| first.len()).max().unwrap_or(0);
    rows.iter().map(|(first, second)| format!("{indent}{first:width$} {second}")).collect()
}
