//! Time, on a machine that others use too.

use std::time::{Duration, Instant};

/// The least time that one run is to take: far more than reading the clock, less than a slice of the scheduler, so that
/// some runs are not interrupted.
const RUN: Duration = Duration::from_millis(1);

/// Seconds that `work` takes, which does the same each time: the best of `repetitions`, each of as many calls as it
/// takes to be measured.
pub fn seconds(repetitions: usize, mut work: impl FnMut()) -> f64 {
    let once = best(1, 1, &mut work);
    let calls = (RUN.as_secs_f64() / once.max(1e-9)).ceil().clamp(1.0, 1e6) as usize;
    best(repetitions.max(1), calls, &mut work)
}

fn best(repetitions: usize, calls: usize, work: &mut impl FnMut()) -> f64 {
    let run = |_| {
        let begin = Instant::now();
        (0..calls).for_each(|_| work());
        begin.elapsed().as_secs_f64() / calls as f64
    };
    (0..repetitions).map(run).fold(f64::INFINITY, f64::min)
}
