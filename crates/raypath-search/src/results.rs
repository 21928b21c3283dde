use crate::metric::Metric;

/// The result of a search with its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchResults {
    /// The neighbours of each query, nearest first, and by index at equal distances.
    pub rows: Vec<Vec<Neighbour>>,
    /// The work of the datapath.
    pub work: Work,
    /// The wall-clock time of the search in seconds.
    pub seconds: f64,
}

/// A neighbour of a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// The index of the vector in the base.
    pub index: u32,
    /// The distance, by [`euclidean_distance`](crate::euclidean_distance) or
    /// [`cosine_distance`](crate::cosine_distance) of the sums from the datapath.
    pub distance: f64,
}

/// The work of the datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// The number of evaluated pairs of vectors.
    pub evaluations: u64,
    /// The number of their beats.
    pub beats: u64,
}

impl Work {
    /// The work for a number of pairs of vectors.
    pub(crate) fn of<const E: usize, const A: usize>(evaluations: u64, metric: Metric, dimensions: usize) -> Self {
        Self { evaluations, beats: evaluations.saturating_mul(metric.beats::<E, A>(dimensions)) }
    }
}

impl SearchResults {
    /// The number of completed queries per second.
    pub fn queries_per_second(&self) -> f64 {
        self.rows.len() as f64 / self.seconds
    }

    /// The mean per query of a total over all queries.
    pub fn per_query(&self, total: u64) -> f64 {
        total as f64 / self.rows.len().max(1) as f64
    }
}
