//! The pool of workers: numbered cases on several threads, with progress and cancellation.
//!
//! The threads are rayon's. Cases begin in the order of their numbers, so that all cases before a case that has run
//! have run too: the first failure does not depend on the number of workers.

use rayon::ThreadPoolBuilder;
use raypath_tools::ToolError;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use thiserror::Error;

/// Bytes of a worker's stack: proofs recurse from a netlist's outputs to its inputs.
const STACK: usize = 64 << 20;

/// One thread for each core.
pub const ALL_CORES: usize = 0;

/// How often progress is reported.
const REPORT_INTERVAL: Duration = Duration::from_millis(100);

/// The cases with numbers below `total` that belong to a shard. Workers take them in pieces.
#[derive(Debug, Clone, Copy)]
pub struct Cases {
    /// How many cases all shards have together.
    pub total: u64,
    /// The cases in a piece; the last piece may have fewer.
    pub piece: u64,
    /// The part of the pieces to run.
    pub shard: Shard,
}

impl Cases {
    /// The number of pieces that all shards have together.
    fn pieces(self) -> u64 {
        self.total.div_ceil(self.piece)
    }

    /// The cases of the piece with this number.
    pub fn range(self, piece: u64) -> Range<u64> {
        piece * self.piece..self.total.min((piece + 1) * self.piece)
    }

    /// How many of the cases belong to the shard.
    pub fn share(self) -> u64 {
        let lacking = self.pieces() * self.piece - self.total;
        let has_last = self.pieces() > 0 && self.shard.takes(self.pieces() - 1);
        self.shard.share(self.pieces()) * self.piece - if has_last { lacking } else { 0 }
    }
}

/// The cases of a run that no worker has taken yet.
#[derive(Debug)]
pub struct Queue<E> {
    cases: Cases,
    next: AtomicU64,
    done: AtomicU64,
    stop: AtomicBool,
    /// The smallest number of a piece that failed, and its error.
    failure: Mutex<Option<(u64, E)>>,
}

impl<E> Queue<E> {
    /// Runs pieces until none is left or the run ends. `piece` gets a piece's number, and the flag that ends the run:
    /// it may set it, and returns early when it is set. An error ends the run too.
    pub fn run(&self, mut piece: impl FnMut(u64, &AtomicBool) -> Result<(), E>) {
        self.run_counted(|number, stop| piece(number, stop).map(|()| true));
    }

    /// Like `run`; `piece` returns whether the piece has run to its end.
    fn run_counted(&self, mut piece: impl FnMut(u64, &AtomicBool) -> Result<bool, E>) {
        while let Some(number) = self.take() {
            let Range { start, end } = self.cases.range(number);
            match piece(number, &self.stop) {
                Ok(is_done) => _ = self.done.fetch_add(if is_done { end - start } else { 0 }, Ordering::Relaxed),
                Err(error) => self.fail(number, error),
            }
        }
    }

    fn take(&self) -> Option<u64> {
        while !self.stop.load(Ordering::Relaxed) {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            if number >= self.cases.pieces() {
                return None;
            }
            if self.cases.shard.takes(number) {
                return Some(number);
            }
        }
        None
    }

    fn fail(&self, number: u64, error: E) {
        self.stop.store(true, Ordering::Relaxed);
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if failure.as_ref().is_none_or(|(first, _)| number < *first) {
            *failure = Some((number, error));
        }
    }

    fn progress(&self) -> Progress {
        Progress { done: self.done.load(Ordering::Relaxed), total: self.cases.share() }
    }
}

/// What the workers of a run return.
#[derive(Debug)]
pub struct Finished<T> {
    /// The result of each worker, in no particular order.
    pub workers: Vec<T>,
    /// The number of cases that have run.
    pub done: u64,
    /// Whether `proceed` ended the run before all cases had run.
    pub is_stopped: bool,
}

/// Runs cases on `threads` threads ([`ALL_CORES`]: one for each core). Each worker prepares its state and calls
/// [`Queue::run`]. `proceed` is called on this thread several times a second with the number of cases that have run. If
/// it returns false, the run ends.
///
/// # Errors
/// The error of the case with the smallest number that failed, or of a worker's preparation.
pub fn run<T: Send, E: Send + From<ToolError>>(
    cases: Cases,
    threads: usize,
    proceed: &mut dyn FnMut(Progress) -> bool,
    worker: impl Fn(&Queue<E>) -> Result<T, E> + Sync,
) -> Result<Finished<T>, E> {
    let zero = || AtomicU64::new(0);
    let queue = Queue { cases, next: zero(), done: zero(), stop: AtomicBool::new(false), failure: Mutex::new(None) };
    // The user can stop before anything runs.
    let mut is_stopped = !proceed(queue.progress());
    queue.stop.store(is_stopped, Ordering::Relaxed);
    let no_threads = |problem: rayon::ThreadPoolBuildError| {
        ToolError::unexpected("rayon", problem.to_string(), "a thread for each core")
    };
    let threads = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build().map_err(no_threads)?;
    let (sender, receiver) = channel();
    let mut workers = Vec::new();
    threads.in_place_scope(|scope| {
        let (queue, worker) = (&queue, &worker);
        scope.spawn_broadcast(move |_, _| match worker(queue) {
            // The receiver lives until all senders are gone.
            Ok(result) => _ = sender.send(result),
            Err(error) => queue.fail(u64::MAX, error),
        });
        loop {
            match receiver.recv_timeout(REPORT_INTERVAL) {
                Ok(result) => workers.push(result),
                Err(RecvTimeoutError::Timeout) => {
                    if !proceed(queue.progress()) {
                        is_stopped = true;
                        queue.stop.store(true, Ordering::Relaxed);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    });
    let Progress { done, total } = queue.progress();
    let _ = proceed(queue.progress());
    match queue.failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some((_, error)) => Err(error),
        None => Ok(Finished { workers, done, is_stopped: is_stopped && done < total }),
    }
}

/// Runs `run` on each item and returns the results in the items' order: none for an item that had not begun when the
/// run was stopped, or for which `run` returned none.
///
/// # Errors
/// The error of the first item that failed.
pub fn map<I: Sync, T: Send, E: Send + From<ToolError>>(
    items: &[I],
    threads: usize,
    proceed: &mut dyn FnMut(Progress) -> bool,
    run: impl Fn(&I, &AtomicBool) -> Result<Option<T>, E> + Sync,
) -> Result<Vec<Option<T>>, E> {
    let finished = self::run::<_, E>(
        Cases { total: items.len() as u64, piece: 1, shard: Shard::ALL },
        threads,
        proceed,
        |queue| {
            let mut results = Vec::new();
            queue.run_counted(|number, stop| {
                let index = number as usize;
                let result = run(&items[index], stop)?;
                let is_done = result.is_some();
                results.push((index, result));
                Ok(is_done)
            });
            Ok(results)
        },
    )?;
    let mut in_order: Vec<Option<T>> = items.iter().map(|_| None).collect();
    finished.workers.into_iter().flatten().for_each(|(index, result)| in_order[index] = result);
    Ok(in_order)
}

/// How much of the work is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Cases that have run.
    pub done: u64,
    /// Cases to run.
    pub total: u64,
}

/// One of several equal parts of the work, so that machines can divide it: `2/5` is the second of five.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// A text that names no shard.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is not a valid shard, expected i/n with 1 ≤ i ≤ n, such as 2/5")]
pub struct ShardError(String);

impl Shard {
    /// The whole of the work.
    pub const ALL: Self = Self { number: 0, of: 1 };

    /// Whether the case with this number belongs to the shard. Each number belongs to one of the n shards.
    pub fn takes(self, number: u64) -> bool {
        number % self.of == self.number
    }

    /// The items whose positions belong to the shard.
    pub fn of<T>(self, items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        (0..).zip(items).filter(move |(number, _)| self.takes(*number)).map(|(_, item)| item)
    }

    /// How many of the numbers below `total` belong to the shard.
    pub fn share(self, total: u64) -> u64 {
        total / self.of + u64::from(total % self.of > self.number)
    }

    /// The shard's number, from 0.
    pub fn number(self) -> u64 {
        self.number
    }

    /// The number of shards.
    pub fn count(self) -> u64 {
        self.of
    }

    /// The shard's contiguous share of the numbers below `total`. The shares follow each other in the order of the
    /// shards.
    pub fn range(self, total: u64) -> Range<u64> {
        let begin = |number: u64| (u128::from(total) * u128::from(number) / u128::from(self.of)) as u64;
        begin(self.number)..begin(self.number + 1)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order_and_a_stop_leaves_the_rest_out() {
        let items: Vec<usize> = (0..100).collect();
        let mut last = 0;
        let mut watch = |progress: Progress| {
            assert!(progress.done >= last && progress.total == 100);
            last = progress.done;
            true
        };
        let all = map(&items, ALL_CORES, &mut watch, |item, _| Ok::<_, ToolError>(Some(item * 2))).expect("results");
        assert_eq!(all, items.iter().map(|item| Some(item * 2)).collect::<Vec<_>>());
        assert_eq!(last, 100);
        assert!(
            map(&[] as &[usize], ALL_CORES, &mut |_| true, |item, _| Ok::<_, ToolError>(Some(*item)))
                .expect("nothing")
                .is_empty()
        );

        let until_stopped = |_: &usize, stop: &AtomicBool| -> Result<Option<()>, ToolError> {
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(None)
        };
        let mut reports = 0;
        let mut watch = |progress: Progress| {
            assert_eq!(progress.done, 0, "an item that was stopped counts as done");
            reports += 1;
            reports < 3
        };
        assert_eq!(map(&items, ALL_CORES, &mut watch, until_stopped).expect("nothing"), vec![None; 100]);
    }

    #[test]
    fn the_first_failure_stops_the_others_and_is_returned() {
        let error = |item: usize| ToolError::unexpected("a program", item.to_string(), "");
        let items: Vec<usize> = (0..10_000).collect();
        let fail = |&item: &usize, _: &AtomicBool| if item >= 17 { Err(error(item)) } else { Ok(Some(())) };
        let found = map(&items, ALL_CORES, &mut |_| true, fail).expect_err("a failure");
        assert!(found.to_string().contains("17"), "{found}");
    }

    #[test]
    fn each_worker_keeps_its_state_and_a_shard_has_its_cases() {
        let shard = "2/3".parse().expect("a shard");
        let finished = run(Cases { total: 1000, piece: 1, shard }, 3, &mut |_| true, |queue| {
            let mut seen = Vec::new();
            queue.run(|number, _| {
                seen.push(number);
                Ok(())
            });
            Ok::<_, ToolError>(seen)
        });
        let finished = finished.expect("numbers");
        let mut seen = finished.workers.concat();
        seen.sort_unstable();
        assert_eq!(seen, (0..1000).filter(|number| number % 3 == 1).collect::<Vec<_>>());
        assert!(!finished.is_stopped);
    }

    #[test]
    fn shards_divide_the_work() {
        for of in 1..=7 {
            let shards: Vec<Shard> = (1..=of).map(|i| format!("{i}/{of}").parse().expect("a shard")).collect();
            for total in 0..30 {
                let of_each = |shard: &Shard| (0..total).filter(|&item| shard.takes(item)).count() as u64;
                assert!(shards.iter().all(|shard| of_each(shard) == shard.share(total)), "{of}, {total}");
                assert_eq!(shards.iter().map(|shard| shard.share(total)).sum::<u64>(), total);
                let ranges = shards.iter().flat_map(|shard| shard.range(total));
                assert!(ranges.eq(0..total), "{of}, {total}");
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
