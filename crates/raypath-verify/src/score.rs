//! The score of a sample of faults: how many a test finds.

/// A sample of faults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// All of them.
    pub faults: usize,
    /// Those that were found.
    pub killed: usize,
    /// Those that are proven to change nothing.
    pub equivalent: usize,
}

impl Count {
    /// The others.
    pub fn survivors(self) -> usize {
        self.faults - self.killed - self.equivalent
    }

    /// The killed part of the faults that are not proven equivalent, in hundredths of a percent, rounded down.
    pub fn score(self) -> usize {
        (self.killed * 10_000).checked_div(self.faults - self.equivalent).unwrap_or(10_000)
    }

    /// The 95 % confidence interval of the killed part of those that are not proven equivalent (Wilson 1927): as if the
    /// sample were drawn at random from all faults. Small modules have a larger part of the sample than of the faults.
    pub fn interval(self) -> [f64; 2] {
        const Z: f64 = 1.959_964;
        let n = (self.faults - self.equivalent) as f64;
        if n == 0.0 {
            return [0.0, 1.0];
        }
        let killed = self.killed as f64 / n;
        let centre = killed + Z * Z / (2.0 * n);
        let half = Z * (killed * (1.0 - killed) / n + Z * Z / (4.0 * n * n)).sqrt();
        [centre - half, centre + half].map(|bound| bound / (1.0 + Z * Z / n))
    }
}

/// The lowest score that passes, in hundredths of a percent.
pub const MIN_SCORE: usize = 9_900;

/// Hundredths of a percent in words.
pub fn percent(hundredths: usize) -> String {
    format!("{}.{:02} %", hundredths / 100, hundredths % 100)
}
