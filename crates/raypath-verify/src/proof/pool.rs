//! Many proofs on some threads, watched from this one.

use crate::Error;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

const BETWEEN_TICKS: Duration = Duration::from_millis(100);

/// Does `work` for each item, on as many threads as there are processors, and gives the results in order: nothing for
/// those that were not begun or gave nothing. `proceed` is told several times a second how many are done; where it says
/// no, the flag that `work` is given is set. So it is where an item fails; the first failure is returned.
pub fn for_each<I: Sync, T: Send>(
    items: &[I],
    work: impl Fn(&I, &AtomicBool) -> Result<Option<T>, Error> + Sync,
    mut proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<Option<T>>, Error> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let stop = AtomicBool::new(!proceed(0));
    let next = AtomicUsize::new(0);
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let mut failure: Option<Error> = None;
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.min(items.len()) {
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

    #[test]
    fn results_keep_their_order_and_a_stop_leaves_the_rest_out() {
        let items: Vec<usize> = (0..100).collect();
        let all = for_each(&items, |item, _| Ok(Some(item * 2)), |_| true).expect("results");
        assert_eq!(all, items.iter().map(|item| Some(item * 2)).collect::<Vec<_>>());
        let until_stopped = |_: &usize, stop: &AtomicBool| -> Result<Option<()>, Error> {
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(None)
        };
        let mut ticks = 0;
        let watch = |_| {
            ticks += 1;
            ticks < 3
        };
        assert_eq!(for_each(&items, until_stopped, watch).expect("nothing"), vec![None; 100]);
    }

    #[test]
    fn a_failure_stops_the_others() {
        let fail = |item: &usize, stop: &AtomicBool| match item {
            0 => Err(Error::Program { program: "x".into(), problem: "y".into(), expected: "z".into() }),
            _ => Ok(stop.load(Ordering::Relaxed).then_some(())),
        };
        assert!(for_each(&[0, 1, 2, 3], fail, |_| true).is_err());
    }
}
