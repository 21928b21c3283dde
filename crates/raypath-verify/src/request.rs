//! What to verify, how much of it, and which part.

use raypath_rtl::Config;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// The parameters of a verification, and the function that watches it.
pub struct Request<'a> {
    /// The configuration to verify, for items that depend on one.
    pub config: Config,
    /// How much to run.
    pub level: Level,
    /// The number of jobs or cases, for items that have them; by default the level decides.
    pub jobs: Option<u64>,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The part of the work to run.
    pub shard: Shard,
    /// Receives the progress several times a second; the run stops when it returns false.
    pub proceed: &'a mut dyn FnMut(Progress) -> bool,
}

/// How much of the work is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Cases that have run.
    pub done: u64,
    /// Cases to run.
    pub total: u64,
}

/// How much to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Level {
    /// Seconds for each item, minutes in all: what `./test.sh` runs.
    #[default]
    Regression,
    /// Minutes for each item, about an hour in all: before a release.
    Full,
    /// Hours: once for each version of the arithmetic.
    Long,
}

/// One of several equal parts of the work, so that machines can divide it: `2/5` is the second of five.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// A text that names no shard.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no shard, expected i/n with 1 ≤ i ≤ n, such as 2/5")]
pub struct ShardError(String);

impl Shard {
    /// The whole of the work.
    pub const ALL: Self = Self { number: 0, of: 1 };

    /// Whether the case with this number belongs to the shard. Each number belongs to one of the n shards.
    pub fn takes(self, number: u64) -> bool {
        number % self.of == self.number
    }

    /// How many of the numbers below `total` belong to the shard.
    pub fn share(self, total: u64) -> u64 {
        total / self.of + u64::from(total % self.of > self.number)
    }

    /// The shard's number, from 0.
    pub fn number(self) -> u64 {
        self.number
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse::<u64>().ok()?, n.parse::<u64>().ok()?)));
        let valid = numbers.filter(|&(i, n)| (1..=n).contains(&i));
        valid.map(|(i, of)| Self { number: i - 1, of }).ok_or_else(|| ShardError(text.to_string()))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number + 1, self.of)
    }
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let level = Self::ALL.iter().find(|level| level.name() == text);
        level.copied().ok_or_else(|| format!("'{text}' is no level, expected regression, full or long"))
    }
}

impl Level {
    /// All levels, the shortest first.
    pub const ALL: &[Self] = &[Self::Regression, Self::Full, Self::Long];

    /// The level's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regression => "regression",
            Self::Full => "full",
            Self::Long => "long",
        }
    }

    /// The value for this level, of one for each.
    pub fn pick<T>(self, regression: T, full: T, long: T) -> T {
        match self {
            Self::Regression => regression,
            Self::Full => full,
            Self::Long => long,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_the_work() {
        for of in 1..=7 {
            let shards: Vec<Shard> = (1..=of).map(|i| format!("{i}/{of}").parse().expect("a shard")).collect();
            for total in 0..30 {
                let of_each = |shard: &Shard| (0..total).filter(|&item| shard.takes(item)).count() as u64;
                assert!(shards.iter().all(|shard| of_each(shard) == shard.share(total)), "{of}, {total}");
                assert_eq!(shards.iter().map(|shard| shard.share(total)).sum::<u64>(), total);
            }
        }
        // Sums of such numbers overflow.
        let last: Shard = format!("{0}/{0}", u64::MAX).parse().expect("a shard");
        assert_eq!((last.share(u64::MAX), last.share(u64::MAX - 1)), (1, 0));
        for text in ["", "1", "0/3", "4/3", "-1/3", "1/0", "1/2/3", "a/b"] {
            assert_eq!(text.parse::<Shard>(), Err(ShardError(text.to_string())));
        }
    }
}
