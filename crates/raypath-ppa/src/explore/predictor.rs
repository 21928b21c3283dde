//! Predictions of what is measured, from what has been measured so far.

use super::fit::{Fit, Predicted, Terms};
use super::metric::{Metric, Values};
use std::collections::BTreeMap;

/// A configuration of the space that is searched.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// The command-line options for it.
    pub options: String,
    /// The metrics that are exact without measurement.
    pub exact: Values,
    /// The terms of each metric that is measured.
    pub terms: BTreeMap<Metric, Terms>,
}

/// Predicts metrics of candidates.
pub trait Predictor {
    /// Predicts a metric of the `wanted` candidates from the measured values of `known` ones.
    fn predict(&self, metric: Metric, known: &[(usize, f64)], wanted: &[usize]) -> Vec<Predicted>;
}

/// A linear fit of each candidate's terms.
#[derive(Debug)]
pub struct LinearPredictor<'c> {
    /// All candidates.
    pub candidates: &'c [Candidate],
}

/// The least relative error of predictions: measurements of one design in another order of its gates differ by this.
fn noise(metric: Metric) -> f64 {
    match metric {
        Metric::Area => 0.003,
        _ => 0.03,
    }
}

impl Predictor for LinearPredictor<'_> {
    fn predict(&self, metric: Metric, known: &[(usize, f64)], wanted: &[usize]) -> Vec<Predicted> {
        let terms = |candidate: usize| self.candidates[candidate].terms.get(&metric);
        let observations: Vec<(&Terms, f64)> =
            known.iter().filter_map(|(candidate, value)| Some((terms(*candidate)?, *value))).collect();
        let fit = Fit::new(&observations, noise(metric));
        let predict = |candidate: &usize| match (&fit, terms(*candidate)) {
            (Some(fit), Some(terms)) => fit.predict(terms),
            (_, terms) => Predicted { value: terms.map_or(0.0, Terms::rough), error: f64::INFINITY },
        };
        wanted.iter().map(predict).collect()
    }
}
