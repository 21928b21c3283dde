//! The pool of workers: numbered cases on all cores, with progress and cancellation.
//!
//! The threads are rayon's. Cases begin in the order of their numbers, so that all cases before a case that has run
//! have run too: the first failure does not depend on the number of workers.

use crate::error::Error;
use crate::request::{Progress, Shard};
use rayon::ThreadPoolBuilder;
use raypath_tools::ToolError;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Bytes of a worker's stack: proofs recurse from a netlist's outputs to its inputs.
const STACK: usize = 64 << 20;

/// How often progress is reported.
const REPORT_INTERVAL: Duration = Duration::from_millis(100);

/// The cases with numbers below `total` that belong to a shard.
#[derive(Debug, Clone, Copy)]
pub struct Cases {
    /// How many cases all shards have together.
    pub total: u64,
    /// The part of them to run.
    pub shard: Shard,
}

/// The cases of a run that no worker has taken yet.
#[derive(Debug)]
pub struct Queue {
    cases: Cases,
    next: AtomicU64,
    done: AtomicU64,
    stop: AtomicBool,
    /// The smallest number of a case that failed, and its error.
    failure: Mutex<Option<(u64, Error)>>,
}

impl Queue {
    /// Runs cases until none is left or the run ends. `case` is also given the flag that ends the run: it may set it,
    /// and returns early when it is set. An error ends the run too.
    pub fn run(&self, mut case: impl FnMut(u64, &AtomicBool) -> Result<(), Error>) {
        while let Some(number) = self.take() {
            match case(number, &self.stop) {
                Ok(()) => _ = self.done.fetch_add(1, Ordering::Relaxed),
                Err(error) => self.fail(number, error),
            }
        }
    }

    fn take(&self) -> Option<u64> {
        while !self.stop.load(Ordering::Relaxed) {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            if number >= self.cases.total {
                return None;
            }
            if self.cases.shard.takes(number) {
                return Some(number);
            }
        }
        None
    }

    fn fail(&self, number: u64, error: Error) {
        self.stop.store(true, Ordering::Relaxed);
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if failure.as_ref().is_none_or(|(first, _)| number < *first) {
            *failure = Some((number, error));
        }
    }

    fn progress(&self) -> Progress {
        Progress { done: self.done.load(Ordering::Relaxed), total: self.cases.shard.share(self.cases.total) }
    }
}

/// What the workers of a run return.
#[derive(Debug)]
pub struct Finished<T> {
    /// The result of each worker, in no particular order.
    pub workers: Vec<T>,
    /// Whether `proceed` ended the run before all cases had run.
    pub is_stopped: bool,
}

/// Runs cases on all cores: each worker prepares its state and calls [`Queue::run`]. `proceed` is called on this thread
/// several times a second with the number of cases that have run; when it returns false, the run ends.
///
/// # Errors
/// The error of the case with the smallest number that failed, or of a worker's preparation.
pub fn run<T: Send>(
    cases: Cases,
    proceed: &mut dyn FnMut(Progress) -> bool,
    worker: impl Fn(&Queue) -> Result<T, Error> + Sync,
) -> Result<Finished<T>, Error> {
    let zero = || AtomicU64::new(0);
    let queue = Queue { cases, next: zero(), done: zero(), stop: AtomicBool::new(false), failure: Mutex::new(None) };
    // The user can stop before anything runs.
    let mut is_stopped = !proceed(queue.progress());
    queue.stop.store(is_stopped, Ordering::Relaxed);
    let no_threads = |problem: rayon::ThreadPoolBuildError| {
        ToolError::unexpected("rayon", problem.to_string(), "a thread for each core")
    };
    let threads = ThreadPoolBuilder::new().stack_size(STACK).build().map_err(no_threads)?;
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
        None => Ok(Finished { workers, is_stopped: is_stopped && done < total }),
    }
}

/// Runs `run` on each item and returns the results in the items' order: none for an item that had not begun when the
/// run was stopped, or for which `run` returned none.
///
/// # Errors
/// The error of the first item that failed.
pub fn map<I: Sync, T: Send>(
    items: &[I],
    proceed: &mut dyn FnMut(Progress) -> bool,
    run: impl Fn(&I, &AtomicBool) -> Result<Option<T>, Error> + Sync,
) -> Result<Vec<Option<T>>, Error> {
    let finished = self::run(Cases { total: items.len() as u64, shard: Shard::ALL }, proceed, |queue| {
        let mut results = Vec::new();
        queue.run(|number, stop| {
            let index = number as usize;
            results.push((index, run(&items[index], stop)?));
            Ok(())
        });
        Ok(results)
    })?;
    let mut in_order: Vec<Option<T>> = items.iter().map(|_| None).collect();
    finished.workers.into_iter().flatten().for_each(|(index, result)| in_order[index] = result);
    Ok(in_order)
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
        let all = map(&items, &mut watch, |item, _| Ok(Some(item * 2))).expect("results");
        assert_eq!(all, items.iter().map(|item| Some(item * 2)).collect::<Vec<_>>());
        assert_eq!(last, 100);
        assert!(map(&[] as &[usize], &mut |_| true, |item, _| Ok(Some(*item))).expect("nothing").is_empty());

        let until_stopped = |_: &usize, stop: &AtomicBool| -> Result<Option<()>, Error> {
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(None)
        };
        let mut reports = 0;
        let mut watch = |_| {
            reports += 1;
            reports < 3
        };
        assert_eq!(map(&items, &mut watch, until_stopped).expect("nothing"), vec![None; 100]);
    }

    #[test]
    fn the_first_failure_stops_the_others_and_is_returned() {
        let error = |item: usize| Error::Program {
            program: format!("{item}"),
            problem: String::new(),
            expected: String::new(),
        };
        let items: Vec<usize> = (0..10_000).collect();
        let fail = |&item: &usize, _: &AtomicBool| if item >= 17 { Err(error(item)) } else { Ok(Some(())) };
        let found = map(&items, &mut |_| true, fail).expect_err("a failure");
        assert!(matches!(&found, Error::Program { program, .. } if program == "17"), "{found}");
    }

    #[test]
    fn each_worker_keeps_its_state_and_a_shard_has_its_cases() {
        let shard = "2/3".parse().expect("a shard");
        let finished = run(Cases { total: 1000, shard }, &mut |_| true, |queue| {
            let mut seen = Vec::new();
            queue.run(|number, _| {
                seen.push(number);
                Ok(())
            });
            Ok(seen)
        });
        let finished = finished.expect("numbers");
        let mut seen = finished.workers.concat();
        seen.sort_unstable();
        assert_eq!(seen, (0..1000).filter(|number| number % 3 == 1).collect::<Vec<_>>());
        assert!(!finished.is_stopped);
    }
}
