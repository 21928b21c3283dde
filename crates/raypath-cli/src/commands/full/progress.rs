//! Progress of work on several threads.

use crate::{CliError, Progress, is_stopped};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Runs `work`, which reports from any thread how many of `total` items are done, and shows its progress.
pub fn watched<T, E: Into<CliError>>(
    what: &'static str,
    total: usize,
    work: impl FnOnce(&(dyn Fn(u64) -> bool + Sync)) -> Result<T, E>,
) -> Result<T, CliError> {
    let progress = Mutex::new(Progress::new(what, total));
    let reached = AtomicU64::new(0);
    let watch = |done: u64| {
        reached.fetch_max(done, Ordering::Relaxed);
        // A thread does not wait for the bar if another one uses it.
        match progress.try_lock() {
            Ok(mut progress) => progress.at(done as usize),
            Err(_) => !is_stopped(),
        }
    };
    let result = work(&watch);
    let progress = progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.finish(reached.into_inner() as usize)?;
    result.map_err(E::into)
}
