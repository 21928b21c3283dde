//! Long work beside the interpreter: Ctrl-C stops it.

use crate::error::exception;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use raypath_embed::Error;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// The time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(50);

/// Runs `work` on the threads of rayon, without the interpreter lock, and waits for it. `work` gets a callback to which
/// it reports its progress, and stops when the callback returns false. That is the case after a signal whose handler
/// raises an exception, as that of Ctrl-C does.
///
/// # Errors
/// The exception of the handler, or that of `work`.
pub fn watched<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn(u64) -> bool + Sync)) -> PyResult<T> + Send,
) -> PyResult<T> {
    let is_stopped = AtomicBool::new(false);
    py.detach(|| {
        let (sender, receiver) = mpsc::channel();
        pool()?.in_place_scope(|scope| {
            let is_stopped = &is_stopped;
            scope.spawn(move |_| {
                // The receiver is gone only if it has already stopped the work.
                let _ = sender.send(work(&|_| !is_stopped.load(Ordering::Relaxed)));
            });
            awaited(&receiver).inspect_err(|_| is_stopped.store(true, Ordering::Relaxed))
        })
    })
}

/// The threads of this process: a process that was forked has none of its parent's.
fn pool() -> PyResult<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*pool {
        Some((process, threads)) if *process == std::process::id() => Ok(threads.clone()),
        _ => {
            let threads = ThreadPoolBuilder::new().build();
            let threads = Arc::new(threads.map_err(|problem| PyRuntimeError::new_err(problem.to_string()))?);
            // The pool of the parent is not dropped, because dropping waits for its threads.
            std::mem::forget(pool.replace((std::process::id(), threads.clone())));
            Ok(threads)
        }
    }
}

/// As [`watched`], for work that nothing can stop: after a signal it goes on in a thread of its own, and its result is
/// dropped.
///
/// # Errors
/// Those of [`watched`].
pub fn abandoned_at_signals<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    py.detach(|| {
        let (sender, receiver) = mpsc::channel();
        let work = move || {
            // The receiver is gone after a signal.
            let _ = sender.send(work());
        };
        thread::Builder::new().spawn(work)?;
        awaited(&receiver)
    })
}

/// The result of work in another thread, or the exception of a signal that comes before it.
fn awaited<T>(receiver: &Receiver<PyResult<T>>) -> PyResult<T> {
    loop {
        match receiver.recv_timeout(PERIOD) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Disconnected) => return Err(PyRuntimeError::new_err("the work panicked")),
            Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
        }
    }
}

/// The jobs between two looks for signals: some milliseconds in binary32, a tenth of a second in other formats.
const PIECE: usize = 1 << 14;

/// Computes `count` jobs on this thread, without the interpreter lock, in pieces. `compute` gets the jobs of a piece.
///
/// # Errors
/// The exception of a signal's handler, or the error of `compute`.
pub fn in_pieces(
    py: Python<'_>,
    count: usize,
    mut compute: impl FnMut(Range<usize>) -> Result<(), Error> + Send,
) -> PyResult<()> {
    let mut first = 0;
    loop {
        let piece = first..count.min(first + PIECE);
        py.detach(|| compute(piece)).map_err(exception)?;
        first += PIECE;
        if first >= count {
            return Ok(());
        }
        py.check_signals()?;
    }
}
