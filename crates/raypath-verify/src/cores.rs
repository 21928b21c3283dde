//! Work that consists of numbered cases, done on all cores.

use crate::{Error, Request, Step, Verdict};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// How many failures are told; a campaign ends when it has found so many.
const MOST_FAILURES: usize = 10;

/// How often the watch is told.
const BETWEEN_STEPS: Duration = Duration::from_millis(100);

/// A campaign of one phase or several, each of cases with numbers from 0.
pub struct Campaign<'r, 'w> {
    request: &'r mut Request<'w>,
    total: u64,
    done: u64,
    failures: Vec<String>,
    is_stopped: bool,
}

/// Cases with numbers below `cases`, handed out in pieces of `piece`; the pieces are divided between shards.
#[derive(Debug, Clone, Copy)]
pub struct Phase {
    /// How many cases.
    pub cases: u64,
    /// How many cases a piece has; the last may have fewer.
    pub piece: u64,
}

impl Phase {
    fn pieces(self) -> u64 {
        self.cases.div_ceil(self.piece)
    }

    fn range(self, piece: u64) -> Range<u64> {
        piece * self.piece..self.cases.min((piece + 1) * self.piece)
    }

    /// How many of the cases the request's shard has.
    fn share(self, request: &Request<'_>) -> u64 {
        let lacking = self.pieces() * self.piece - self.cases;
        let has_last = self.pieces() > 0 && request.shard.takes(self.pieces() - 1);
        request.shard.share(self.pieces()) * self.piece - if has_last { lacking } else { 0 }
    }
}

impl<'r, 'w> Campaign<'r, 'w> {
    /// Begins a campaign that will have these phases.
    pub fn new(request: &'r mut Request<'w>, phases: &[Phase]) -> Self {
        let total = phases.iter().map(|phase| phase.share(request)).sum();
        Self { request, total, done: 0, failures: Vec::new(), is_stopped: false }
    }

    /// Runs a phase. Each core has what `begin` makes; `check` runs cases with it and gives what is wrong. Nothing
    /// happens where the user has stopped the campaign or enough is wrong already.
    pub fn run<W>(
        &mut self,
        phase: Phase,
        begin: impl Fn() -> Result<W, Error> + Sync,
        check: impl Fn(&mut W, Range<u64>) -> Vec<String> + Sync,
    ) -> Result<(), Error> {
        if self.is_over() {
            return Ok(());
        }
        let (next, end) = (AtomicU64::new(0), AtomicBool::new(false));
        let shard = self.request.shard;
        let work = |sender: mpsc::Sender<Result<(u64, Vec<String>), Error>>| {
            let mut worker = match begin() {
                Ok(worker) => worker,
                Err(error) => return drop(sender.send(Err(error))),
            };
            while !end.load(Ordering::Relaxed) {
                let piece = next.fetch_add(1, Ordering::Relaxed);
                if piece >= phase.pieces() {
                    return;
                }
                if shard.takes(piece) {
                    let range = phase.range(piece);
                    let cases = range.end - range.start;
                    if sender.send(Ok((cases, check(&mut worker, range)))).is_err() {
                        return;
                    }
                }
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            for _ in 0..cores {
                let (sender, work) = (sender.clone(), &work);
                scope.spawn(move || work(sender));
            }
            drop(sender);
            let result = self.collect(&receiver, &end);
            end.store(true, Ordering::Relaxed);
            result
        })
    }

    /// Gathers what the cores find, and tells the watch, until they have no more.
    fn collect(
        &mut self,
        receiver: &mpsc::Receiver<Result<(u64, Vec<String>), Error>>,
        end: &AtomicBool,
    ) -> Result<(), Error> {
        let mut told = std::time::Instant::now();
        loop {
            match receiver.recv_timeout(BETWEEN_STEPS) {
                Ok(result) => {
                    let (cases, failures) = result?;
                    self.done += cases;
                    self.failures.extend(failures);
                    self.failures.truncate(MOST_FAILURES);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if told.elapsed() >= BETWEEN_STEPS {
                told = std::time::Instant::now();
                self.is_stopped |= !(self.request.watch)(Step { done: self.done, total: self.total });
            }
            if self.is_over() {
                end.store(true, Ordering::Relaxed);
            }
        }
        (self.request.watch)(Step { done: self.done, total: self.total });
        Ok(())
    }

    fn is_over(&self) -> bool {
        self.is_stopped || self.failures.len() == MOST_FAILURES
    }

    /// How many cases have run.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Ends the campaign; `covered` says what its cases were.
    pub fn verdict(self, covered: String) -> Verdict {
        let is_cut_short = self.failures.len() == MOST_FAILURES && self.done < self.total;
        let remark = format!("ended after {} failures, with {} of {} cases run", MOST_FAILURES, self.done, self.total);
        Verdict {
            covered,
            failures: self.failures,
            remarks: is_cut_short.then_some(remark).into_iter().collect(),
            is_stopped: self.is_stopped && self.done < self.total,
        }
    }
}

/// A number with commas between its thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let places = digits.len();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (places - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Level, Shard};
    use raypath_rtl::Config;
    use std::sync::Mutex;

    fn with_request<T>(shard: &str, mut watch: impl FnMut(Step) -> bool, run: impl FnOnce(&mut Request<'_>) -> T) -> T {
        let shard: Shard = shard.parse().expect("a shard");
        let level = Level::Everyday;
        run(&mut Request { config: Config::default(), level, jobs: None, seed: 1, shard, watch: &mut watch })
    }

    #[test]
    fn shards_run_every_case_once() {
        let phase = Phase { cases: 1003, piece: 10 };
        let seen = Mutex::new(vec![0; 1003]);
        let mut covered = 0;
        for shard in ["1/3", "2/3", "3/3"] {
            let mut last = None;
            covered += with_request(
                shard,
                |step| {
                    last = Some(step);
                    true
                },
                |request| {
                    let mut campaign = Campaign::new(request, &[phase]);
                    let check = |_: &mut (), range: Range<u64>| {
                        let mut seen = seen.lock().expect("no panic");
                        range.for_each(|case| seen[case as usize] += 1);
                        Vec::new()
                    };
                    campaign.run(phase, || Ok(()), check).expect("a campaign");
                    assert_eq!(campaign.done(), campaign.total);
                    campaign.done()
                },
            );
            let last = last.expect("a step");
            assert_eq!(last.done, last.total);
        }
        assert_eq!(covered, 1003);
        assert!(seen.into_inner().expect("no panic").into_iter().all(|times| times == 1));
    }

    #[test]
    fn failures_and_the_user_end_it() {
        let phase = Phase { cases: 1 << 40, piece: 100 };
        let wrong = |_: &mut (), range: Range<u64>| vec![format!("{}", range.start)];
        let verdict = with_request(
            "1/1",
            |_| true,
            |request| {
                let mut campaign = Campaign::new(request, &[phase]);
                campaign.run(phase, || Ok(()), wrong).expect("a campaign");
                campaign.verdict(String::new())
            },
        );
        assert_eq!((verdict.failures.len(), verdict.is_stopped, verdict.remarks.len()), (MOST_FAILURES, false, 1));

        let verdict = with_request(
            "1/1",
            |_| false,
            |request| {
                let mut campaign = Campaign::new(request, &[phase, phase]);
                for _ in 0..2 {
                    campaign.run(phase, || Ok(()), |_, _| Vec::new()).expect("a campaign");
                }
                campaign.verdict(String::new())
            },
        );
        assert_eq!((verdict.failures.len(), verdict.is_stopped), (0, true));
    }

    #[test]
    fn thousands_are_grouped() {
        assert_eq!([0, 999, 1000, 7_496_192].map(grouped), ["0", "999", "1,000", "7,496,192"]);
    }
}
