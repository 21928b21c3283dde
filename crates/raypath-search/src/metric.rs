use raypath_ops::JobKind;
use raypath_traversal::search::SearchMetric;

/// The Euclidean lanes of the datapath, as in the paper.
pub(crate) const LANES: usize = 16;

/// The distance by which neighbours are ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Euclidean distance.
    Euclidean,
    /// Cosine distance: 1 minus the cosine of the angle, between 0 and 2.
    Angular,
}

impl Metric {
    /// Both metrics.
    pub const ALL: [Self; 2] = [Self::Euclidean, Self::Angular];

    /// The operation of the datapath.
    pub fn kind(self) -> JobKind {
        match self {
            Self::Euclidean => JobKind::Euclidean,
            Self::Angular => JobKind::Angular,
        }
    }

    /// The lanes of the datapath that compute this metric.
    pub fn lanes(self) -> usize {
        match self {
            Self::Euclidean => LANES,
            Self::Angular => LANES / 2,
        }
    }

    /// The number of beats of one vector.
    pub fn beats(self, dimensions: usize) -> u64 {
        dimensions.div_ceil(self.lanes()) as u64
    }
}

raypath_ops::names! {
    Metric { Euclidean = "euclidean", Angular = "angular" },
    /// The error of an unknown metric name.
    ParseMetricError, "metric `{0}`, expected euclidean or angular"
}

/// The Euclidean distance from the squared distance of the datapath. Infinite if the sum overflowed binary32.
pub fn euclidean_distance(squared: f32) -> f64 {
    f64::from(squared).sqrt()
}

/// The cosine distance from the sums of the datapath.
///
/// - A **zero vector** has no direction: its distance from every vector is 1, as at a right angle. The same holds for a
///   vector whose squared norm underflows to 0 in binary32.
/// - If a sum **overflowed** binary32, the distance is infinite, so that the pair is ordered last.
/// - The distance is clamped to 0 to 2, because rounding can move a cosine out of -1 to 1.
#[inline]
pub fn cosine_distance(dot_product: f32, query_norm: f32, candidate_norm: f32) -> f64 {
    // Free of branches, so that the compiler can vectorise loops over it.
    let squares = f64::from(query_norm) * f64::from(candidate_norm);
    let distance = (1.0 - f64::from(dot_product) / squares.sqrt()).clamp(0.0, 2.0);
    let distance = if squares == 0.0 { 1.0 } else { distance };
    let known = dot_product.is_finite() & query_norm.is_finite() & candidate_norm.is_finite();
    if known { distance } else { f64::INFINITY }
}

impl From<Metric> for SearchMetric {
    fn from(metric: Metric) -> Self {
        match metric {
            Metric::Euclidean => Self::Euclidean,
            Metric::Angular => Self::Cosine,
        }
    }
}
