//! Progress: a bar on a terminal, plain lines elsewhere. Ctrl-C stops the work.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thiserror::Error;

/// The progress of a long task.
pub struct Progress {
    what: &'static str,
    total: usize,
    bar: Option<ProgressBar>,
    /// Without a terminal: the time and the count of the last line.
    last_line: Instant,
    last_done: Option<usize>,
    begin: Instant,
}

/// The user stopped the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("after {done} of {total} {what}")]
pub struct Stopped {
    pub done: usize,
    pub total: usize,
    pub what: &'static str,
}

/// Whether the user pressed Ctrl-C: one flag for the program.
static STOPPED: AtomicBool = AtomicBool::new(false);

const BETWEEN_LINES: Duration = Duration::from_secs(5);

impl Progress {
    /// Starts the display. `what` names the items counted: "jobs".
    pub fn new(what: &'static str, total: usize) -> Self {
        // A second task cannot install a handler. The handler of the first sets the same flag.
        let _ = ctrlc::set_handler(|| STOPPED.store(true, Ordering::Relaxed));
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}  {per_sec}  {eta} left");
            let bar = ProgressBar::new(total as u64).with_message(what);
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self { what, total, bar, last_line: Instant::now(), last_done: None, begin: Instant::now() }
    }

    /// Shows that `done` items are done. Returns false if the user pressed Ctrl-C.
    pub fn at(&mut self, done: usize) -> bool {
        match &self.bar {
            Some(bar) => bar.set_position(done as u64),
            None if self.last_line.elapsed() > BETWEEN_LINES && self.last_done != Some(done) => {
                // A failed write of the progress does not stop the work.
                let rate = done as f64 / self.begin.elapsed().as_secs_f64();
                let left = self.total.saturating_sub(done) as f64 / rate;
                let pace = match done {
                    0 => String::new(),
                    _ if rate < 1.0 => format!(", {:.1} a minute, {left:.0} s left", 60.0 * rate),
                    _ => format!(", {rate:.0} a second, {left:.0} s left"),
                };
                let _ = writeln!(std::io::stderr(), "{done} of {} {}{pace}", self.total, self.what);
                self.last_line = Instant::now();
                self.last_done = Some(done);
            }
            None => {}
        }
        !is_stopped()
    }

    /// Ends; an error if the user stopped the work after `done` items.
    pub fn finish(self, done: usize) -> Result<(), Stopped> {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
        if is_stopped() { Err(Stopped { done, total: self.total, what: self.what }) } else { Ok(()) }
    }
}

pub fn is_stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}
