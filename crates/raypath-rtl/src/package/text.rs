//! Lines of SystemVerilog.

use raypath_hdl::verilog::LICENSE;

/// The banner of a file, with the licence.
pub fn licensed(banner: &[String]) -> Vec<String> {
    std::iter::once(LICENSE.to_string()).chain(banner.iter().cloned()).collect()
}

/// The head comment of a YAML file: the licence and the lines of `banner`.
pub fn yaml_head(banner: &[String]) -> String {
    licensed(banner).iter().map(|line| format!("# {}\n", line.replace(['\n', '\r'], " "))).collect()
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
