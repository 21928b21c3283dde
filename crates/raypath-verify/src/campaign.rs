//! Campaigns: random cases on all cores. What a case does follows from the seed and the number of its block alone, and
//! the result of a campaign depends neither on the number of cores nor on the number of shards.

use crate::{Error, Request, Verdict};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_work::pool;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

/// A campaign.
#[derive(Debug, Clone, Copy)]
pub struct Campaign {
    /// Campaigns with different streams have different random numbers for the same seed.
    pub stream: u64,
    /// The number of cases of all shards.
    pub cases: u64,
    /// The number of cases in a block. A block has random numbers of its own; shards and workers take whole blocks.
    pub block: u64,
    /// Whether the first failure ends the campaign.
    pub ends_at_failure: bool,
}

impl Campaign {
    /// A campaign of many short cases, which continues after failures.
    pub fn new(stream: u64, cases: u64) -> Self {
        Self { stream, cases, block: 512, ends_at_failure: false }
    }

    /// A campaign of long cases, each with random numbers of its own. The first failure ends it.
    pub fn of_episodes(stream: u64, cases: u64) -> Self {
        Self { stream, cases, block: 1, ends_at_failure: true }
    }

    /// The random numbers of a block.
    pub fn rng(&self, seed: u64, block: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(self.stream << 40 | block);
        rng
    }

    /// As [`run`](Self::run), for cases without a state and errors.
    ///
    /// # Errors
    /// The pool cannot be started, or the results of the shards cannot be read.
    pub fn run_cases(
        &self,
        request: &mut Request<'_>,
        case: impl Fn(&mut ChaCha8Rng, &mut Tally) + Sync,
    ) -> Result<(Tally, bool), Error> {
        let case = |(): &mut (), _: u64, rng: &mut ChaCha8Rng, tally: &mut Tally| {
            case(rng, tally);
            Ok(())
        };
        self.run(request, || Ok(()), case)
    }

    /// Runs the cases of the request's shard. Each worker makes a state. `case` runs a case on it: it gets the number of
    /// the case's block and the random numbers, and adds what it finds to a tally. Returns the tally of all cases, or of
    /// all shards if the request has their results, and whether the user stopped the campaign.
    ///
    /// # Errors
    /// The first error of `state` or `case`.
    pub fn run<S>(
        &self,
        request: &mut Request<'_>,
        state: impl Fn() -> Result<S, Error> + Sync,
        case: impl Fn(&mut S, u64, &mut ChaCha8Rng, &mut Tally) -> Result<(), Error> + Sync,
    ) -> Result<(Tally, bool), Error> {
        let (seed, cases) = (request.seed, request.cases(self.cases, self.block));
        let mut is_stopped = false;
        let shards = request.parts.phase(|| {
            let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
                let (mut found, mut state) = (Tally::default(), state()?);
                queue.run(|block, stop| {
                    let (mut rng, mut tally) = (self.rng(seed, block), Tally::default());
                    for _ in cases.range(block) {
                        case(&mut state, block, &mut rng, &mut tally)?;
                    }
                    if self.ends_at_failure && tally.failures > 0 {
                        stop.store(true, Ordering::Relaxed);
                    }
                    tally.shown.iter_mut().for_each(|shown| shown.0 = block);
                    found.join(tally);
                    Ok(())
                });
                Ok(found)
            })?;
            is_stopped = finished.is_stopped;
            Ok::<_, Error>(Tally::joined(finished.workers))
        })?;
        Ok((Tally::joined(shards), is_stopped))
    }
}

/// The results of cases, by name: counts, the largest of some values, and failures.
#[derive(Debug, Default, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    counts: BTreeMap<Cow<'static, str>, u64>,
    /// The bits of the values, which are not negative: their order is that of the numbers.
    largest: BTreeMap<Cow<'static, str>, u64>,
    /// The first few failures with the numbers of their blocks, and the number of all.
    shown: Vec<(u64, String)>,
    failures: u64,
}

const SHOWN: usize = 5;

impl Tally {
    /// Adds to a count.
    pub fn add(&mut self, name: impl Into<Cow<'static, str>>, count: impl Into<u64>) {
        *self.counts.entry(name.into()).or_default() += count.into();
    }

    /// Adds a value, at least 0, of which the largest counts.
    pub fn add_value(&mut self, name: &'static str, value: f64) {
        let largest = self.largest.entry(Cow::Borrowed(name)).or_default();
        *largest = f64::from_bits(*largest).max(value).to_bits();
    }

    /// Adds a failure.
    pub fn fail(&mut self, message: impl FnOnce() -> String) {
        if self.shown.len() < SHOWN {
            self.shown.push((0, message()));
        }
        self.failures += 1;
    }

    /// The count of this name; 0 if there is none.
    pub fn count(&self, name: &str) -> u64 {
        self.counts.get(name).copied().unwrap_or(0)
    }

    /// The largest value of this name; 0 if there is none.
    pub fn largest(&self, name: &str) -> f64 {
        self.largest.get(name).copied().map_or(0.0, f64::from_bits)
    }

    /// The number of failures.
    pub fn failures(&self) -> u64 {
        self.failures
    }

    /// The number of the first block with a failure, and the failure.
    pub fn first_failure(&self) -> Option<(u64, &str)> {
        self.shown.first().map(|(block, failure)| (*block, failure.as_str()))
    }

    /// The sum of results.
    pub fn joined(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        parts.into_iter().for_each(|part| all.join(part));
        all
    }

    fn join(&mut self, part: Self) {
        part.counts.into_iter().for_each(|(name, count)| self.add(name, count));
        for (name, value) in part.largest {
            let largest = self.largest.entry(name).or_default();
            *largest = value.max(*largest);
        }
        self.shown.extend(part.shown);
        self.shown.sort_by_key(|(block, _)| *block);
        self.shown.truncate(SHOWN);
        self.failures += part.failures;
    }

    /// The verdict, with the first few failures and the number of the others. The negative controls are the faulty
    /// implementations `faulty`, if any, whose findings were counted by their names: `label` begins the remark of the
    /// counts. After enough cases, a faulty implementation without a finding is a failure.
    pub fn verdict<const N: usize>(
        self,
        is_stopped: bool,
        covered: String,
        mut remarks: Vec<String>,
        (label, faulty, is_enough): (&str, [&'static str; N], bool),
    ) -> Verdict {
        let found = faulty.map(|name| (name, self.count(name)));
        if N > 0 {
            remarks.push(format!("{label}: {}", found.map(|(name, count)| format!("{name} {count}")).join(", ")));
        }
        let mut failures: Vec<String> = self.shown.into_iter().map(|(_, failure)| failure).collect();
        let more = self.failures - failures.len() as u64;
        failures.extend((more > 0).then(|| format!("and {more} more")));
        let missed = found.iter().filter(|(_, count)| is_enough && *count == 0);
        failures.extend(missed.map(|(name, _)| format!("the campaign cannot fail: it does not refute {name}")));
        Verdict { covered, failures, remarks, is_stopped }
    }
}

#[cfg(test)]
mod tests {
    use super::{Campaign, Tally};
    use crate::{Progress, Request, Shard};
    use rand::RngExt;

    fn tally(cases: u64, seed: u64, shard: Shard, proceed: &mut dyn FnMut(Progress) -> bool) -> (Tally, bool) {
        let mut request = Request { seed, shard, ..Request::new(proceed) };
        let campaign = Campaign::new(7, cases);
        let found = campaign.run(
            &mut request,
            || Ok(()),
            |(), block, rng, tally| {
                let number: u8 = rng.random();
                tally.add(format!("{}", number % 16), 1_u64);
                if number == 0 {
                    tally.fail(|| format!("block {block}"));
                }
                Ok(())
            },
        );
        found.expect("a tally")
    }

    #[test]
    fn cases_follow_from_the_seed_and_shards_divide_them() {
        let mut last = None;
        let (all, is_stopped) = tally(5000, 1, Shard::ALL, &mut |step| {
            last = Some(step);
            true
        });
        assert_eq!((is_stopped, last), (false, Some(Progress { done: 5000, total: 5000 })));
        assert_eq!((0..16).map(|name| all.count(&name.to_string())).sum::<u64>(), 5000);
        assert!(
            all.failures() > 5 && all.first_failure().is_some_and(|(block, what)| what == format!("block {block}"))
        );
        assert_eq!(tally(5000, 1, Shard::ALL, &mut |_| true).0, all);
        assert_ne!(tally(5000, 2, Shard::ALL, &mut |_| true).0, all);
        let shards = ["3/3", "1/3", "2/3"].map(|shard| shard.parse().expect("a shard"));
        assert_eq!(Tally::joined(shards.map(|shard| tally(5000, 1, shard, &mut |_| true).0)), all);
    }

    #[test]
    fn it_stops_when_told_and_at_a_failure() {
        let (some, is_stopped) = tally(1_000_000_000, 1, Shard::ALL, &mut |_| false);
        assert!(is_stopped && some.count("1") < 1_000_000);
        let mut proceed = |_| true;
        let found = Campaign::of_episodes(1, u64::MAX >> 24).run(
            &mut Request::new(&mut proceed),
            || Ok(()),
            |(), block, _, tally| {
                if block >= 100 {
                    tally.fail(|| block.to_string());
                }
                Ok(())
            },
        );
        assert_eq!(found.expect("a tally").0.first_failure(), Some((100, "100")));
    }

    #[test]
    fn the_first_failures_are_shown_and_all_are_counted() {
        let blocks = (0..4).map(|i| {
            let mut block = Tally::default();
            (0..2).for_each(|j| block.fail(|| format!("{i}{j}")));
            block
        });
        let verdict = Tally::joined(blocks).verdict(false, String::new(), Vec::new(), ("", ["x"], true));
        let missed = "the campaign cannot fail: it does not refute x";
        assert_eq!(verdict.failures, ["00", "01", "10", "11", "20", "and 3 more", missed]);
    }
}
