use super::Row;
use raypath_float::Format;
use raypath_rtl::report::tables;

/// The rows as a table in Markdown. Columns `a` compare with binary64 on the rounded inputs, `b` on the original ones.
pub fn table(rows: &[Row]) -> String {
    let mut header = ["format", "result", "compared", "hits"].map(String::from).to_vec();
    for reference in ["a", "b"] {
        header.extend(["differ", "50 %", "99 %", "max"].map(|column| format!("{reference} {column}")));
    }
    header.push("no number".to_string());
    let rows = rows.iter().map(|row| {
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
        cells
    });
    tables::table(header, rows).to_string()
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

/// The differences of results in a format from references in binary64.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Errors {
    /// Results compared.
    pub results: usize,
    /// References that are a hit; a sum always is one.
    pub hits: usize,
    /// Results that are a hit where the reference is a miss, or a miss where it is a hit.
    pub disagreements: usize,
    /// Results that are infinite or NaN where the reference is a number.
    pub not_finite: usize,
    /// The errors of all other hits, in ulps.
    ulps: Vec<f64>,
}

/// Quantiles of errors, in ulps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiles {
    /// The bound of half of the errors.
    pub median: f64,
    /// The bound of 99 % of the errors.
    pub percentile_99: f64,
    /// The largest error.
    pub max: f64,
}

impl Errors {
    /// Compares a result with its reference; `None` is a miss. The error is in ulps of the format at the reference.
    pub fn add(&mut self, format: Format, result: Option<f64>, reference: Option<f64>) {
        self.results += 1;
        self.hits += usize::from(reference.is_some());
        self.disagreements += usize::from(reference.is_some() != result.is_some());
        if let (Some(result), Some(reference)) = (result, reference)
            && reference.is_finite()
        {
            if result.is_finite() {
                self.ulps.push((result - reference).abs() / format.ulp(reference));
            } else {
                self.not_finite += 1;
            }
        }
    }

    /// Median, 99th percentile and maximum of the errors, each the error of a result. None if there are no errors.
    pub fn quantiles(&self) -> Option<Quantiles> {
        let mut ulps = self.ulps.clone();
        ulps.sort_by(f64::total_cmp);
        let at = |percent: usize| ulps.get((ulps.len() * percent).div_ceil(100).checked_sub(1)?).copied();
        Some(Quantiles { median: at(50)?, percentile_99: at(99)?, max: at(100)? })
    }
}
