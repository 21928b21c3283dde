use crate::metric::Metric;

/// What a search found, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Answers {
    /// For each query its neighbours, nearest first; equally near ones by index.
    pub rows: Vec<Vec<Neighbour>>,
    /// What the datapath did for them.
    pub work: Work,
    /// Wall-clock time of the search.
    pub seconds: f64,
}

/// A vector near a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Its index in the base.
    pub index: u32,
    /// Its distance: [`euclidean_distance`](crate::euclidean_distance) or [`cosine_distance`](crate::cosine_distance) of
    /// what the datapath gave.
    pub distance: f64,
}

/// What the datapath does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Pairs of vectors that go through it.
    pub evaluations: u64,
    /// The beats that carry them.
    pub beats: u64,
}

impl Work {
    /// Of so many pairs of vectors of so many dimensions.
    pub(crate) fn of<const E: usize, const A: usize>(evaluations: u64, metric: Metric, dimensions: usize) -> Self {
        Self { evaluations, beats: evaluations.saturating_mul(metric.beats::<E, A>(dimensions)) }
    }
}

impl Answers {
    /// Queries answered a second.
    pub fn queries_per_second(&self) -> f64 {
        self.rows.len() as f64 / self.seconds
    }
}
