//! The search for a Pareto front without measuring all configurations.
//!
//! A first set of configurations, which differ as much as possible, is measured. Then predictions are fitted to what is
//! known. A configuration is open if it would meet the goals and be on the front with all its predictions at the better
//! ends of their errors. The most promising open ones are measured, and this is repeated until none is open.

use super::fit::Predicted;
use super::front::{dominates, dominators};
use super::metric::{Goal, Metric, Values};
use super::predictor::{Candidate, Predictor};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A search.
pub struct Search<'s> {
    /// The space.
    pub candidates: &'s [Candidate],
    /// What predicts the metrics that are measured.
    pub predictor: &'s dyn Predictor,
    /// Goals that configurations must meet.
    pub goals: &'s [Goal],
    /// The metrics of the front.
    pub objectives: &'s [Metric],
    /// The number of configurations in the first set.
    pub first: usize,
    /// The number that is measured between two fits.
    pub batch: usize,
}

/// What is known of a configuration at the end of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Measured; on the front.
    Front,
    /// Measured; another one is better.
    Dominated,
    /// Measured; it misses a goal.
    Missed,
    /// Not measured: within the errors of its predictions, it misses a goal or another one is better.
    Predicted,
    /// Not measured: it misses a goal by a metric that is exact.
    Excluded,
    /// Not measured yet, and perhaps on the front: the search was stopped by its budget.
    Open,
}

/// A configuration at the end of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// What is known of it.
    pub status: Status,
    /// Exact and measured metrics.
    pub values: Values,
    /// The predictions of the metrics that are measured: the last ones, or those before the measurement. Empty for
    /// excluded configurations and those of the first set.
    pub predicted: BTreeMap<Metric, Predicted>,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The candidates in their order.
    pub found: Vec<Found>,
    /// The fits that were made.
    pub rounds: usize,
}

impl Outcome {
    /// The candidates with this status.
    pub fn with(&self, status: Status) -> Vec<usize> {
        (0..self.found.len()).filter(|candidate| self.found[*candidate].status == status).collect()
    }

    /// The number of measured configurations.
    pub fn measured(&self) -> usize {
        [Status::Front, Status::Dominated, Status::Missed].iter().map(|status| self.with(*status).len()).sum()
    }

    /// Of the predictions of a metric that were compared with a measurement: those within their stated errors, and all.
    pub fn within_errors(&self, metric: Metric) -> (usize, usize) {
        let compared = self.found.iter().filter_map(|found| {
            let predicted = found.predicted.get(&metric).filter(|predicted| predicted.error.is_finite())?;
            Some((found.values.get(&metric)? - predicted.value).abs() <= predicted.error)
        });
        let compared: Vec<bool> = compared.collect();
        (compared.iter().filter(|is_within| **is_within).count(), compared.len())
    }
}

impl Search<'_> {
    /// The candidates that meet all goals for exact metrics.
    fn eligible(&self) -> Vec<usize> {
        let all = 0..self.candidates.len();
        all.filter(|candidate| self.meets(&self.candidates[*candidate].exact)).collect()
    }

    /// Whether values miss no goal; a metric without a value misses none.
    fn meets(&self, values: &Values) -> bool {
        self.goals.iter().all(|goal| values.get(&goal.metric).is_none_or(|value| goal.is_met(*value)))
    }

    /// The costs of the objectives.
    fn costs(&self, values: &Values) -> Vec<f64> {
        let cost = |metric: &Metric| values.get(metric).map_or(0.0, |value| metric.cost(*value));
        self.objectives.iter().map(cost).collect()
    }

    /// The metrics that goals or the front need and that are measured.
    pub fn measured_metrics(&self) -> Vec<Metric> {
        let wanted: BTreeSet<Metric> =
            self.goals.iter().map(|goal| goal.metric).chain(self.objectives.iter().copied()).collect();
        wanted.into_iter().filter(|metric| metric.is_measured()).collect()
    }

    /// The first set to measure, which depends on nothing measured. Of the half of the eligible candidates that a rough
    /// estimate prefers, each is as different as possible from those before it, by the terms of the predictions.
    pub fn first_set(&self) -> Vec<usize> {
        let eligible = self.eligible();
        let rough = |candidate: &usize| {
            let Candidate { exact, terms, .. } = &self.candidates[*candidate];
            let estimates = terms.iter().map(|(metric, terms)| (*metric, terms.rough()));
            self.costs(&exact.iter().map(|(metric, value)| (*metric, *value)).chain(estimates).collect())
        };
        let costs: Vec<Vec<f64>> = eligible.iter().map(rough).collect();
        let mut order: Vec<usize> = (0..eligible.len()).collect();
        order.sort_by_key(|place| dominators(&costs[*place], &costs));
        order.truncate(eligible.len().div_ceil(2).max(self.first));

        let metrics = self.measured_metrics();
        let point = |place: &usize| -> Vec<f64> {
            let terms = metrics.iter().filter_map(|metric| self.candidates[eligible[*place]].terms.get(metric));
            terms.flat_map(|terms| terms.terms.iter().chain([&terms.known]).copied()).collect()
        };
        let points: Vec<Vec<f64>> = order.iter().map(point).collect();
        spread(&points, self.first).into_iter().map(|place| eligible[order[place]]).collect()
    }

    /// Searches. `measure` gets candidates and returns the metrics of each, none for those that the budget does not
    /// allow; then the search ends, with open candidates.
    ///
    /// # Errors
    /// Those of `measure`.
    pub fn run<E>(&self, mut measure: impl FnMut(&[usize]) -> Result<Vec<Option<Values>>, E>) -> Result<Outcome, E> {
        let eligible = self.eligible();
        let mut known: BTreeMap<usize, Values> = BTreeMap::new();
        let mut predicted: BTreeMap<usize, BTreeMap<Metric, Predicted>> = BTreeMap::new();
        let (mut next, mut rounds) = (self.first_set(), 0);
        let open = loop {
            let results = measure(&next)?;
            let is_stopped = results.len() < next.len() || results.iter().any(Option::is_none);
            for (candidate, values) in
                next.iter().zip(results).filter_map(|(candidate, values)| Some((*candidate, values?)))
            {
                known.insert(candidate, self.candidates[candidate].exact.clone().into_iter().chain(values).collect());
            }
            let unknown: Vec<usize> =
                eligible.iter().copied().filter(|candidate| !known.contains_key(candidate)).collect();
            predicted.extend(self.predictions(&known, &unknown));
            rounds += 1;
            let open = self.open(&known, &unknown, &predicted);
            if open.is_empty() || is_stopped {
                break open;
            }
            next = self.most_promising(&known, &open, &predicted);
        };

        let good: Vec<Vec<f64>> = self.good(&known);
        let found = |candidate: usize| {
            let measured = known.get(&candidate);
            let status = match measured {
                Some(values) if !self.meets(values) => Status::Missed,
                Some(values) if dominators(&self.costs(values), &good) > 0 => Status::Dominated,
                Some(_) => Status::Front,
                None if open.contains(&candidate) => Status::Open,
                None if eligible.contains(&candidate) => Status::Predicted,
                None => Status::Excluded,
            };
            let values = measured.unwrap_or(&self.candidates[candidate].exact).clone();
            Found { status, values, predicted: predicted.remove(&candidate).unwrap_or_default() }
        };
        Ok(Outcome { found: (0..self.candidates.len()).map(found).collect(), rounds })
    }

    /// The costs of the measured configurations that meet all goals.
    fn good(&self, known: &BTreeMap<usize, Values>) -> Vec<Vec<f64>> {
        known.values().filter(|values| self.meets(values)).map(|values| self.costs(values)).collect()
    }

    fn predictions(
        &self,
        known: &BTreeMap<usize, Values>,
        unknown: &[usize],
    ) -> BTreeMap<usize, BTreeMap<Metric, Predicted>> {
        let mut all: BTreeMap<usize, BTreeMap<Metric, Predicted>> = BTreeMap::new();
        for metric in self.measured_metrics() {
            let measured = known.iter().filter_map(|(candidate, values)| Some((*candidate, *values.get(&metric)?)));
            let found = self.predictor.predict(metric, &measured.collect::<Vec<_>>(), unknown);
            for (candidate, predicted) in unknown.iter().zip(found) {
                all.entry(*candidate).or_default().insert(metric, predicted);
            }
        }
        all
    }

    /// A candidate's values, with each prediction moved by this part of its error.
    fn expected(&self, candidate: usize, predicted: &BTreeMap<Metric, Predicted>, part: f64) -> Values {
        let moved = |(metric, predicted): (&Metric, &Predicted)| {
            let by = if part == 0.0 { 0.0 } else { part * predicted.error };
            (*metric, (predicted.value + by).max(0.0))
        };
        self.candidates[candidate].exact.clone().into_iter().chain(predicted.iter().map(moved)).collect()
    }

    /// The candidates that may be on the front within the errors of their predictions.
    fn open(
        &self,
        known: &BTreeMap<usize, Values>,
        unknown: &[usize],
        predicted: &BTreeMap<usize, BTreeMap<Metric, Predicted>>,
    ) -> Vec<usize> {
        let good = self.good(known);
        let is_open = |candidate: &usize| {
            let best = self.expected(*candidate, &predicted[candidate], -1.0);
            let costs = self.costs(&best);
            self.meets(&best) && !good.iter().any(|better| dominates(better, &costs))
        };
        unknown.iter().copied().filter(is_open).collect()
    }

    /// The open candidates that the fewest others dominate by what is expected; of equal ones the most uncertain.
    fn most_promising(
        &self,
        known: &BTreeMap<usize, Values>,
        open: &[usize],
        predicted: &BTreeMap<usize, BTreeMap<Metric, Predicted>>,
    ) -> Vec<usize> {
        let expected: Vec<Values> =
            open.iter().map(|candidate| self.expected(*candidate, &predicted[candidate], 0.0)).collect();
        let mut all = self.good(known);
        all.extend(expected.iter().filter(|values| self.meets(values)).map(|values| self.costs(values)));
        let uncertainty = |candidate: usize| -> f64 {
            let relative = |predicted: &Predicted| predicted.error / predicted.value.abs().max(f64::MIN_POSITIVE);
            predicted[&candidate].values().map(relative).sum()
        };
        let mut ranked: Vec<(bool, usize, f64, usize)> = open
            .iter()
            .zip(&expected)
            .map(|(candidate, values)| {
                (!self.meets(values), dominators(&self.costs(values), &all), -uncertainty(*candidate), *candidate)
            })
            .collect();
        ranked.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3)));
        ranked.into_iter().take(self.batch.max(1)).map(|(.., candidate)| candidate).collect()
    }
}

/// The places of `count` points, each as far as possible from those before it; the first is point 0. Coordinates are
/// divided by their ranges.
fn spread(points: &[Vec<f64>], count: usize) -> Vec<usize> {
    let Some(first) = points.first() else { return Vec::new() };
    let range = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        let (least, most) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
        if most > least { most - least } else { 1.0 }
    };
    let ranges: Vec<f64> = (0..first.len()).map(range).collect();
    let distance = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(&ranges).map(|((a, b), range)| ((a - b) / range).powi(2)).sum()
    };
    let mut chosen = vec![0];
    let mut nearest: Vec<f64> = points.iter().map(|point| distance(point, first)).collect();
    while chosen.len() < count.min(points.len()) {
        let farthest = (0..points.len()).filter(|place| !chosen.contains(place)).fold(None, |best, place| match best {
            Some(best) if nearest[best] >= nearest[place] => Some(best),
            _ => Some(place),
        });
        let Some(farthest) = farthest else { break };
        chosen.push(farthest);
        for (near, point) in nearest.iter_mut().zip(points) {
            *near = near.min(distance(point, &points[farthest]));
        }
    }
    chosen
}
