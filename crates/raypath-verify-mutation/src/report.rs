//! The fates of faults, and the verdict about a sample of them.

use raypath_verify::{Error, Level, Request, Verdict, files};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// The part of the faults that are not proven equivalent that a test must kill.
const CLAIM: f64 = 0.98;

/// What became of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// This check failed.
    Killed(String),
    /// No check failed, and this proof shows that the fault changes nothing.
    Equivalent(String),
    /// No check failed, and the proof had this result.
    Survived(String),
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Killed(check) => write!(f, "killed by {check}"),
            Self::Equivalent(proof) => write!(f, "equivalent, {proof}"),
            Self::Survived(why) => write!(f, "survived, {why}"),
        }
    }
}

/// A fault with its subject, a module or an operation, and its fate.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Judged {
    pub subject: String,
    pub fault: String,
    pub fate: Fate,
}

/// A sample of faults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    pub killed: usize,
    pub equivalent: usize,
    pub survived: usize,
}

impl Count {
    /// The killed part of those that are not proven equivalent, and its 95 % confidence interval (Wilson 1927): as if
    /// the sample were drawn at random from all faults. Small modules have a larger part of the sample than of the
    /// faults.
    pub fn score(self) -> [f64; 3] {
        const Z: f64 = 1.959_964;
        let n = (self.killed + self.survived) as f64;
        if n == 0.0 {
            return [1.0, 0.0, 1.0];
        }
        let killed = self.killed as f64 / n;
        let centre = killed + Z * Z / (2.0 * n);
        let half = Z * (killed * (1.0 - killed) / n + Z * Z / (4.0 * n * n)).sqrt();
        let [low, high] = [centre - half, centre + half].map(|bound| bound / (1.0 + Z * Z / n));
        [killed, low, high]
    }
}

/// The judged faults of a sample.
#[derive(Debug, Default)]
pub struct Report {
    pub judged: Vec<Judged>,
    /// The number of faults from which the sample is drawn, and what has them.
    pub population: (usize, String),
    pub is_stopped: bool,
}

impl Report {
    pub fn count(&self) -> Count {
        let mut count = Count::default();
        for judged in &self.judged {
            *match judged.fate {
                Fate::Killed(_) => &mut count.killed,
                Fate::Equivalent(_) => &mut count.equivalent,
                Fate::Survived(_) => &mut count.survived,
            } += 1;
        }
        count
    }

    /// The verdict, after a list of the fates is written to a file. The lower end of the interval must reach the claim. At
    /// level regression, whose sample is small, the upper end must: a sample of a sound population then seldom fails. A
    /// part of the work has no score of its own.
    ///
    /// # Errors
    /// The list cannot be written.
    pub fn verdict(mut self, request: &Request<'_>, list: &str) -> Result<Verdict, Error> {
        self.judged.sort_by(|a, b| (&a.subject, &a.fault).cmp(&(&b.subject, &b.fault)));
        let lines = self.judged.iter().map(|Judged { subject, fault, fate }| format!("{fate:32} {subject}: {fault}\n"));
        files::write(Path::new(list), &lines.collect::<String>())?;
        let count @ Count { killed, equivalent, survived } = self.count();
        let [score, low, high] = count.score().map(|part| format!("{:.2} %", 100.0 * part));
        let (population, of) = &self.population;
        let covered = format!(
            "a sample of {} of the {population} faults in {of}: {killed} killed, {equivalent} proven equivalent, \
             {survived} survivors; {score} killed of those not proven equivalent, 95 % confidence interval {low} to \
             {high}",
            self.judged.len(),
        );
        let mut verdict = Verdict { covered, is_stopped: self.is_stopped, ..Verdict::default() };
        let mut checks: BTreeMap<&str, usize> = BTreeMap::new();
        for Judged { subject, fault, fate } in &self.judged {
            match fate {
                Fate::Killed(by) | Fate::Equivalent(by) => *checks.entry(by).or_default() += 1,
                Fate::Survived(why) => verdict.remarks.push(format!("survivor: {subject}: {fault}; {why}")),
            }
        }
        let checks: Vec<String> = checks.iter().map(|(check, count)| format!("{check}: {count}")).collect();
        verdict.remarks.push(format!("decided by {}; each fault: {list}", checks.join("; ")));
        let [_, least, greatest] = count.score();
        let is_low = match request.level {
            Level::Regression => greatest < CLAIM,
            Level::Full | Level::Long => least < CLAIM,
        };
        if is_low && !self.is_stopped && !request.parts.is_saved() {
            verdict.failures.push(format!(
                "{survived} survivors, and {score} of the faults are killed, {low} to {high}, expected at least {} %",
                100.0 * CLAIM
            ));
        }
        Ok(verdict)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interval of 2,346 killed of 2,359, and its limits.
    #[test]
    fn the_interval_is_wilsons() {
        let near = |killed, survived, expected: [f64; 2]| {
            let [_, low, high] = Count { killed, survived, equivalent: 82 }.score();
            assert!((low - expected[0]).abs() < 5e-5 && (high - expected[1]).abs() < 5e-5, "{low} to {high}");
        };
        near(2346, 13, [0.9906, 0.9968]);
        near(10, 0, [0.7225, 1.0]);
        near(0, 10, [0.0, 0.2775]);
        near(0, 0, [0.0, 1.0]);
    }

    /// A sample with a good score is not enough if its interval reaches below the claim.
    #[test]
    fn the_end_of_the_interval_decides() {
        let fate = |number: usize, survived: usize| match number < survived {
            true => Fate::Survived(String::new()),
            false => Fate::Killed("a check".to_string()),
        };
        let fails = |level, all: usize, survived: usize| {
            let judged = |number| Judged { subject: String::new(), fault: String::new(), fate: fate(number, survived) };
            let report = Report { judged: (0..all).map(judged).collect(), ..Report::default() };
            let mut watch = |_| true;
            let request = Request { level, ..Request::new(&mut watch) };
            let list = std::env::temp_dir().join(format!("raypath-fates-{}", std::process::id()));
            let verdict = report.verdict(&request, &list.to_string_lossy()).expect("a verdict");
            assert_eq!(verdict.remarks.iter().filter(|remark| remark.starts_with("survivor: ")).count(), survived);
            !verdict.failures.is_empty()
        };
        assert!(!fails(Level::Full, 2400, 20) && fails(Level::Full, 2400, 40) && fails(Level::Full, 120, 0));
        assert!(!fails(Level::Regression, 10, 1) && fails(Level::Regression, 12, 2));
        assert!(!fails(Level::Regression, 160, 5) && fails(Level::Regression, 160, 8));
    }
}
