//! The measurement of time on a shared machine.

use std::time::{Duration, Instant};

/// The minimum duration of a run: far longer than a read of the clock, and shorter than a time slice of the scheduler,
/// so that some runs are not interrupted.
const RUN: Duration = Duration::from_millis(1);

/// The seconds of a call of `work`, which does the same each time: the minimum of `repetitions` runs, each with as many
/// calls as last a millisecond.
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
