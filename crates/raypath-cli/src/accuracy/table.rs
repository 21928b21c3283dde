use super::{Quantiles, Row};
use raypath_rtl::report::tables::new_table;

/// The rows as a table in Markdown. Columns `a` compare with binary64 on the rounded inputs, columns `b` with binary64
/// on the original inputs.
pub fn table(rows: &[Row]) -> String {
    let mut table = new_table();
    let mut header = ["format", "result", "compared", "hits"].map(String::from).to_vec();
    for reference in ["a", "b"] {
        header.extend(["differ", "50 %", "99 %", "max"].map(|column| format!("{reference} {column}")));
    }
    header.push("no number".to_string());
    table.set_header(header);
    for row in rows {
        let hits_only = |cell: String| if row.quantity.may_miss() { cell } else { String::new() };
        let mut cells = vec![row.format.name(), row.quantity.to_string(), row.on_original.results.to_string()];
        cells.push(hits_only(row.on_original.hits.to_string()));
        for errors in [&row.on_rounded, &row.on_original] {
            cells.push(hits_only(share(errors.disagreements, errors.hits)));
            cells.extend(match errors.quantiles() {
                Some(Quantiles { median, percentile_99, max }) => [median, percentile_99, max].map(ulps),
                None => Default::default(),
            });
        }
        cells.push(row.on_original.not_finite.to_string());
        table.add_row(cells);
    }
    table.to_string()
}

/// A count and its share: `3, 0.12 %`; without a share if one of the numbers is 0.
fn share(count: usize, of: usize) -> String {
    if count == 0 || of == 0 {
        count.to_string()
    } else {
        format!("{count}, {:.2} %", 100.0 * count as f64 / of as f64)
    }
}

/// An error with two decimals, or two digits from a thousand ulps on.
fn ulps(error: f64) -> String {
    if error < 1000.0 { format!("{error:.2}") } else { format!("{error:.1e}") }
}
