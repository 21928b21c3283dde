//! Many pieces of work on some threads, watched from this one.

use crate::Error;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

const BETWEEN_TICKS: Duration = Duration::from_millis(100);

/// Does `work` for each item, on at most `threads` threads, and gives the results in order. `proceed` is told several
/// times a second how many are done; where it says no, or an item fails, the rest is stopped.
pub(crate) fn for_each<I: Sync, T: Send>(
    items: &[I],
    threads: usize,
    work: impl Fn(&I, &AtomicBool) -> Result<T, Error> + Sync,
    proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<T>, Error> {
    let results = for_each_until_stopped(items, threads, |item, stop| work(item, stop).map(Some), proceed)?;
    results.into_iter().collect::<Option<Vec<T>>>().ok_or(Error::Stopped)
}

/// The same for work of which a part is worth having: nothing for items that were not begun or gave nothing. Where
/// `proceed` says no, the flag that `work` is given is set. So it is where an item fails; the first failure is returned.
///
/// # Errors
/// An item failed.
pub fn for_each_until_stopped<I: Sync, T: Send, E: Send>(
    items: &[I],
    threads: usize,
    work: impl Fn(&I, &AtomicBool) -> Result<Option<T>, E> + Sync,
    mut proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<Option<T>>, E> {
    // Whoever watches is ready to say stop before anything runs.
    let stop = AtomicBool::new(!proceed(0));
    let next = AtomicUsize::new(0);
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let mut failure: Option<E> = None;
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.clamp(1, items.len().max(1)) {
            let (sender, stop, next, work) = (sender.clone(), &stop, &next, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    // Nobody listens only when all is over.
                    let _ = sender.send((index, work(item, stop)));
                }
            });
        }
        drop(sender);
        let mut done = 0;
        loop {
            match receiver.recv_timeout(BETWEEN_TICKS) {
                Ok((index, Ok(result))) => {
                    done += usize::from(result.is_some());
                    results[index] = result;
                }
                Ok((_, Err(error))) => {
                    stop.store(true, Ordering::Relaxed);
                    // The first is the reason; the others have been stopped for it.
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

    fn until_stopped(stop: &AtomicBool) -> Result<usize, Error> {
        while !stop.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Err(Error::Stopped)
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
        let results = for_each(&items, 7, |item, _| Ok(item * 2), watch).expect("results");
        assert_eq!(results, items.iter().map(|item| item * 2).collect::<Vec<_>>());
        assert_eq!(last, 100);
        assert!(for_each(&[] as &[usize], 7, |item, _| Ok(*item), |_| true).expect("nothing").is_empty());
    }

    #[test]
    fn one_failure_stops_the_others() {
        let missing = || Error::MissingTool { program: "x".to_string(), install: "y" };
        let work = |item: &usize, stop: &AtomicBool| if *item == 1 { Err(missing()) } else { until_stopped(stop) };
        let result = for_each(&[0, 1, 2, 3], 2, work, |_| true);
        assert!(matches!(result, Err(Error::MissingTool { .. })), "{result:?}");
    }

    #[test]
    fn whoever_watches_can_stop() {
        let result = for_each(&[0, 1, 2, 3], 2, |_, stop| until_stopped(stop), |_| false);
        assert!(matches!(result, Err(Error::Stopped)), "{result:?}");
    }
}
