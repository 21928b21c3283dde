//! Work on several threads of a pool, watched from the calling thread.

use raypath_tools::ToolError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Calls `work` for each item, on a pool of `threads` threads, items in order. Returns the results in the order of the
/// items; None for items that were not begun or gave no result.
///
/// `proceed` is called on the calling thread several times a second with the number of results so far. If it returns
/// false, or an item fails, no further item begins, and the flag that `work` gets is set.
///
/// # Errors
/// The first error of an item; the threads cannot start.
pub fn map<I: Sync, T: Send, E: Send + From<ToolError>>(
    items: &[I],
    threads: usize,
    work: impl Fn(&I, &AtomicBool) -> Result<Option<T>, E> + Sync,
    mut proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<Option<T>>, E> {
    let stop = AtomicBool::new(!proceed(0));
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let mut failure: Option<E> = None;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.clamp(1, items.len().max(1))).build();
    let no_threads = |problem: rayon::ThreadPoolBuildError| {
        ToolError::unexpected("rayon", problem.to_string(), format!("{threads} threads"))
    };
    let (stop, work) = (&stop, &work);
    pool.map_err(no_threads)?.in_place_scope_fifo(|scope| {
        let (sender, receiver) = mpsc::channel();
        for (index, item) in items.iter().enumerate() {
            let sender = sender.clone();
            scope.spawn_fifo(move |_| {
                if !stop.load(Ordering::Relaxed) {
                    // The receiver lives until all senders are gone.
                    let _ = sender.send((index, work(item, stop)));
                }
            });
        }
        drop(sender);
        let mut done = 0;
        loop {
            match receiver.recv_timeout(PROGRESS_INTERVAL) {
                Ok((index, Ok(result))) => {
                    done += usize::from(result.is_some());
                    results[index] = result;
                }
                Ok((_, Err(error))) => {
                    stop.store(true, Ordering::Relaxed);
                    failure.get_or_insert(error);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if !proceed(done) {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    failure.map_or(Ok(results), Err)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn until_stopped(stop: &AtomicBool) -> Result<Option<usize>, ToolError> {
        while !stop.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(None)
    }

    #[test]
    fn results_keep_their_order() {
        let items: Vec<usize> = (0..100).collect();
        let mut last = 0;
        let watch = |done: usize| {
            assert!(done >= last);
            last = done;
            true
        };
        let results = map(&items, 7, |item, _| Ok::<_, ToolError>(Some(item * 2)), watch).expect("results");
        assert_eq!(results, items.iter().map(|item| Some(item * 2)).collect::<Vec<_>>());
        assert_eq!(last, 100);
        assert!(
            map(&[] as &[usize], 7, |item, _| Ok::<_, ToolError>(Some(*item)), |_| true).expect("nothing").is_empty()
        );
    }

    #[test]
    fn a_failure_stops_the_others() {
        let work = |item: &usize, stop: &AtomicBool| match item {
            1 => Err(ToolError::unexpected("x", "y", "z")),
            _ => until_stopped(stop),
        };
        let result = map(&[0, 1, 2, 3], 2, work, |_| true);
        assert!(matches!(result, Err(ToolError::Unexpected { .. })), "{result:?}");
    }

    #[test]
    fn a_stop_leaves_the_rest_out() {
        let stopped = map(&[0, 1, 2, 3], 2, |_, stop| until_stopped(stop), |_| false);
        assert_eq!(stopped.expect("no failure"), [None; 4]);
        let mut calls = 0;
        let proceed = |_| {
            calls += 1;
            calls < 3
        };
        let stopped = map(&[0, 1, 2, 3], 2, |_, stop| until_stopped(stop), proceed);
        assert_eq!(stopped.expect("no failure"), [None; 4]);
    }
}
