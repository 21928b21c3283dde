//! Numbered cases in phases, on all cores.

use raypath_verify::{Error, Progress, Request, Verdict};
use raypath_work::pool::{self, Cases};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many failures are listed; a campaign ends when it has found as many.
const MAX_FAILURES: usize = 10;

/// A campaign of one or several phases, each of cases with numbers from 0.
pub struct Campaign<'r, 'w> {
    request: &'r mut Request<'w>,
    total: u64,
    done: u64,
    failures: Vec<String>,
    is_stopped: bool,
}

impl<'r, 'w> Campaign<'r, 'w> {
    /// Begins a campaign of these phases.
    pub fn new(request: &'r mut Request<'w>, phases: &[Cases]) -> Self {
        let total = phases.iter().map(|phase| phase.share()).sum();
        Self { request, total, done: 0, failures: Vec::new(), is_stopped: false }
    }

    /// Runs a phase. Each worker has a state, which `begin` makes; `check` runs cases with it and returns the failures.
    /// Does nothing if the user has stopped the campaign or it has found enough failures.
    pub fn run<W>(
        &mut self,
        phase: Cases,
        begin: impl Fn() -> Result<W, Error> + Sync,
        check: impl Fn(&mut W, Range<u64>) -> Vec<String> + Sync,
    ) -> Result<(), Error> {
        if self.is_over() {
            return Ok(());
        }
        let (before, total) = (self.done, self.total);
        let found = AtomicUsize::new(self.failures.len());
        let mut proceed = |phase: Progress| (self.request.proceed)(Progress { done: before + phase.done, total });
        let is_stopped = &mut self.is_stopped;
        let shards = self.request.parts.phase(|| {
            let finished = pool::run::<_, Error>(phase, pool::ALL_CORES, &mut proceed, |queue| {
                let (mut worker, mut failures) = (begin()?, Vec::new());
                queue.run(|piece, stop| {
                    let failed = check(&mut worker, phase.range(piece));
                    if found.fetch_add(failed.len(), Ordering::Relaxed) + failed.len() >= MAX_FAILURES {
                        stop.store(true, Ordering::Relaxed);
                    }
                    failures.extend(failed.into_iter().map(|failure| (piece, failure)));
                    Ok(())
                });
                Ok(failures)
            })?;
            *is_stopped |= finished.is_stopped;
            Ok::<_, Error>((finished.done, finished.workers.concat()))
        })?;
        self.done += shards.iter().map(|(done, _)| done).sum::<u64>();
        let mut failures: Vec<(u64, String)> = shards.into_iter().flat_map(|(_, failures)| failures).collect();
        failures.sort_by_key(|(piece, _)| *piece);
        self.failures.extend(failures.into_iter().map(|(_, failure)| failure));
        self.failures.truncate(MAX_FAILURES);
        Ok(())
    }

    fn is_over(&self) -> bool {
        self.is_stopped || self.failures.len() == MAX_FAILURES
    }

    pub fn done(&self) -> u64 {
        self.done
    }

    /// Ends the campaign; `covered` describes its cases.
    pub fn verdict(self, covered: String) -> Verdict {
        let is_cut_short = self.failures.len() == MAX_FAILURES && self.done < self.total;
        let remark = format!("ended after {} failures, with {} of {} cases run", MAX_FAILURES, self.done, self.total);
        Verdict {
            covered,
            failures: self.failures,
            remarks: is_cut_short.then_some(remark).into_iter().collect(),
            is_stopped: self.is_stopped && self.done < self.total,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn shards_run_every_case_once() {
        let seen = Mutex::new(vec![0; 1003]);
        for shard in ["1/3", "2/3", "3/3"] {
            let mut watch = |_| true;
            let mut request = Request { shard: shard.parse().expect("a shard"), ..Request::new(&mut watch) };
            let phase = request.cases(1003, 10);
            let mut campaign = Campaign::new(&mut request, &[phase]);
            let check = |_: &mut (), range: Range<u64>| {
                let mut seen = seen.lock().expect("no panic");
                range.for_each(|case| seen[case as usize] += 1);
                Vec::new()
            };
            campaign.run(phase, || Ok(()), check).expect("a campaign");
            assert_eq!(campaign.done(), campaign.total);
        }
        assert!(seen.into_inner().expect("no panic").into_iter().all(|times| times == 1));
    }

    #[test]
    fn failures_and_the_user_end_it() {
        let verdict = |goes_on: bool, phases: usize, check: fn(&mut (), Range<u64>) -> Vec<String>| {
            let mut watch = |_| goes_on;
            let mut request = Request::new(&mut watch);
            let phase = request.cases(1 << 40, 100);
            let mut campaign = Campaign::new(&mut request, &vec![phase; phases]);
            (0..phases).for_each(|_| campaign.run(phase, || Ok(()), check).expect("a campaign"));
            campaign.verdict(String::new())
        };
        let failed = verdict(true, 1, |_, range| vec![format!("{}", range.start)]);
        assert_eq!((failed.failures.len(), failed.is_stopped, failed.remarks.len()), (MAX_FAILURES, false, 1));
        let stopped = verdict(false, 2, |_, _| Vec::new());
        assert_eq!((stopped.failures.len(), stopped.is_stopped), (0, true));
    }
}
