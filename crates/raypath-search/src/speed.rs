use crate::error::SearchError;
use crate::exact::Exact;
use crate::metric::Metric;
use crate::vectors::Vectors;

/// The speed of exact search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed {
    /// The number of threads.
    pub threads: usize,
    /// Distances per second.
    pub distances_per_second: f64,
    /// Beats per second.
    pub beats_per_second: f64,
}

/// Measures exact search for the 10 nearest neighbours, or for all vectors if there are fewer, on `threads` threads.
///
/// # Errors
/// Queries of another dimension than the base; threads that the system cannot start.
pub fn speed<const E: usize, const A: usize>(
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
    threads: usize,
) -> Result<Speed, SearchError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| SearchError::Threads { requested: threads, reason: error.to_string() })?;
    let exact = Exact::<E, A>::new(base, metric);
    let results = pool.install(|| exact.search(queries, base.len().min(10), &|_| true))?;
    let per_second = |count: u64| count as f64 / results.seconds;
    let (distances, beats) = (results.work.evaluations, results.work.beats);
    Ok(Speed { threads, distances_per_second: per_second(distances), beats_per_second: per_second(beats) })
}
