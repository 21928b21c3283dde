use raypath_float::Format;

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
