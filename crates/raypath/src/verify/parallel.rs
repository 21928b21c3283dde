//! Work in numbered pieces, on all cores.

use raypath_verify::{Request, Step};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

/// Gives workers the numbers of their pieces, in order.
pub struct Queue {
    next: AtomicU64,
    taken: AtomicU64,
    total: u64,
    is_over: AtomicBool,
    shard: raypath_verify::Shard,
}

/// Bytes of a worker's stack: proofs descend from a netlist's outputs to its inputs.
const STACK: usize = 64 << 20;
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

impl Queue {
    /// The next piece of the shard, if there is one and nobody has called for a stop.
    pub fn next(&self) -> Option<u64> {
        while !self.is_over.load(Ordering::Relaxed) {
            let piece = self.next.fetch_add(1, Ordering::Relaxed);
            if piece >= self.total {
                return None;
            }
            if self.shard.takes(piece) {
                self.taken.fetch_add(1, Ordering::Relaxed);
                return Some(piece);
            }
        }
        None
    }

    /// No more pieces are given out. Pieces before any that was begun have been begun too.
    pub fn end(&self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

/// Runs a worker on each core, and tells `request.watch` how many of the shard's share of `total` pieces are begun. Gives
/// what each worker answers, and whether the user stopped it.
pub fn run<T: Send>(request: &mut Request<'_>, total: u64, work: impl Fn(&Queue) -> T + Sync) -> (Vec<T>, bool) {
    let share = request.shard.share(total);
    let queue = Queue {
        next: AtomicU64::new(0),
        taken: AtomicU64::new(0),
        total,
        is_over: AtomicBool::new(false),
        shard: request.shard,
    };
    let cores = thread::available_parallelism().map_or(1, usize::from).min(share.max(1) as usize);
    let mut is_stopped = false;
    let answers = thread::scope(|scope| {
        let worker = |_| thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || work(&queue));
        let started = |worker: std::io::Result<_>| worker.unwrap_or_else(|error| panic!("no thread: {error}"));
        let workers: Vec<thread::ScopedJoinHandle<'_, T>> = (0..cores).map(worker).map(started).collect();
        loop {
            let is_done = workers.iter().all(thread::ScopedJoinHandle::is_finished);
            let step = Step { done: queue.taken.load(Ordering::Relaxed), total: share };
            if !(request.watch)(step) && !is_done {
                is_stopped = true;
                queue.end();
            }
            if is_done {
                break;
            }
            thread::sleep(BETWEEN_LOOKS);
        }
        workers
            .into_iter()
            .map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    (answers, is_stopped)
}
