use crate::{Dataset, MAX_DIMENSIONS, SearchError, Vectors};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// A generator of random vectors in clusters. Base and queries come from the same clusters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clusters {
    /// The number of vectors of the base: at least 1, with at most 2³² coordinates in total.
    pub vectors: usize,
    /// The number of queries, at least 1.
    pub queries: usize,
    /// The dimension of the vectors: 1 to [`MAX_DIMENSIONS`].
    pub dimensions: usize,
    /// The number of clusters, at least 1. The coordinates of their centres have a standard normal distribution.
    pub clusters: usize,
    /// The standard deviation of coordinates from those of the centre: 0 to 1,000.
    pub spread: f32,
    /// The seed of the random generator.
    pub seed: u64,
}

impl Default for Clusters {
    /// 10,000 vectors of 128 dimensions in 100 clusters of spread 0.5, and 100 queries.
    fn default() -> Self {
        Self { vectors: 10_000, queries: 100, dimensions: 128, clusters: 100, spread: 0.5, seed: 1 }
    }
}

impl Clusters {
    /// Generates the vectors. Equal fields give equal vectors.
    ///
    /// # Errors
    /// A field out of range.
    pub fn generate(&self) -> Result<Dataset, SearchError> {
        let sizes = [("vectors", self.vectors), ("queries", self.queries), ("clusters", self.clusters)];
        for (name, found) in sizes {
            if found == 0 || found.checked_mul(self.dimensions).is_none_or(|numbers| numbers > 1 << 32) {
                let expected = "expected at least 1, and 2^32 coordinates at most";
                return Err(SearchError::Parameter(format!("{name} is {found}, {expected}")));
            }
        }
        if !(1..=MAX_DIMENSIONS).contains(&self.dimensions) {
            let problem = format!("dimensions is {}, expected 1 to {MAX_DIMENSIONS}", self.dimensions);
            return Err(SearchError::Parameter(problem));
        }
        if !(0.0..=1000.0).contains(&self.spread) {
            return Err(SearchError::Parameter(format!("spread is {}, expected 0 to 1000", self.spread)));
        }
        let random = &mut ChaCha8Rng::seed_from_u64(self.seed);
        let centres: Vec<f32> = (0..self.clusters * self.dimensions).map(|_| StandardNormal.sample(random)).collect();
        let base = self.around(&centres, self.vectors, random)?;
        let queries = self.around(&centres, self.queries, random)?;
        Ok(Dataset { base, queries, truth: None, distances: None, metric: None, layer: None })
    }

    fn around(&self, centres: &[f32], count: usize, random: &mut ChaCha8Rng) -> Result<Vectors, SearchError> {
        let mut data = Vec::with_capacity(count * self.dimensions);
        for _ in 0..count {
            let centre = random.random_range(0..self.clusters) * self.dimensions;
            for x in &centres[centre..centre + self.dimensions] {
                let deviation: f32 = StandardNormal.sample(random);
                data.push(x + self.spread * deviation);
            }
        }
        Ok(Vectors::new(self.dimensions, data)?)
    }
}
