//! Distances as jobs of the functional model, beat by beat, which searches compute faster.

use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Job, Outcome, Rules};
use raypath_search::{Metric, cosine_distance, euclidean_distance};

/// A datapath of `E` Euclidean and `A` angular lanes, with a count of its beats.
pub struct Datapath<const E: usize, const A: usize> {
    model: Functional<E, A>,
    pub beats: u64,
}

impl<const E: usize, const A: usize> Datapath<E, A> {
    pub fn new() -> Self {
        Self { model: Functional::new(Rules::Paper), beats: 0 }
    }

    /// The squared Euclidean distance.
    pub fn squared(&mut self, query: &[f32], candidate: &[f32]) -> f32 {
        let mut sum = 0.0;
        for euclidean in Beat::of(query, candidate).expect("vectors of one dimension") {
            self.beats += 1;
            if let Outcome::Euclidean(output) = self.model.run(&Job::Euclidean(BeatInput { euclidean })) {
                sum = output.euclidean_accumulator.into();
            }
        }
        sum
    }

    /// The dot product, and the squared norm of the candidate.
    pub fn angle(&mut self, query: &[f32], candidate: &[f32]) -> [f32; 2] {
        let mut sums = [0.0; 2];
        for euclidean in Beat::of(query, candidate).expect("vectors of one dimension") {
            self.beats += 1;
            if let Outcome::Angular(output) = self.model.run(&Job::Angular(BeatInput { euclidean })) {
                sums = [output.angular_dot_product.into(), output.angular_norm.into()];
            }
        }
        sums
    }

    /// The distance, with the norm of the query in a run of its own.
    pub fn distance(&mut self, metric: Metric, query: &[f32], candidate: &[f32]) -> f64 {
        match metric {
            Metric::Euclidean => euclidean_distance(self.squared(query, candidate)),
            Metric::Angular => {
                let [dot_product, norm] = self.angle(query, candidate);
                cosine_distance(dot_product, self.angle(query, query)[1], norm)
            }
        }
    }
}
