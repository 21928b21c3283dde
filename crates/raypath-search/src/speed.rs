use crate::error::SearchError;
use crate::exact::Exact;
use crate::metric::Metric;
use crate::vectors::Vectors;

/// How fast exact search is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed {
    /// On how many threads.
    pub threads: usize,
    /// Distances a second.
    pub distances_per_second: f64,
    /// Beats a second.
    pub beats_per_second: f64,
}

/// Measures exact search for the 10 nearest, or as many as there are, on so many threads of their own.
///
/// # Errors
/// Queries of another dimension than the base; threads that the system does not give.
pub fn speed<const E: usize, const A: usize>(
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
    threads: usize,
) -> Result<Speed, SearchError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| SearchError::Threads { asked: threads, why: error.to_string() })?;
    let exact = Exact::<E, A>::new(base, metric);
    let answers = pool.install(|| exact.search(queries, base.len().min(10), &|_| true))?;
    let per_second = |count: u64| count as f64 / answers.seconds;
    let (distances, beats) = (answers.work.evaluations, answers.work.beats);
    Ok(Speed { threads, distances_per_second: per_second(distances), beats_per_second: per_second(beats) })
}
