use crate::kernel::distance;
use crate::{Metric, Neighbours, SearchError, SearchResults, Vectors};
use std::collections::HashSet;

/// Recall at `count`: the mean fraction of the `count` true neighbours that a search found, between 0 and 1.
///
/// A found vector counts if it is **no farther than the farthest of the first `count` true neighbours**, by the
/// distances of the datapath. Ties with the last true neighbour count, also those that only rounding separates, without
/// a tolerance. A vector that was found twice counts once, and only the first `count` results count.
///
/// # Errors
/// Queries of another dimension than the base; truth or results for another number of queries; fewer true neighbours
/// than `count`; a `count` of 0.
pub fn recall(
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
            let problem = format!("truth of {found} queries, expected {}", queries.len());
            return Err(SearchError::Parameter(problem));
        }
    }
    if truth.count() < count {
        let problem = format!("truth of {} neighbours per query, expected {count}", truth.count());
        return Err(SearchError::Parameter(problem));
    }
    let mut hits = 0;
    for ((query, row), truth) in queries.iter().zip(&results.rows).zip(truth.rows()) {
        // Not the distance of a result, which another search may have rounded otherwise.
        let of = |index: u32| distance(metric, query, base.get(index as usize).unwrap_or_default());
        let farthest = truth[..count].iter().map(|index| of(*index)).fold(f64::NEG_INFINITY, f64::max);
        let mut seen = HashSet::new();
        let found = row.iter().take(count).filter(|near| seen.insert(near.index));
        hits += found.filter(|near| of(near.index) <= farthest).count();
    }
    Ok(hits as f64 / (count * queries.len()) as f64)
}
