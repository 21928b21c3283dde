//! What is asked of a piece of verification.

use raypath_rtl::Config;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// What to verify, how much of it, and whom to tell.
pub struct Request<'a> {
    /// The configuration, where the work is about one.
    pub config: Config,
    /// How much is done.
    pub level: Level,
    /// How many jobs, where the work has jobs and the user has said a number; else the level decides.
    pub jobs: Option<u64>,
    /// Seed of whatever is random.
    pub seed: u64,
    /// The part of the work that is done here.
    pub shard: Shard,
    /// Is told how far the work is, at least every few tenths of a second, and answers whether to go on.
    pub watch: &'a mut dyn FnMut(Step) -> bool,
}

/// How far work is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Items done.
    pub done: u64,
    /// Items in all.
    pub total: u64,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Level {
    /// Seconds each, minutes together; what `./test.sh` runs.
    #[default]
    Everyday,
    /// Minutes each, about an hour together; before a release.
    Full,
    /// Hours; once for each version of the arithmetic.
    Long,
}

/// One of several equal parts of the work, so that machines can divide it: `2/5` is the second of five.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// What is no shard.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no shard, expected i/n with 1 ≤ i ≤ n, such as 2/5")]
pub struct ShardError(String);

impl Shard {
    /// All the work.
    pub const ALL: Self = Self { number: 0, of: 1 };

    /// Whether the item with this number belongs to it. Each number belongs to one shard of the n.
    pub fn takes(self, item: u64) -> bool {
        item % self.of == self.number
    }

    /// How many of the numbers below `total` belong to it.
    pub fn share(self, total: u64) -> u64 {
        total / self.of + u64::from(total % self.of > self.number)
    }

    /// Its number, from 0: what tells its random numbers from those of other shards.
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
        level.copied().ok_or_else(|| format!("'{text}' is no level, expected everyday, full or long"))
    }
}

impl Level {
    /// All of them, the shortest first.
    pub const ALL: &[Self] = &[Self::Everyday, Self::Full, Self::Long];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Everyday => "everyday",
            Self::Full => "full",
            Self::Long => "long",
        }
    }

    /// One of three values.
    pub fn pick<T>(self, everyday: T, full: T, long: T) -> T {
        match self {
            Self::Everyday => everyday,
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
