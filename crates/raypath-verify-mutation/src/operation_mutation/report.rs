//! The fates of the faults in operations.

use super::LIST;
use super::staging::StagingFate;
use super::subjects::Subject;
use raypath_verify::score::{Count, MIN_SCORE, percent};
use raypath_verify::{Error, Verdict, files};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// What became of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// The oracle refuses an outcome.
    Killed,
    /// No outcome differs, and the solver proves that no job can show the fault.
    Equivalent,
    /// Neither.
    Survived,
}

pub struct Report<'s> {
    subjects: &'s [Subject],
    /// The faults of all subjects, of which those of this shard have a fate.
    fates: BTreeMap<usize, Fate>,
    is_stopped: bool,
    /// The faults of staging.
    pub staging: Vec<(String, StagingFate)>,
}

impl<'s> Report<'s> {
    pub fn new(subjects: &'s [Subject], fates: BTreeMap<usize, Fate>, is_stopped: bool) -> Self {
        Self { subjects, fates, is_stopped, staging: Vec::new() }
    }

    pub fn count(&self) -> Count {
        count(self.fates.values())
    }

    /// The subjects with the numbers of their faults, each with its fate.
    fn by_subject(&self) -> impl Iterator<Item = (&'s Subject, Vec<(&'s str, &Fate)>)> {
        let mut first = 0;
        self.subjects.iter().map(move |subject| {
            let of = first..first + subject.faults.len();
            first = of.end;
            let fates = self.fates.range(of.clone()).map(|(number, fate)| {
                let text: &'s str = &subject.faults[number - of.start].text;
                (text, fate)
            });
            (subject, fates.collect())
        })
    }

    pub fn verdict(&self) -> Verdict {
        let all = self.count();
        let population: usize = self.subjects.iter().map(|subject| subject.faults.len()).sum();
        let [low, high] = all.interval().map(|bound| 100.0 * bound);
        let jobs: usize =
            self.subjects.iter().map(|subject| subject.jobs.steps.iter().map(Vec::len).sum::<usize>()).sum();
        let covered = format!(
            "{} of the {population} faults in {} operations, {jobs} jobs: {} killed, {} proven equivalent, {} \
             survivors; {} killed of those not proven equivalent, 95 % confidence interval {low:.2} % to {high:.2} %",
            all.faults,
            self.subjects.len(),
            all.killed,
            all.equivalent,
            all.survivors(),
            percent(all.score()),
        );
        let of = |fate: StagingFate| self.staging.iter().filter(|(_, found)| *found == fate).count();
        let covered = format!(
            "{covered}; of {} faults of staging, {} refused, {} with other units, {} harmless",
            self.staging.len(),
            of(StagingFate::Refused),
            of(StagingFate::OtherUnits),
            of(StagingFate::Harmless),
        );
        let mut verdict = Verdict { covered, is_stopped: self.is_stopped, ..Verdict::default() };
        for (subject, fates) in self.by_subject() {
            if let Some(refused) = &subject.refused {
                verdict.failures.push(format!("{}: without a fault refused by the oracle: {refused}", subject.name));
            }
            for (text, fate) in fates {
                if *fate == Fate::Survived {
                    verdict.remarks.push(format!("survivor: {}, {text}", subject.name));
                }
            }
        }
        for (text, fate) in &self.staging {
            if let StagingFate::Wrong(difference) = fate {
                verdict
                    .failures
                    .push(format!("the netlist differs from the model with a fault of staging, {text}: {difference}"));
            }
        }
        verdict.remarks.push(format!("each fault: {LIST}"));
        if all.score() < MIN_SCORE {
            let (score, least) = (percent(all.score()), percent(MIN_SCORE));
            verdict.failures.push(format!("the oracle finds {score} of the faults, expected at least {least}"));
        }
        verdict
    }

    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let mut text = "# faults, killed, equivalent, survivors, operation\n".to_string();
        let mut list = "\n# fate, fault\n".to_string();
        for (subject, fates) in self.by_subject() {
            let count = count(fates.iter().map(|(_, fate)| *fate));
            let Count { faults, killed, equivalent } = count;
            let name = &subject.name;
            let _ = writeln!(text, "{faults:5} {killed:5} {equivalent:5} {:5}  {name}", count.survivors());
            for (fault, fate) in fates {
                let _ = writeln!(list, "{:10} {name}, {fault}", format!("{fate:?}"));
            }
        }
        for (fault, fate) in &self.staging {
            let _ = writeln!(list, "{:10} {fault}", format!("{fate:?}"));
        }
        files::write(path, &(text + &list))
    }
}

fn count<'f>(fates: impl Iterator<Item = &'f Fate>) -> Count {
    fates.fold(Count::default(), |count, fate| Count {
        faults: count.faults + 1,
        killed: count.killed + usize::from(*fate == Fate::Killed),
        equivalent: count.equivalent + usize::from(*fate == Fate::Equivalent),
    })
}
