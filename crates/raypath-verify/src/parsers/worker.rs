//! A parser on a thread with a small stack and a watchdog, which detects panics, hangs and deep recursion.

use super::damage::mutated;
use super::targets::Target;
use crate::request::Shard;
use std::panic::catch_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// A quarter of a thread's default stack. A stack overflow ends the process.
const STACK: usize = 512 << 10;
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// The state of a worker.
pub enum Outcome {
    Busy,
    Done,
    /// An input made the parser panic or hang.
    Failed(String),
}

pub struct Worker {
    shared: Arc<Shared>,
    failure: Receiver<Option<String>>,
    /// The count of inputs at its last change, and the time of that change.
    last: (u64, Instant),
}

#[derive(Default)]
struct Shared {
    done: AtomicU64,
    accepted: AtomicU64,
    stop: AtomicBool,
    current: Mutex<Vec<u8>>,
}

impl Worker {
    /// Starts a thread that runs the files and this many mutations of each, those of the shard.
    pub fn start(target: Target, files: Vec<Vec<u8>>, mutations: u64, seed: u64, shard: Shard) -> Self {
        let shared = Arc::new(Shared::default());
        let (sender, failure) = channel();
        let theirs = shared.clone();
        let work = move || {
            // The receiver is gone if the worker has hung before.
            let _ = sender.send(feed(target, &files, mutations, (seed, shard), &theirs));
        };
        // If no thread starts, the channel is closed, which `wait` reports.
        drop(thread::Builder::new().stack_size(STACK).spawn(work));
        Self { shared, failure, last: (0, Instant::now()) }
    }

    /// Waits a moment. An input that takes more than `max_seconds` hangs.
    pub fn wait(&mut self, max_seconds: u64) -> Outcome {
        match self.failure.recv_timeout(POLL_INTERVAL) {
            Ok(None) => return Outcome::Done,
            Ok(Some(failure)) => return Outcome::Failed(failure),
            Err(RecvTimeoutError::Disconnected) => return Outcome::Failed("the thread ended".to_string()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if self.last.0 != self.done() {
            self.last = (self.done(), Instant::now());
        }
        if self.last.1.elapsed().as_secs() < max_seconds {
            return Outcome::Busy;
        }
        self.stop();
        let input = self.shared.current.lock().map(|input| input.clone()).unwrap_or_default();
        Outcome::Failed(format!("more than {max_seconds} s for {}", escaped(&input)))
    }

    pub fn done(&self) -> u64 {
        self.shared.done.load(Ordering::Relaxed)
    }

    pub fn accepted(&self) -> u64 {
        self.shared.accepted.load(Ordering::Relaxed)
    }

    /// Ends the thread after the current input.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }
}

fn feed(
    target: Target,
    files: &[Vec<u8>],
    mutations: u64,
    (seed, shard): (u64, Shard),
    shared: &Shared,
) -> Option<String> {
    for (file, bytes) in files.iter().enumerate() {
        for number in (0..=mutations).filter(|&number| shard.takes(number)) {
            if shared.stop.load(Ordering::Relaxed) {
                return None;
            }
            let input = if number == 0 { bytes.clone() } else { mutated(files, file, number, seed) };
            if let Ok(mut current) = shared.current.lock() {
                current.clone_from(&input);
            }
            match catch_unwind(|| (target.parse)(&input)) {
                Ok(accepted) => _ = shared.accepted.fetch_add(accepted.into(), Ordering::Relaxed),
                Err(_) => return Some(format!("panic on {} (file {file}, mutation {number})", escaped(&input))),
            }
            shared.done.fetch_add(1, Ordering::Relaxed);
        }
    }
    None
}

/// The printable form of an input's beginning.
fn escaped(input: &[u8]) -> String {
    let shown = input[..input.len().min(1000)].escape_ascii();
    format!("{} bytes b\"{shown}\"{}", input.len(), if input.len() > 1000 { "..." } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(parse: fn(&[u8]) -> bool, max_seconds: u64) -> Outcome {
        let target = Target { name: "test", format: "none", parse };
        let mut worker = Worker::start(target, vec![b"a file".to_vec()], 100, 1, Shard::ALL);
        loop {
            match worker.wait(max_seconds) {
                Outcome::Busy => {}
                Outcome::Done if worker.done() != 101 => panic!("{} inputs", worker.done()),
                outcome => return outcome,
            }
        }
    }

    #[test]
    fn panics_and_hangs_show() {
        assert!(matches!(outcome(|_| true, 10), Outcome::Done));
        let panics = |bytes: &[u8]| if bytes.len() > 20 { panic!("as wanted") } else { true };
        assert!(matches!(outcome(panics, 10), Outcome::Failed(why) if why.starts_with("panic on ")));
        let hangs = |bytes: &[u8]| {
            if bytes.len() > 20 {
                thread::sleep(Duration::from_secs(3));
            }
            true
        };
        assert!(matches!(outcome(hangs, 1), Outcome::Failed(why) if why.starts_with("more than 1 s for ")));
    }
}
