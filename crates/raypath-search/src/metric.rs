use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Which distance neighbours are ordered by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Euclidean distance.
    Euclidean,
    /// Cosine distance: 1 − cos of the angle, between 0 and 2.
    Angular,
}

/// A name that no metric has.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("metric `{0}`, expected euclidean or angular")]
pub struct ParseMetricError(String);

impl Metric {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Euclidean, Self::Angular];

    /// Its name, as [`FromStr`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Euclidean => "euclidean",
            Self::Angular => "angular",
        }
    }

    /// The beats of one vector in a datapath of `E` Euclidean and `A` angular lanes.
    pub fn beats<const E: usize, const A: usize>(self, dimensions: usize) -> u64 {
        let lanes = match self {
            Self::Euclidean => E,
            Self::Angular => A,
        };
        dimensions.div_ceil(lanes) as u64
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Metric {
    type Err = ParseMetricError;

    fn from_str(name: &str) -> Result<Self, ParseMetricError> {
        Self::ALL.into_iter().find(|metric| metric.name() == name).ok_or_else(|| ParseMetricError(name.to_owned()))
    }
}

/// The distance of vectors whose squared distance the datapath gave: the root that is outside. Infinite where the sum
/// overflowed binary32.
pub fn euclidean_distance(squared: f32) -> f64 {
    f64::from(squared).sqrt()
}

/// The cosine distance, from what the datapath gave: root and division that are outside.
///
/// - A **zero vector** has no direction: its distance from every vector is 1, as if it were at a right angle. So has a
///   vector whose squared norm underflows binary32 to 0.
/// - Where a sum **overflowed** binary32 nothing is known: the distance is infinite, so that the pair comes last.
/// - Rounding can make a cosine exceed 1, or fall below -1: the distance is then 0, or 2.
#[inline]
pub fn cosine_distance(dot_product: f32, query_norm: f32, candidate_norm: f32) -> f64 {
    // Without branches: searches compute several in SIMD registers.
    let squares = f64::from(query_norm) * f64::from(candidate_norm);
    let distance = (1.0 - f64::from(dot_product) / squares.sqrt()).clamp(0.0, 2.0);
    let distance = if squares == 0.0 { 1.0 } else { distance };
    let known = dot_product.is_finite() & query_norm.is_finite() & candidate_norm.is_finite();
    if known { distance } else { f64::INFINITY }
}
