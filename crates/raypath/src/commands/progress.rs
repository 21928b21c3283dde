//! Progress: a bar on a terminal, plain lines elsewhere. Ctrl-C asks the work to stop.

use crate::commands::Failure;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How far a long piece of work has come.
pub struct Progress {
    what: &'static str,
    total: usize,
    bar: Option<ProgressBar>,
    /// Elsewhere than on a terminal: when the last line was printed, and what it counted.
    last_line: Instant,
    last_done: Option<usize>,
    begin: Instant,
}

/// Whether the user has asked to stop. One for the program, as Ctrl-C is.
static STOPPED: AtomicBool = AtomicBool::new(false);

const BETWEEN_LINES: Duration = Duration::from_secs(5);

impl Progress {
    /// Begins. `what` names the items counted: "jobs".
    pub fn new(what: &'static str, total: usize) -> Self {
        // A second piece of work finds the handler of the first, which is refused another and does the same.
        let _ = ctrlc::set_handler(|| STOPPED.store(true, Ordering::Relaxed));
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}  {per_sec}  {eta} left");
            let bar = ProgressBar::new(total as u64).with_message(what);
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self { what, total, bar, last_line: Instant::now(), last_done: None, begin: Instant::now() }
    }

    /// `done` items are done. False where the user wants to stop.
    pub fn at(&mut self, done: usize) -> bool {
        match &self.bar {
            Some(bar) => bar.set_position(done as u64),
            None if self.last_line.elapsed() > BETWEEN_LINES && self.last_done != Some(done) => {
                // Progress that nobody can read is no reason to stop.
                let rate = done as f64 / self.begin.elapsed().as_secs_f64();
                let left = self.total.saturating_sub(done) as f64 / rate;
                let pace = if done == 0 { String::new() } else { format!(", {rate:.0}/s, {left:.0} s left") };
                let _ = writeln!(std::io::stderr(), "{done} of {} {}{pace}", self.total, self.what);
                self.last_line = Instant::now();
                self.last_done = Some(done);
            }
            None => {}
        }
        !STOPPED.load(Ordering::Relaxed)
    }

    /// Ends; an error where the user stopped the work after `done` items.
    pub fn finish(self, done: usize) -> Result<(), Failure> {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
        if STOPPED.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted(format!("after {done} of {} {}", self.total, self.what)));
        }
        Ok(())
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
            Err(_) => !STOPPED.load(Ordering::Relaxed),
        }
    };
    let result = work(&watch);
    let progress = progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.finish(reached.into_inner() as usize)?;
    result.map_err(Failure::unusable)
}
