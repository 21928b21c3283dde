//! Random cases on all cores. The result does not depend on the number of cores.

use crate::error::Error;
use crate::request::{Progress, Request};
use crate::verdict::Verdict;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_tools::pool::{self, Cases};
use std::collections::BTreeMap;

/// The counts of cases, which can be joined.
pub trait Tally: Send {
    /// Adds the counts of later cases.
    fn join(&mut self, later: Self);
}

impl Tally for u64 {
    fn join(&mut self, later: Self) {
        *self += later;
    }
}

impl<T: Tally, const N: usize> Tally for [T; N] {
    fn join(&mut self, later: Self) {
        self.iter_mut().zip(later).for_each(|(sum, count)| sum.join(count));
    }
}

/// Implements [`Tally`] for a structure, by joining all of its fields.
macro_rules! tally_of_fields {
    ($name:ident { $($field:ident),+ $(,)? }) => {
        impl $crate::geometry::campaign::Tally for $name {
            fn join(&mut self, later: Self) {
                let Self { $($field),+ } = later;
                $($crate::geometry::campaign::Tally::join(&mut self.$field, $field);)+
            }
        }
    };
}
pub(super) use tally_of_fields;

/// The number of cases in a block. Each block has a random stream of its own.
const BLOCK: u64 = 512;

/// Runs the shard's part of `cases` cases. `stream` selects random numbers that other campaigns of the same seed do not
/// use. Returns the counts, and whether the user stopped the campaign.
///
/// # Errors
/// The threads cannot start.
pub fn run<T: Tally + Default>(
    request: &mut Request<'_>,
    stream: u64,
    cases: u64,
    case: impl Fn(&mut ChaCha8Rng, &mut T) + Sync,
) -> Result<(T, bool), Error> {
    let (seed, shard) = (request.seed, request.shard);
    let blocks = cases.div_ceil(BLOCK);
    let size = |block: u64| BLOCK.min(cases - block * BLOCK);
    let lacking = if blocks > 0 && shard.takes(blocks - 1) { BLOCK - size(blocks - 1) } else { 0 };
    let total = shard.share(blocks) * BLOCK - lacking;
    let mut proceed = |blocks: Progress| (request.proceed)(Progress { done: total.min(blocks.done * BLOCK), total });
    let finished = pool::run::<_, Error>(Cases { total: blocks, shard }, pool::ALL_CORES, &mut proceed, |queue| {
        let mut tallies = Vec::new();
        queue.run(|block, _| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(stream << 40 | block);
            let mut tally = T::default();
            (0..size(block)).for_each(|_| case(&mut rng, &mut tally));
            tallies.push((block, tally));
            Ok(())
        });
        Ok(tallies)
    })?;
    // Tallies are joined in the order of blocks, so that the result does not depend on the number of workers.
    let in_order: BTreeMap<u64, T> = finished.workers.into_iter().flatten().collect();
    let mut joined = T::default();
    in_order.into_values().for_each(|tally| joined.join(tally));
    Ok((joined, finished.is_stopped))
}

/// The first few failures, and the count of all.
#[derive(Debug, Clone, Default)]
pub struct Failures {
    shown: Vec<String>,
    count: u64,
}

impl Failures {
    const SHOWN: usize = 5;

    /// Adds a failure.
    pub fn add(&mut self, message: impl FnOnce() -> String) {
        if self.shown.len() < Self::SHOWN {
            self.shown.push(message());
        }
        self.count += 1;
    }

    /// The number of all failures.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The first few failures, and the number of the others.
    pub fn lines(self) -> Vec<String> {
        let more = self.count - self.shown.len() as u64;
        let rest = (more > 0).then(|| format!("and {more} more"));
        self.shown.into_iter().chain(rest).collect()
    }
}

impl Tally for Failures {
    fn join(&mut self, later: Self) {
        self.shown.extend(later.shown);
        self.shown.truncate(Self::SHOWN);
        self.count += later.count;
    }
}

/// The largest of some values; 0 if there are none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Largest(pub f64);

impl Largest {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.0 = self.0.max(value);
    }
}

impl Tally for Largest {
    fn join(&mut self, later: Self) {
        self.add(later.0);
    }
}

/// Adds the negative controls to a verdict: a remark of what the campaign found of each faulty implementation, `found`,
/// after `label`. After enough cases, a faulty implementation without a finding is a failure.
pub fn add_controls<const N: usize>(
    verdict: &mut Verdict,
    label: &str,
    names: [&str; N],
    found: [u64; N],
    is_enough: bool,
) {
    let counts: Vec<String> = names.iter().zip(found).map(|(name, found)| format!("{name} {found}")).collect();
    verdict.remarks.push(format!("{label}: {}", counts.join(", ")));
    let missed = names.iter().zip(found).filter(|(_, found)| is_enough && *found == 0);
    verdict.failures.extend(missed.map(|(name, _)| format!("the campaign cannot fail: it does not refute {name}")));
}

#[cfg(test)]
mod tests {
    use super::{Failures, Tally, run};
    use crate::request::{Level, Progress, Request, Shard};
    use rand::RngExt;
    use rand::rngs::ChaCha8Rng;

    #[derive(Default, PartialEq, Debug)]
    struct Numbers(Vec<u32>);

    impl Tally for Numbers {
        fn join(&mut self, later: Self) {
            self.0.extend(later.0);
        }
    }

    fn numbers(seed: u64, shard: Shard, watch: &mut dyn FnMut(Progress) -> bool) -> (Vec<u32>, bool) {
        let config = Default::default();
        let mut request = Request { config, level: Level::Regression, jobs: None, seed, shard, proceed: watch };
        let (numbers, is_stopped) =
            run(&mut request, 7, 5000, |rng, numbers: &mut Numbers| numbers.0.push(rng.random())).expect("numbers");
        (numbers.0, is_stopped)
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
        let config = Default::default();
        let watch = &mut |_| false;
        let mut request =
            Request { config, level: Level::Regression, jobs: None, seed: 1, shard: Shard::ALL, proceed: watch };
        let case = |rng: &mut ChaCha8Rng, numbers: &mut Numbers| numbers.0.push(rng.random());
        let (some, is_stopped) = run(&mut request, 7, 1_000_000_000, case).expect("numbers");
        assert!(is_stopped && some.0.len() < 1_000_000_000, "{}", some.0.len());
    }

    #[test]
    fn the_first_failures_are_shown_and_all_are_counted() {
        let mut failures = Failures::default();
        for i in 0..4 {
            let mut later = Failures::default();
            (0..2).for_each(|j| later.add(|| format!("{i}{j}")));
            failures.join(later);
        }
        assert_eq!(failures.count(), 8);
        assert_eq!(failures.lines(), ["00", "01", "10", "11", "20", "and 3 more"]);
    }
}
