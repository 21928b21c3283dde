use crate::answers::Neighbour;
use crate::error::SearchError;
use crate::exact::check;
use crate::graph::Log;
use crate::metric::{Metric, cosine_distance, euclidean_distance};
use crate::nearest::{Candidate, Nearest};
use crate::vectors::Vectors;
use raypath_model::Functional;
use raypath_ops::{AngularInput, Beat, Binary32, EuclideanInput, Job, Outcome};
use raypath_timing::{Action, Agent};
use std::collections::HashSet;

/// One query's way through the datapath, for simulations of time: an [`Agent`] that fetches candidates, issues their
/// beats, and keeps the nearest.
///
/// Each candidate is one fetch, whatever its dimension, and it is fetched when the beats of the one before have been
/// accepted. The query itself is there from the start; angular its own beats come first, for its norm. From the first
/// beat of a vector to the last the walk holds the datapath, as there is one accumulator for all.
///
/// It has no lanes of its own: it serves a datapath of any number, and must be answered by the one that it gave jobs to.
#[derive(Debug, Clone)]
pub struct Walk<'v> {
    base: &'v Vectors,
    query: &'v [f32],
    metric: Metric,
    candidates: Candidates<'v>,
    /// Candidates that have been fetched.
    fetched: usize,
    /// Candidates whose distance has been answered.
    answered: usize,
    /// What has not been issued of the vector that goes through the datapath.
    left: &'v [f32],
    /// Beats that have no answer.
    outstanding: u64,
    query_norm: Option<f32>,
    nearest: Nearest,
    /// What may become a neighbour; anything if there is none.
    wanted: Option<HashSet<u32>>,
}

/// Which vectors of the base a query is compared with.
#[derive(Debug, Clone, Copy)]
enum Candidates<'v> {
    /// So many, by index.
    All(usize),
    /// In this order.
    Listed(&'v [u32]),
}

impl<'v> Walk<'v> {
    /// Exact search: past all vectors of the base, by index, for the `count` nearest. A candidate is fetched while the
    /// beats of those before are in the pipeline.
    ///
    /// # Errors
    /// A query of another dimension than the base; a `count` that is not 1 to the size of the base.
    pub fn exact(base: &'v Vectors, query: &'v [f32], metric: Metric, count: usize) -> Result<Self, SearchError> {
        check(base.dimensions(), base.len(), query.len(), count)?;
        Ok(Self::new(base, query, metric, Candidates::All(base.len()), count, None))
    }

    /// The way of a graph's log. Which candidate comes next depends on the distances of those before, so each but the
    /// first is fetched when they have been answered. It keeps what the log says that the graph has kept.
    ///
    /// # Errors
    /// A query of another dimension than the base; a candidate that the base does not have.
    pub fn logged(base: &'v Vectors, query: &'v [f32], metric: Metric, log: &'v Log) -> Result<Self, SearchError> {
        check(base.dimensions(), base.len(), query.len(), 1)?;
        if let Some(&found) = log.candidates.iter().find(|&&index| index as usize >= base.len()) {
            let expected = "an index of the base";
            return Err(SearchError::Parameter { name: "candidate", found: found as usize, expected });
        }
        let wanted: HashSet<u32> = log.found.iter().copied().collect();
        Ok(Self::new(base, query, metric, Candidates::Listed(&log.candidates), wanted.len(), Some(wanted)))
    }

    fn new(
        base: &'v Vectors,
        query: &'v [f32],
        metric: Metric,
        candidates: Candidates<'v>,
        count: usize,
        wanted: Option<HashSet<u32>>,
    ) -> Self {
        let left = match metric {
            Metric::Euclidean => &[],
            Metric::Angular => query,
        };
        let (fetched, answered, outstanding, query_norm) = (0, 0, 0, None);
        let nearest = Nearest::new(count);
        Self { base, query, metric, candidates, fetched, answered, left, outstanding, query_norm, nearest, wanted }
    }

    /// The nearest of the candidates that have been answered, nearest first; equally near ones by index.
    pub fn into_neighbours(self) -> Vec<Neighbour> {
        let sorted = self.nearest.into_sorted();
        sorted.into_iter().map(|Candidate { key, index }| Neighbour { index, distance: key }).collect()
    }

    /// The next beat of the vector that goes through the datapath, if one does.
    #[inline]
    fn beat<const N: usize>(&mut self) -> Option<Beat<Binary32, N>> {
        let (query, left) = (self.query.get(self.query.len() - self.left.len()..)?, self.left);
        let width = left.len().min(N);
        let mut beat = Beat::of(&query[..width], &left[..width]).ok()?.next()?;
        self.left = &left[width..];
        beat.reset_accum = self.left.is_empty().into();
        Some(beat)
    }

    /// Takes the distance of the oldest candidate that has none.
    #[inline]
    fn take(&mut self, distance: f64) {
        let index = self.candidates.get(self.answered);
        self.answered += 1;
        if let Some(index) = index
            && self.wanted.as_mut().is_none_or(|wanted| wanted.remove(&index))
        {
            self.nearest.offer(Candidate { key: distance, index });
        }
    }
}

impl<const E: usize, const A: usize> Agent<Functional<E, A>> for Walk<'_> {
    #[inline]
    fn next_action(&mut self) -> Action<Job<E, A>> {
        let job = match self.metric {
            Metric::Euclidean => self.beat().map(|euclidean| Job::Euclidean(EuclideanInput { euclidean })),
            Metric::Angular => self.beat().map(|euclidean| Job::Angular(AngularInput { euclidean })),
        };
        if let Some(job) = job {
            self.outstanding += 1;
            return Action::Issue { job, lock: !self.left.is_empty() };
        }
        let Some(next) = self.candidates.get(self.fetched) else { return Action::Done };
        if self.outstanding > 0 && self.fetched > 0 && self.candidates.depend() {
            return Action::Wait;
        }
        self.left = self.base.get(next as usize).unwrap_or_default();
        self.fetched += 1;
        Action::Fetch
    }

    /// Hits of rays are no answer to any of its jobs, and do nothing.
    #[inline]
    fn receive(&mut self, outcome: &Outcome) {
        self.outstanding = self.outstanding.saturating_sub(1);
        match outcome {
            Outcome::Euclidean(sum) if sum.euclidean_reset_accum.into() => {
                self.take(euclidean_distance(sum.euclidean_accumulator.into()));
            }
            Outcome::Angular(sums) if sums.angular_reset_accum.into() => match self.query_norm {
                None => self.query_norm = Some(sums.angular_norm.into()),
                Some(query_norm) => {
                    let (dot_product, norm) = (sums.angular_dot_product.into(), sums.angular_norm.into());
                    self.take(cosine_distance(dot_product, query_norm, norm));
                }
            },
            _ => {}
        }
    }
}

impl Candidates<'_> {
    #[inline]
    fn get(self, number: usize) -> Option<u32> {
        match self {
            Self::All(len) => (number < len).then_some(number as u32),
            Self::Listed(list) => list.get(number).copied(),
        }
    }

    /// Whether which one comes next depends on the distances of those before.
    #[inline]
    fn depend(self) -> bool {
        matches!(self, Self::Listed(_))
    }
}
