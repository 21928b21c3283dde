//! Many pieces of work on some threads, watched from this one.

use crate::Error;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

const BETWEEN_TICKS: Duration = Duration::from_millis(100);

/// Does `work` for each item, on at most `threads` threads, and gives the results in order. `proceed` is told several
/// times a second how many are done; where it says no, or an item fails, the rest is stopped.
pub fn for_each<I: Sync, T: Send>(
    items: &[I],
    threads: usize,
    work: impl Fn(&I, &AtomicBool) -> Result<T, Error> + Sync,
    mut proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<T>, Error> {
    // Whoever watches is ready to say stop before anything runs.
    let stop = AtomicBool::new(!proceed(0));
    let next = AtomicUsize::new(0);
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let mut failure: Option<Error> = None;
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.clamp(1, items.len().max(1)) {
            let (sender, stop, next, work) = (sender.clone(), &stop, &next, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed)
                    && let Some((index, item)) =
                        Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|index| Some((index, items.get(index)?)))
                {
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
                    results[index] = Some(result);
                    done += 1;
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
    match failure {
        Some(error) => Err(error),
        None => results.into_iter().collect::<Option<Vec<T>>>().ok_or(Error::Stopped),
    }
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
