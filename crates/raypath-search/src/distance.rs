use crate::metric::{Metric, cosine_distance, euclidean_distance};
use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Job, Outcome, Rules, VectorError};

/// A distance evaluator that runs each beat as a job of the functional model. Searches compute the same bits faster.
///
/// `E`, the number of Euclidean lanes, is a power of two from 2 to 64; `A`, that of angular lanes, is half of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Datapath<const E: usize = 16, const A: usize = 8> {
    model: Functional<E, A>,
    beats: u64,
}

/// The sums of the datapath over the angular beats of two vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    /// The dot product of query and candidate.
    pub dot_product: f32,
    /// The squared norm of the candidate. The norm of the query takes a run with the query as its own candidate.
    pub norm: f32,
}

impl<const E: usize, const A: usize> Datapath<E, A> {
    /// An evaluator with accumulators at zero.
    pub fn new() -> Self {
        const { assert!(E == 2 * A, "half as many angular lanes as Euclidean ones") };
        Self { model: Functional::new(Rules::Paper), beats: 0 }
    }

    /// The squared Euclidean distance in binary32, summed in the order of the datapath.
    ///
    /// # Errors
    /// Vectors of different dimensions, or without coordinates.
    pub fn squared(&mut self, query: &[f32], candidate: &[f32]) -> Result<f32, VectorError> {
        let mut sum = 0.0;
        for euclidean in Beat::of(query, candidate)? {
            self.beats += 1;
            if let Outcome::Euclidean(output) = self.model.run(&Job::Euclidean(BeatInput { euclidean })) {
                sum = output.euclidean_accumulator.into();
            }
        }
        Ok(sum)
    }

    /// The dot product and the norm of the candidate in binary32, summed in the order of the datapath.
    ///
    /// # Errors
    /// Vectors of different dimensions, or without coordinates.
    pub fn angle(&mut self, query: &[f32], candidate: &[f32]) -> Result<Angle, VectorError> {
        let mut angle = Angle { dot_product: 0.0, norm: 0.0 };
        for euclidean in Beat::of(query, candidate)? {
            self.beats += 1;
            if let Outcome::Angular(output) = self.model.run(&Job::Angular(BeatInput { euclidean })) {
                angle = Angle { dot_product: output.angular_dot_product.into(), norm: output.angular_norm.into() };
            }
        }
        Ok(angle)
    }

    /// The distance. With the angular metric it takes twice the beats, because the norm of the query takes a run of its
    /// own.
    ///
    /// # Errors
    /// Vectors of different dimensions, or without coordinates.
    pub fn distance(&mut self, metric: Metric, query: &[f32], candidate: &[f32]) -> Result<f64, VectorError> {
        Ok(match metric {
            Metric::Euclidean => euclidean_distance(self.squared(query, candidate)?),
            Metric::Angular => {
                let Angle { dot_product, norm } = self.angle(query, candidate)?;
                cosine_distance(dot_product, self.angle(query, query)?.norm, norm)
            }
        })
    }

    /// The number of beats run so far.
    pub fn beats(&self) -> u64 {
        self.beats
    }
}

impl<const E: usize, const A: usize> Default for Datapath<E, A> {
    fn default() -> Self {
        Self::new()
    }
}
