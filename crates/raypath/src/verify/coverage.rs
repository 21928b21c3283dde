//! What a campaign has exercised: operands, rules, and the ways that jobs take through the handshakes.

mod atlas;
mod handshakes;
mod operands;
mod rules;
mod tracker;

pub use atlas::{Atlas, Features};
pub use handshakes::Handshakes;
pub use tracker::Tracker;

use std::fmt::Write;

/// How a job entered, and how it left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    /// It was refused at least once before it was accepted.
    pub waited: bool,
    /// What became of it.
    pub end: End,
}

/// What became of a job inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Its outcome was taken in the first cycle that showed it.
    Taken,
    /// Its outcome was refused at least once.
    Held,
    /// A reset came.
    Lost,
}

const WAYS: [&str; 6] = ["taken", "held", "lost", "waited, taken", "waited, held", "waited, lost"];

impl Way {
    /// Neither the source nor the sink had to wait.
    pub const STRAIGHT: Self = Self { waited: false, end: End::Taken };

    fn index(self) -> usize {
        3 * usize::from(self.waited) + self.end as usize
    }
}

/// Counts of all that can be exercised in a configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// For each kind of job and cell of its, jobs by way.
    jobs: Vec<Vec<[u64; WAYS.len()]>>,
    /// What happened at the ports.
    pub handshakes: Handshakes,
}

impl Coverage {
    /// Nothing yet.
    pub fn new(atlas: &Atlas) -> Self {
        let jobs = atlas.cells.iter().map(|cells| vec![[0; WAYS.len()]; cells.len()]).collect();
        Self { jobs, handshakes: Handshakes::new(atlas.capacity) }
    }

    /// Counts a job with these features.
    pub fn count(&mut self, features: &Features, way: Way) {
        let cells = &mut self.jobs[features.kind as usize];
        features.each(|cell| cells[cell][way.index()] += 1);
    }

    /// Adds what another campaign of the same configuration has exercised.
    pub fn add(&mut self, other: &Self) {
        let counts = self.jobs.iter_mut().flatten().flatten();
        counts.zip(other.jobs.iter().flatten().flatten()).for_each(|(count, more)| *count += more);
        self.handshakes.add(&other.handshakes);
    }

    /// How many places there are to hit, and those that were not, in words. Without `with_ways` jobs were only
    /// answered: how they passed, what beats found, and handshakes do not count.
    pub fn unhit(&self, atlas: &Atlas, with_ways: bool) -> (usize, Vec<String>) {
        let (mut places, mut unhit) = (0, Vec::new());
        for (cells, counts) in atlas.cells.iter().zip(&self.jobs) {
            for (cell, counts) in cells.iter().zip(counts) {
                let ways = WAYS.iter().zip(counts).enumerate().filter(|(way, _)| cell.is_reachable(*way));
                if with_ways {
                    places += ways.clone().count();
                    let missing = ways.filter(|(_, (_, count))| **count == 0);
                    unhit.extend(missing.map(|(_, (way, _))| format!("{}, {way}", cell.name)));
                } else if cell.is_reachable_at_entry() {
                    places += 1;
                    unhit.extend((counts.iter().sum::<u64>() == 0).then(|| cell.name.clone()));
                }
            }
        }
        if with_ways {
            for (name, count) in self.handshakes.places(atlas) {
                places += 1;
                unhit.extend((count == 0).then_some(name));
            }
        }
        (places, unhit)
    }

    /// What was not hit, in a line.
    pub fn remark(&self, atlas: &Atlas, with_ways: bool) -> String {
        const SHOWN: usize = 12;
        let (places, unhit) = self.unhit(atlas, with_ways);
        if unhit.is_empty() {
            return format!("all {places} places of the coverage were hit");
        }
        let more = if unhit.len() > SHOWN { "; …" } else { "" };
        let shown = unhit[..unhit.len().min(SHOWN)].join("; ");
        format!("not hit: {} of {places} places of the coverage: {shown}{more}", unhit.len())
    }

    /// All counts as a table for people.
    pub fn table(&self, atlas: &Atlas) -> String {
        let mut text = String::from(
            "# Jobs by what they exercise, and by the way that they took: taken at once, held by the sink, or lost in a\n# reset; without or with waiting at the entrance. A place that cannot be reached has a dash.\n",
        );
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{:<64}{}", "", WAYS.map(|way| format!("{way:>14}")).concat());
        for (cells, counts) in atlas.cells.iter().zip(&self.jobs) {
            for (cell, counts) in cells.iter().zip(counts) {
                let count = |(way, count): (usize, &u64)| match cell.is_reachable(way) {
                    true => format!("{count:>14}"),
                    false => format!("{:>14}", "-"),
                };
                let counts: String = counts.iter().enumerate().map(count).collect();
                let _ = writeln!(text, "{:<64}{counts}", cell.name);
            }
        }
        text += "\n# At the ports\n";
        for (name, count) in self.handshakes.places(atlas) {
            let _ = writeln!(text, "{name:<64}{count:>14}");
        }
        text
    }
}
