//! Random cases on all cores. The result does not depend on the number of cores.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_tools::pool;
use raypath_verify::{Error, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The number of cases in a block. Each block has a random stream of its own.
const BLOCK: u64 = 512;

/// Runs the shard's part of `cases` cases. `stream` selects random numbers that other campaigns of the same seed do not
/// use. `case` adds its result to that of its block. Returns the joined results, which do not depend on the number of
/// workers, and whether the user stopped the campaign.
pub fn run(
    request: &mut Request<'_>,
    stream: u64,
    cases: u64,
    case: impl Fn(&mut ChaCha8Rng, &mut Tally) + Sync,
) -> Result<(Tally, bool), Error> {
    run_with(request, stream, cases, || Ok(()), |(), rng, tally| case(rng, tally))
}

/// As [`run`], with a state that each worker makes and its cases share.
pub fn run_with<S>(
    request: &mut Request<'_>,
    stream: u64,
    cases: u64,
    state: impl Fn() -> Result<S, Error> + Sync,
    case: impl Fn(&mut S, &mut ChaCha8Rng, &mut Tally) + Sync,
) -> Result<(Tally, bool), Error> {
    let mut is_stopped = false;
    let mut parts = std::mem::take(&mut request.parts);
    let shards = parts.phase(|| {
        let (mut blocks, stopped) = blocks(request, stream, cases, state, case)?;
        is_stopped = stopped;
        let failures = blocks.iter_mut().flat_map(|(block, tally)| tally.shown.iter_mut().map(|shown| (*block, shown)));
        failures.for_each(|(block, shown)| shown.0 = block);
        Ok::<_, Error>(Tally::joined(blocks.into_iter().map(|(_, tally)| tally)))
    });
    request.parts = parts;
    Ok((Tally::joined(shards?), is_stopped))
}

/// The results of the blocks with their numbers, in order, and whether the user stopped the campaign.
fn blocks<S, T: Send + Default>(
    request: &mut Request<'_>,
    stream: u64,
    cases: u64,
    state: impl Fn() -> Result<S, Error> + Sync,
    case: impl Fn(&mut S, &mut ChaCha8Rng, &mut T) + Sync,
) -> Result<(Vec<(u64, T)>, bool), Error> {
    let (seed, cases) = (request.seed, request.cases(cases, BLOCK));
    let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
        let (mut tallies, mut state) = (Vec::new(), state()?);
        queue.run(|block, _| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream << 40 | block);
            let mut tally = T::default();
            cases.range(block).for_each(|_| case(&mut state, &mut rng, &mut tally));
            tallies.push((block, tally));
            Ok(())
        });
        Ok(tallies)
    })?;
    let in_order: BTreeMap<u64, T> = finished.workers.into_iter().flatten().collect();
    Ok((in_order.into_iter().collect(), finished.is_stopped))
}

/// The results of cases, by name: counts, the largest of some values, and failures.
#[derive(Debug, Default, Serialize, Deserialize)]
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
    pub fn add(&mut self, name: &'static str, count: impl Into<u64>) {
        *self.counts.entry(Cow::Borrowed(name)).or_default() += count.into();
    }

    /// Adds a value, at least 0, of which the largest counts.
    pub fn add_value(&mut self, name: &'static str, value: f64) {
        let largest = self.largest.entry(Cow::Borrowed(name)).or_default();
        *largest = f64::from_bits(*largest).max(value).to_bits();
    }

    pub fn fail(&mut self, message: impl FnOnce() -> String) {
        if self.shown.len() < SHOWN {
            self.shown.push((0, message()));
        }
        self.failures += 1;
    }

    pub fn count(&self, name: &str) -> u64 {
        self.counts.get(name).copied().unwrap_or(0)
    }

    /// The largest value of this name; 0 if there is none.
    pub fn largest(&self, name: &str) -> f64 {
        self.largest.get(name).copied().map_or(0.0, f64::from_bits)
    }

    pub fn failures(&self) -> u64 {
        self.failures
    }

    /// The sum of the results of blocks or shards.
    pub fn joined(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for part in parts {
            part.counts.into_iter().for_each(|(name, count)| *all.counts.entry(name).or_default() += count);
            for (name, value) in part.largest {
                let largest = all.largest.entry(name).or_default();
                *largest = value.max(*largest);
            }
            all.shown.extend(part.shown);
            all.failures += part.failures;
        }
        all.shown.sort_by_key(|(block, _)| *block);
        all.shown.truncate(SHOWN);
        all
    }

    /// The verdict, with the first few failures and the number of the others. The negative controls are the faulty
    /// implementations `faulty`, whose findings were counted by their names: `label` begins the remark of the counts.
    /// After enough cases, a faulty implementation without a finding is a failure.
    pub fn verdict<const N: usize>(
        self,
        is_stopped: bool,
        covered: String,
        mut remarks: Vec<String>,
        (label, faulty, is_enough): (&str, [&'static str; N], bool),
    ) -> Verdict {
        let found = faulty.map(|name| (name, self.count(name)));
        remarks.push(format!("{label}: {}", found.map(|(name, count)| format!("{name} {count}")).join(", ")));
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
    use super::{Tally, blocks};
    use rand::RngExt;
    use rand::rngs::ChaCha8Rng;
    use raypath_verify::{Progress, Request, Shard};

    fn numbers(seed: u64, shard: Shard, watch: &mut dyn FnMut(Progress) -> bool) -> (Vec<u32>, bool) {
        let mut request = Request { seed, shard, ..Request::new(watch) };
        let draw = |(): &mut (), rng: &mut ChaCha8Rng, numbers: &mut Vec<u32>| numbers.push(rng.random());
        let (numbers, is_stopped) = blocks(&mut request, 7, 5000, || Ok(()), draw).expect("numbers");
        (numbers.into_iter().flat_map(|(_, numbers)| numbers).collect(), is_stopped)
    }

    #[test]
    fn cases_follow_from_the_seed_and_shards_divide_them() {
        let mut last = None;
        let (all, is_stopped) = numbers(1, Shard::ALL, &mut |step| {
            last = Some(step);
            true
        });
        assert_eq!((all.len(), is_stopped, last), (5000, false, Some(Progress { done: 5000, total: 5000 })));
        assert_eq!(numbers(1, Shard::ALL, &mut |_| true).0, all);
        assert_ne!(numbers(2, Shard::ALL, &mut |_| true).0, all);

        let shards = ["1/3", "2/3", "3/3"].map(|shard| shard.parse().expect("a shard"));
        let mut parts: Vec<u32> = shards.iter().flat_map(|&shard| numbers(1, shard, &mut |_| true).0).collect();
        let mut sorted = all;
        parts.sort_unstable();
        sorted.sort_unstable();
        assert_eq!(parts, sorted);
    }

    #[test]
    fn it_stops_when_told() {
        let watch = &mut |_| false;
        let case = |(): &mut (), _: &mut ChaCha8Rng, cases: &mut u64| *cases += 1;
        let (some, is_stopped) = blocks(&mut Request::new(watch), 7, 1_000_000_000, || Ok(()), case).expect("numbers");
        assert!(is_stopped && some.iter().map(|(_, cases)| cases).sum::<u64>() < 1_000_000_000, "{}", some.len());
    }

    #[test]
    fn the_first_failures_are_shown_and_all_are_counted() {
        let blocks = (0..4).map(|i| {
            let mut block = Tally::default();
            (0..2).for_each(|j| block.fail(|| format!("{i}{j}")));
            block
        });
        let all = Tally::joined(blocks);
        assert_eq!(all.failures(), 8);
        let verdict = all.verdict(false, String::new(), Vec::new(), ("", [], true));
        assert_eq!(verdict.failures, ["00", "01", "10", "11", "20", "and 3 more"]);
    }
}
