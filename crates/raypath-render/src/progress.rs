//! Long work that tells how far it is, and can be stopped.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use thiserror::Error;

/// The watch said to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("stopped")]
pub struct Stopped;

/// How much of something has been done, by several threads.
pub(crate) struct Progress<'w> {
    watch: &'w (dyn Fn(u64) -> bool + Sync),
    done: AtomicU64,
    stopped: AtomicBool,
}

impl<'w> Progress<'w> {
    pub(crate) fn new(watch: &'w (dyn Fn(u64) -> bool + Sync)) -> Self {
        Self { watch, done: AtomicU64::new(0), stopped: AtomicBool::new(false) }
    }

    /// Whether what has not begun need not begin.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// So many more are done.
    pub(crate) fn add(&self, items: u64) {
        let done = self.done.fetch_add(items, Ordering::Relaxed) + items;
        if !(self.watch)(done) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// An error if the work was stopped.
    pub(crate) fn finish(self) -> Result<(), Stopped> {
        if self.stopped.into_inner() { Err(Stopped) } else { Ok(()) }
    }
}
