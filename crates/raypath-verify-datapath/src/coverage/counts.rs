//! Counts of what a campaign has covered.

use super::handshakes::Handshakes;
use super::model::{CoverageModel, JobPath, JobPoints, PATHS};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// What counts as a coverage point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// What is known of a job when it enters: for jobs that ran outside a pipeline.
    AtEntry,
    /// Everything that a job can exercise, and the handshakes.
    OnAnyPath,
    /// The same, with a point for each path that the job can take.
    ByPath,
}

/// Counts of all coverage points of a configuration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Coverage {
    /// Jobs for each operation, coverage point and path.
    jobs: Vec<Vec<[u64; PATHS.len()]>>,
    /// Events at the ports.
    pub handshakes: Handshakes,
}

impl Coverage {
    /// All counts are zero.
    pub fn new(model: &CoverageModel) -> Self {
        let jobs = model.operations.iter().map(|one| vec![[0; PATHS.len()]; one.points.len()]).collect();
        Self { jobs, handshakes: Handshakes::new(model.capacity) }
    }

    /// Counts a job that covers these points.
    pub fn count(&mut self, covered: &JobPoints, path: JobPath) {
        let points = &mut self.jobs[covered.operation];
        covered.each(|point| points[point][path.index()] += 1);
    }

    /// Adds the counts of another campaign with the same configuration.
    pub fn add(&mut self, other: &Self) {
        let counts = self.jobs.iter_mut().flatten().flatten();
        counts.zip(other.jobs.iter().flatten().flatten()).for_each(|(count, more)| *count += more);
        self.handshakes.add(&other.handshakes);
    }

    /// The number of coverage points, and the names of those that are not covered.
    pub fn uncovered(&self, model: &CoverageModel, counted: Counted) -> (usize, Vec<String>) {
        let (mut total, mut uncovered) = (0, Vec::new());
        for (operation, counts) in model.operations.iter().zip(&self.jobs) {
            for (point, counts) in operation.points.iter().zip(counts) {
                let paths = PATHS.iter().zip(counts).enumerate().filter(|(path, _)| point.is_reachable(*path));
                if counted == Counted::ByPath {
                    total += paths.clone().count();
                    let missing = paths.filter(|(_, (_, count))| **count == 0);
                    uncovered.extend(missing.map(|(_, (path, _))| format!("{}, {path}", point.name)));
                } else if point.is_reachable_at_entry() || counted == Counted::OnAnyPath && point.is_reachable(0) {
                    total += 1;
                    uncovered.extend((counts.iter().sum::<u64>() == 0).then(|| point.name.clone()));
                }
            }
        }
        if counted != Counted::AtEntry {
            for (name, count) in self.handshakes.points(model) {
                total += 1;
                uncovered.extend((count == 0).then_some(name));
            }
        }
        (total, uncovered)
    }

    /// The coverage in a line, with the first uncovered points.
    pub fn remark(&self, model: &CoverageModel, counted: Counted) -> String {
        const SHOWN: usize = 12;
        let (total, uncovered) = self.uncovered(model, counted);
        if uncovered.is_empty() {
            return format!("all {total} coverage points are covered");
        }
        let more = if uncovered.len() > SHOWN { "; …" } else { "" };
        let shown = uncovered[..uncovered.len().min(SHOWN)].join("; ");
        format!("not covered: {} of {total} coverage points: {shown}{more}", uncovered.len())
    }

    /// All counts as a text table.
    pub fn table(&self, model: &CoverageModel) -> String {
        let mut text = String::from(
            "# Jobs by coverage point and by path: the outcome taken at once, stalled by the sink, or lost in a \
             reset;\n\
             # without or with waiting at the entrance. An unreachable combination has a dash.\n",
        );
        // Writing to a String always succeeds.
        let _ = writeln!(text, "{:<64}{}", "", PATHS.map(|path| format!("{path:>14}")).concat());
        for (operation, counts) in model.operations.iter().zip(&self.jobs) {
            for (point, counts) in operation.points.iter().zip(counts) {
                let count = |(path, count): (usize, &u64)| match point.is_reachable(path) {
                    true => format!("{count:>14}"),
                    false => format!("{:>14}", "-"),
                };
                let counts: String = counts.iter().enumerate().map(count).collect();
                let _ = writeln!(text, "{:<64}{counts}", point.name);
            }
        }
        text += "\n# At the ports\n";
        for (name, count) in self.handshakes.points(model) {
            let _ = writeln!(text, "{name:<64}{count:>14}");
        }
        text
    }
}
