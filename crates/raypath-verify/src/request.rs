//! What to verify, how much of it, and which part; and what was found.

use raypath_rtl::Config;
use raypath_work::parts::Parts;
use raypath_work::pool::Cases;
pub use raypath_work::pool::{Progress, Shard, ShardError};

/// The parameters of a verification, and the function that watches it.
pub struct Request<'a> {
    /// The configuration to verify, for items that depend on one.
    pub config: Config,
    /// The names of the operations to verify besides the configuration's, for items that run a datapath.
    pub added: Vec<String>,
    /// Whether the user chose configuration and operations. Otherwise some items run many of them.
    pub is_chosen: bool,
    /// How much to run.
    pub level: Level,
    /// The number of jobs or cases, for items that have them; by default the level decides.
    pub jobs: Option<u64>,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The part of the work to run.
    pub shard: Shard,
    /// Where the results come from: from running the shard, or from the parts of all shards.
    pub parts: Parts,
    /// Receives the progress several times a second; the run stops when it returns false.
    pub proceed: &'a mut dyn FnMut(Progress) -> bool,
}

impl<'a> Request<'a> {
    /// The default configuration at level `regression`, with the level's number of jobs, seed 1 and no shards.
    pub fn new(proceed: &'a mut dyn FnMut(Progress) -> bool) -> Self {
        let (config, level) = (Config::DEFAULT, Level::Regression);
        let parts = Parts::default();
        let (added, is_chosen, shard) = (Vec::new(), false, Shard::ALL);
        Self { config, added, is_chosen, level, jobs: None, seed: 1, shard, parts, proceed }
    }

    /// The shard's part of `total` cases, in pieces of `piece`.
    pub fn cases(&self, total: u64, piece: u64) -> Cases {
        Cases { total, piece, shard: self.shard }
    }
}

/// How much to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Level {
    /// Seconds for each item, minutes in all: what `./test.sh` runs.
    #[default]
    Regression,
    /// Minutes for most items, hours in all: before a release.
    Full,
    /// Hours: once for each version of the arithmetic.
    Long,
}

raypath_ops::names! {
    Level { Regression = "regression", Full = "full", Long = "long" },
    /// A text that names no level.
    ParseLevelError, "'{0}' is not a valid level, expected regression, full or long"
}

impl Level {
    /// All levels, the shortest first.
    pub const ALL: &[Self] = &[Self::Regression, Self::Full, Self::Long];

    /// The value for this level, of one for each.
    pub fn pick<T>(self, regression: T, full: T, long: T) -> T {
        match self {
            Self::Regression => regression,
            Self::Full => full,
            Self::Long => long,
        }
    }
}

/// What a verification covered, and what it found wrong.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Verdict {
    /// What was run or proved, with numbers, in a line: "7,496,192 cases of each of 4 functions".
    pub covered: String,
    /// The first failures, a line each; empty if the claim holds.
    pub failures: Vec<String>,
    /// Further results, a line each: coverage that was not reached, work that was skipped, versions of programs.
    pub remarks: Vec<String>,
    /// Whether the user stopped the run before its end.
    pub is_stopped: bool,
}

impl Verdict {
    /// The verdict on both of two works.
    pub fn and(mut self, other: Self) -> Self {
        self.covered = format!("{}; {}", self.covered, other.covered);
        self.failures.extend(other.failures);
        self.remarks.extend(other.remarks);
        self.is_stopped |= other.is_stopped;
        self
    }
}
