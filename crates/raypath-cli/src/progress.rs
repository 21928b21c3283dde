//! Progress: a line that changes on a terminal, lines elsewhere. Ctrl-C stops the work.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thiserror::Error;

/// The progress of a long task.
pub struct Progress {
    what: &'static str,
    total: usize,
    is_terminal: bool,
    begin: Instant,
    /// The time and the count of the last line.
    last_line: Instant,
    last_done: Option<usize>,
    /// The length of the line on the terminal.
    shown: usize,
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
/// On a terminal.
const BETWEEN_CHANGES: Duration = Duration::from_millis(100);
/// The characters of the bar on a terminal.
const BAR: usize = 20;

impl Progress {
    /// Starts the display. `what` names the items counted: "jobs".
    pub fn new(what: &'static str, total: usize) -> Self {
        // A second task cannot install a handler. The handler of the first sets the same flag.
        let _ = ctrlc::set_handler(|| STOPPED.store(true, Ordering::Relaxed));
        let (now, is_terminal) = (Instant::now(), std::io::stderr().is_terminal());
        Self { what, total, is_terminal, begin: now, last_line: now, last_done: None, shown: 0 }
    }

    /// Sets the number of items. A new number begins another phase of the task, with a pace of its own.
    #[cfg(feature = "verify")]
    pub fn of(&mut self, total: usize) -> &mut Self {
        if self.total != total {
            (self.total, self.begin) = (total, Instant::now());
        }
        self
    }

    /// Shows that `done` items are done. Returns false if the user pressed Ctrl-C.
    pub fn at(&mut self, done: usize) -> bool {
        let pause = if self.is_terminal { BETWEEN_CHANGES } else { BETWEEN_LINES };
        if self.last_line.elapsed() > pause && self.last_done != Some(done) {
            let line = line(done, self.total, self.what, self.begin.elapsed().as_secs_f64());
            // A failed write of the progress does not stop the work.
            let _ = match self.is_terminal {
                true => self.change(&format!("{} {line}", bar(done, self.total))),
                false => writeln!(std::io::stderr(), "{line}"),
            };
            self.last_line = Instant::now();
            self.last_done = Some(done);
        }
        !is_stopped()
    }

    /// Writes a line over the last one. Spaces erase what is longer.
    fn change(&mut self, line: &str) -> std::io::Result<()> {
        let width = self.shown;
        self.shown = line.len();
        write!(std::io::stderr(), "\r{line:width$}")
    }

    /// Ends; an error if the user stopped the work after `done` items.
    pub fn finish(mut self, done: usize) -> Result<(), Stopped> {
        if self.shown > 0 {
            // As above.
            let _ = self.change("").and_then(|()| write!(std::io::stderr(), "\r"));
        }
        if is_stopped() { Err(Stopped { done, total: self.total, what: self.what }) } else { Ok(()) }
    }
}

pub fn is_stopped() -> bool {
    STOPPED.load(Ordering::Relaxed)
}

/// What is done, how fast, and how long the rest takes.
fn line(done: usize, total: usize, what: &str, seconds: f64) -> String {
    let rate = done as f64 / seconds;
    let left = total.saturating_sub(done) as f64 / rate;
    let pace = match done {
        0 => String::new(),
        _ if rate < 1.0 => format!(", {:.1} a minute, {left:.0} s left", 60.0 * rate),
        _ => format!(", {rate:.0} a second, {left:.0} s left"),
    };
    format!("{done} of {total} {what}{pace}")
}

/// The share that is done as a bar.
fn bar(done: usize, total: usize) -> String {
    let filled = (BAR * done.min(total)).checked_div(total).unwrap_or(BAR);
    format!("[{}{}]", "#".repeat(filled), " ".repeat(BAR - filled))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_the_pace() {
        assert_eq!(line(0, 10, "jobs", 0.0), "0 of 10 jobs");
        assert_eq!(line(30, 40, "jobs", 10.0), "30 of 40 jobs, 3 a second, 3 s left");
        assert_eq!(line(1, 4, "parts", 20.0), "1 of 4 parts, 3.0 a minute, 60 s left");
    }

    #[test]
    #[cfg(feature = "full")]
    fn a_phase_counts_its_own_items() {
        let mut progress = Progress::new("unit", 108);
        let begin = progress.begin;
        assert_eq!(progress.of(108).begin, begin);
        progress.of(8_000);
        assert_eq!(progress.total, 8_000);
        assert!(progress.begin > begin);
    }

    #[test]
    fn the_bar_is_empty_at_first_and_full_at_the_end() {
        assert_eq!(bar(0, 9), format!("[{}]", " ".repeat(BAR)));
        assert_eq!(bar(1, 2), format!("[{}{}]", "#".repeat(BAR / 2), " ".repeat(BAR / 2)));
        for (done, total) in [(9, 9), (10, 9), (0, 0)] {
            assert_eq!(bar(done, total), format!("[{}]", "#".repeat(BAR)));
        }
    }
}
