use crate::answers::{Answers, Work};
use crate::distance::Datapath;
use crate::error::SearchError;
use crate::metric::Metric;
use crate::neighbours::Neighbours;
use crate::vectors::Vectors;
use std::collections::HashSet;

/// Recall at `count`: which part of the `count` true neighbours of each query was found, on average. Between 0 and 1.
///
/// A found vector counts if it is **no farther than the farthest of the first `count` true neighbours**, both as the
/// datapath sees it. So a vector that is as far as the last true one counts as much as that does, and so does one that only
/// rounding in the datapath sets apart from the truth's arithmetic; no tolerance is involved. A vector that was found twice
/// counts once, and found ones beyond the first `count` do not count.
///
/// # Errors
/// Queries of another dimension than the base; truth for another number of queries than were asked and answered, or with
/// fewer neighbours than `count`, or none compared.
pub fn recall<const E: usize, const A: usize>(
    answers: &Answers,
    truth: &Neighbours,
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
    count: usize,
) -> Result<f64, SearchError> {
    crate::exact::check(base.dimensions(), base.len(), queries.dimensions(), count)?;
    for found in [truth.queries(), answers.rows.len()] {
        if found != queries.len() {
            return Err(SearchError::Truth { what: "queries", found, expected: queries.len() });
        }
    }
    if truth.count() < count {
        return Err(SearchError::Truth { what: "neighbours a query", found: truth.count(), expected: count });
    }
    let mut datapath = Datapath::<E, A>::new();
    let mut hits = 0;
    for ((query, row), truth) in queries.iter().zip(&answers.rows).zip(truth.rows()) {
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

/// A search in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// How many queries.
    pub queries: usize,
    /// Queries answered a second.
    pub queries_per_second: f64,
    /// What the datapath did for all queries.
    pub work: Work,
    /// Distances of a query, on average.
    pub evaluations_per_query: f64,
    /// Beats of a query, on average.
    pub beats_per_query: f64,
    /// Beats of one vector, Euclidean.
    pub euclidean_beats: u64,
    /// Beats of the same vector, angular: half as many lanes, so up to twice as many.
    pub angular_beats: u64,
}

impl Report {
    /// About these answers, from vectors of so many dimensions.
    pub fn new<const E: usize, const A: usize>(answers: &Answers, dimensions: usize) -> Self {
        let queries = answers.rows.len();
        let per_query = |total: u64| total as f64 / queries.max(1) as f64;
        Self {
            queries,
            queries_per_second: answers.queries_per_second(),
            work: answers.work,
            evaluations_per_query: per_query(answers.work.evaluations),
            beats_per_query: per_query(answers.work.beats),
            euclidean_beats: Metric::Euclidean.beats::<E, A>(dimensions),
            angular_beats: Metric::Angular.beats::<E, A>(dimensions),
        }
    }
}
