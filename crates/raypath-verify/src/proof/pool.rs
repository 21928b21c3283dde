//! Many proofs, on all processors.

use crate::Error;
use std::sync::atomic::AtomicBool;

/// [`raypath_ppa::parallel::map`], on as many threads as there are processors.
pub fn for_each<I: Sync, T: Send>(
    items: &[I],
    work: impl Fn(&I, &AtomicBool) -> Result<Option<T>, Error> + Sync,
    proceed: impl FnMut(usize) -> bool,
) -> Result<Vec<Option<T>>, Error> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    raypath_ppa::parallel::map(items, threads, work, proceed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;
    use std::time::Duration;

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
