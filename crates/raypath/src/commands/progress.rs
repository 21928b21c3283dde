//! Work that says how far it has come, on any thread.

use crate::commands::Failure;
pub use raypath_cli::progress::Progress;
use raypath_cli::progress::{Stopped, is_stopped};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

impl From<Stopped> for Failure {
    fn from(stopped: Stopped) -> Self {
        Self::Interrupted(stopped.to_string())
    }
}

/// Does work that says how many items are done, on any thread, with progress shown; what it failed with, or that the user
/// stopped it.
pub fn watched<T, E: std::fmt::Display>(
    what: &'static str,
    total: usize,
    work: impl FnOnce(&(dyn Fn(u64) -> bool + Sync)) -> Result<T, E>,
) -> Result<T, Failure> {
    let progress = Mutex::new(Progress::new(what, total));
    let reached = AtomicU64::new(0);
    let watch = |done: u64| {
        reached.fetch_max(done, Ordering::Relaxed);
        // Whoever finds it in use has nothing to add.
        match progress.try_lock() {
            Ok(mut progress) => progress.at(done as usize),
            Err(_) => !is_stopped(),
        }
    };
    let result = work(&watch);
    let progress = progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.finish(reached.into_inner() as usize)?;
    result.map_err(Failure::unusable)
}
