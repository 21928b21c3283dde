//! What became of the mutants, in numbers and in words.

use super::explained::reason;
use super::sample::Subject;
use super::{Fate, Mutant};
use crate::error::Error;
use crate::files;
use crate::verdict::Verdict;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// The mutants judged so far.
pub struct Report<'s> {
    subjects: &'s [Subject],
    total: usize,
    judged: Vec<Judged>,
}

struct Judged {
    module: String,
    config: String,
    fault: String,
    fate: Fate,
}

/// How many mutants had which fate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    pub faults: usize,
    pub killed: usize,
    pub equivalent: usize,
}

impl Count {
    pub fn survivors(self) -> usize {
        self.faults - self.killed - self.equivalent
    }

    /// Killed of those that are not proven equivalent, in hundredths of a percent, rounded down.
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

/// What the everyday tests must reach, in hundredths of a percent.
const LEAST_SCORE: usize = 9_900;

impl<'s> Report<'s> {
    pub fn new(subjects: &'s [Subject], total: usize) -> Self {
        Self { subjects, total, judged: Vec::new() }
    }

    pub fn add(&mut self, mutant: &Mutant<'_>, fate: Fate) {
        self.judged.push(Judged {
            module: mutant.subject.module.name().to_string(),
            config: mutant.subject.datapath.config.to_string(),
            fault: mutant.fault.to_string(),
            fate,
        });
        // The order in which threads are done is no order.
        self.judged.sort_by(|a, b| (&a.config, &a.fault).cmp(&(&b.config, &b.fault)));
    }

    fn count<'j>(judged: impl Iterator<Item = &'j Judged>) -> Count {
        judged.fold(Count::default(), |count, judged| Count {
            faults: count.faults + 1,
            killed: count.killed + usize::from(matches!(judged.fate, Fate::Killed(_))),
            equivalent: count.equivalent + usize::from(matches!(judged.fate, Fate::Equivalent(_))),
        })
    }

    /// The number of faults that all modules have, from which the sample is drawn.
    fn population(&self) -> usize {
        self.subjects.iter().map(|subject| subject.faults.len()).sum()
    }

    /// All of them.
    pub fn all(&self) -> Count {
        Self::count(self.judged.iter())
    }

    pub fn verdict(&self) -> Verdict {
        let all = self.all();
        let [low, high] = all.interval().map(|bound| 100.0 * bound);
        let mut verdict = Verdict {
            covered: format!(
                "a sample of {} of the {} faults in {} modules: {} killed, {} proven equivalent, {} survivors; \
                 {} killed of those not proven equivalent, 95 % confidence interval {low:.2} % to {high:.2} %",
                all.faults,
                self.population(),
                self.subjects.len(),
                all.killed,
                all.equivalent,
                all.survivors(),
                percent(all.score()),
            ),
            is_stopped: self.judged.len() < self.total,
            ..Verdict::default()
        };
        verdict.remarks.push(format!("killed by {}", self.checks()));
        verdict.remarks.extend(self.survivors());
        verdict.remarks.push(format!("each mutant: {}", super::LIST));
        if all.score() < LEAST_SCORE {
            let (score, least) = (percent(all.score()), percent(LEAST_SCORE));
            verdict.failures.push(format!("the everyday tests kill {score} of the mutants, expected {least} at least"));
        }
        verdict
    }

    fn checks(&self) -> String {
        let mut checks: BTreeMap<&str, usize> = BTreeMap::new();
        for judged in &self.judged {
            if let Fate::Killed(check) = judged.fate {
                *checks.entry(check).or_default() += 1;
            }
        }
        checks.iter().map(|(check, count)| format!("{check}: {count}")).collect::<Vec<_>>().join("; ")
    }

    fn survivors(&self) -> impl Iterator<Item = String> {
        self.judged.iter().filter_map(|judged| match &judged.fate {
            Fate::Survived(why) => {
                let reason = reason(&judged.module, &judged.fault);
                let reason = reason.map_or(String::new(), |reason| format!("; explained: {reason}"));
                Some(format!("survivor: {} ({}); {why}{reason}", judged.fault, judged.config))
            }
            _ => None,
        })
    }

    /// Writes every mutant with its fate, by module, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        files::write(path, &self.text())
    }

    fn text(&self) -> String {
        let mut modules: BTreeMap<(&str, &str), Vec<&Judged>> = BTreeMap::new();
        for judged in &self.judged {
            modules.entry((&judged.config, &judged.module)).or_default().push(judged);
        }
        let mut text = "# faults, killed, equivalent, survivors, module (configuration)\n".to_string();
        for ((config, module), judged) in &modules {
            let count = Self::count(judged.iter().copied());
            let Count { faults, killed, equivalent } = count;
            let _ = writeln!(text, "{faults:5} {killed:5} {equivalent:5} {:5}  {module} ({config})", count.survivors());
        }
        text.push_str("\n# fate, fault\n");
        for judged in &self.judged {
            let fate = match &judged.fate {
                Fate::Killed(check) => format!("killed by {check}"),
                Fate::Equivalent(proof) => format!("equivalent, {proof}"),
                Fate::Survived(why) => format!("survived, {why}"),
            };
            let _ = writeln!(text, "{fate:32} {} ({})", judged.fault, judged.config);
        }
        text
    }
}

fn percent(hundredths: usize) -> String {
    format!("{}.{:02} %", hundredths / 100, hundredths % 100)
}
