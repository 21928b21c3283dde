use crate::distance::Datapath;
use crate::error::SearchError;
use crate::metric::Metric;
use crate::neighbours::Neighbours;
use crate::results::{SearchResults, Work};
use crate::vectors::Vectors;
use std::collections::HashSet;

/// Recall at `count`: the mean fraction of the `count` true neighbours that a search found, between 0 and 1.
///
/// A found vector counts if it is **no farther than the farthest of the first `count` true neighbours**, by the
/// distances of the datapath. Ties with the last true neighbour therefore count, also those that only rounding
/// separates; no tolerance is involved. A vector that was found twice counts once, and only the first `count` results
/// count.
///
/// # Errors
/// Queries of another dimension than the base; truth or results for another number of queries; fewer true neighbours
/// than `count`; a `count` of 0.
pub fn recall<const E: usize, const A: usize>(
    results: &SearchResults,
    truth: &Neighbours,
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
    count: usize,
) -> Result<f64, SearchError> {
    crate::exact::check(base.dimensions(), base.len(), queries.dimensions(), count)?;
    for found in [truth.queries(), results.rows.len()] {
        if found != queries.len() {
            return Err(SearchError::Truth { what: "queries", found, expected: queries.len() });
        }
    }
    if truth.count() < count {
        return Err(SearchError::Truth { what: "neighbours per query", found: truth.count(), expected: count });
    }
    let mut datapath = Datapath::<E, A>::new();
    let mut hits = 0;
    for ((query, row), truth) in queries.iter().zip(&results.rows).zip(truth.rows()) {
        let mut farthest = f64::NEG_INFINITY;
        for &index in &truth[..count] {
            let candidate = base.get(index as usize).unwrap_or_default();
            farthest = farthest.max(datapath.distance(metric, query, candidate)?);
        }
        let mut seen = HashSet::new();
        let found = row.iter().take(count).filter(|near| seen.insert(near.index));
        hits += found.filter(|near| near.distance <= farthest).count();
    }
    Ok(hits as f64 / (count * queries.len()) as f64)
}

/// The statistics of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// The number of queries.
    pub queries: usize,
    /// The number of completed queries per second.
    pub queries_per_second: f64,
    /// The work of the datapath for all queries.
    pub work: Work,
    /// The mean number of distances per query.
    pub evaluations_per_query: f64,
    /// The mean number of beats per query.
    pub beats_per_query: f64,
    /// The beats of one vector with the Euclidean metric.
    pub euclidean_beats: u64,
    /// The beats of one vector with the angular metric, which has half as many lanes.
    pub angular_beats: u64,
}

impl Report {
    /// The statistics of results for vectors of dimension `dimensions`.
    pub fn new<const E: usize, const A: usize>(results: &SearchResults, dimensions: usize) -> Self {
        let queries = results.rows.len();
        let per_query = |total: u64| total as f64 / queries.max(1) as f64;
        Self {
            queries,
            queries_per_second: results.queries_per_second(),
            work: results.work,
            evaluations_per_query: per_query(results.work.evaluations),
            beats_per_query: per_query(results.work.beats),
            euclidean_beats: Metric::Euclidean.beats::<E, A>(dimensions),
            angular_beats: Metric::Angular.beats::<E, A>(dimensions),
        }
    }
}
