use crate::error::SearchError;
use crate::metric::{Metric, cosine_distance, euclidean_distance};
use crate::vectors::Vectors;
use raypath_ops::{AngularInput, Beat, EuclideanInput, Job, Outcome};
use std::collections::VecDeque;

/// What a [`Walk`] does next.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // steps are streamed by value; boxing would allocate for each
pub enum Step<J> {
    /// Waits for memory: nothing more until its latency has passed.
    Fetch,
    /// Gives a job to the datapath.
    Issue {
        /// The job.
        job: J,
        /// The next job must be of the same walk: beats of a vector share the accumulator.
        holds: bool,
    },
    /// Waits for an outstanding answer.
    Wait,
    /// Has everything.
    Done,
}

/// When a walk goes to memory and when it waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Candidates that one fetch brings: at least 1.
    pub batch: usize,
    /// Whether the answers about a batch are awaited before the next fetch.
    pub waits: bool,
}

impl Pace {
    /// Of a graph: which candidate comes next depends on the last.
    pub const DEPENDENT: Self = Self { batch: 1, waits: true };

    /// Of exact search: candidates come in order, so that so many are fetched at once, and answers are not awaited.
    pub const fn streaming(batch: usize) -> Self {
        Self { batch, waits: false }
    }
}

/// One query's way through the datapath, for simulations of time: which job it offers when, and what it takes from the
/// answers. The query is there from the start; it fetches candidates, issues their beats back to back, and waits as its [`Pace`] says. Angular the first beats
/// are the query's own, for its norm.
#[derive(Debug, Clone)]
pub struct Walk<'v, const E: usize = 16, const A: usize = 8> {
    base: &'v Vectors,
    query: &'v [f32],
    metric: Metric,
    candidates: Vec<u32>,
    pace: Pace,
    /// Candidates whose beats have been made.
    next: usize,
    /// Whether the query's norm has been asked for, or is not needed.
    normed: bool,
    /// Candidates in the batch that has been fetched, not yet made into beats.
    fetched: usize,
    beats: VecDeque<Job<E, A>>,
    outstanding: u64,
    query_norm: Option<f32>,
    distances: Vec<f64>,
}

impl<'v, const E: usize, const A: usize> Walk<'v, E, A> {
    /// A walk past `candidates`, indices of the base in order: all of them for exact search, or a
    /// [`log`](crate::Graph::log).
    ///
    /// # Errors
    /// A query of another dimension than the base; a candidate that the base does not have; a batch of 0.
    pub fn new(
        base: &'v Vectors,
        query: &'v [f32],
        metric: Metric,
        candidates: Vec<u32>,
        pace: Pace,
    ) -> Result<Self, SearchError> {
        if query.len() != base.dimensions() {
            return Err(SearchError::Dimensions { base: base.dimensions(), queries: query.len() });
        }
        if let Some(&found) = candidates.iter().find(|&&index| index as usize >= base.len()) {
            let expected = "an index of the base";
            return Err(SearchError::Parameter { name: "candidate", found: found as usize, expected });
        }
        if pace.batch == 0 {
            return Err(SearchError::Parameter { name: "batch", found: 0, expected: "at least 1" });
        }
        Ok(Self {
            base,
            query,
            metric,
            candidates,
            pace,
            next: 0,
            normed: metric == Metric::Euclidean,
            fetched: 0,
            beats: VecDeque::new(),
            outstanding: 0,
            query_norm: None,
            distances: Vec::new(),
        })
    }

    /// What it does now.
    pub fn step(&mut self) -> Step<Job<E, A>> {
        if let Some(job) = self.beats.pop_front() {
            self.outstanding += 1;
            return Step::Issue { job, holds: !self.beats.is_empty() };
        }
        if !self.normed {
            self.normed = true;
            self.load(self.query);
            return self.step();
        }
        if self.fetched > 0 {
            self.fetched -= 1;
            let candidate = self.candidates.get(self.next).and_then(|&index| self.base.get(index as usize));
            self.next += 1;
            self.load(candidate.unwrap_or_default());
            return self.step();
        }
        let left = self.candidates.len() - self.next;
        if self.outstanding > 0 && (left == 0 || self.pace.waits) {
            return Step::Wait;
        }
        if left == 0 {
            return Step::Done;
        }
        self.fetched = left.min(self.pace.batch);
        Step::Fetch
    }

    /// Takes an answer, in the order of the jobs.
    pub fn answer(&mut self, outcome: &Outcome) {
        self.outstanding = self.outstanding.saturating_sub(1);
        match outcome {
            Outcome::Euclidean(sum) if sum.euclidean_reset_accum.into() => {
                self.distances.push(euclidean_distance(sum.euclidean_accumulator.into()));
            }
            Outcome::Angular(sums) if sums.angular_reset_accum.into() => match self.query_norm {
                None => self.query_norm = Some(sums.angular_norm.into()),
                Some(query_norm) => {
                    let (dot_product, norm) = (sums.angular_dot_product.into(), sums.angular_norm.into());
                    self.distances.push(cosine_distance(dot_product, query_norm, norm));
                }
            },
            _ => {}
        }
    }

    /// The distances of the candidates that have been answered, in their order.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// Makes beats of a candidate. Dimensions were compared at the beginning, so there are some.
    fn load(&mut self, candidate: &[f32]) {
        match self.metric {
            Metric::Euclidean => {
                let beats = Beat::of(self.query, candidate).into_iter().flatten();
                self.beats.extend(beats.map(|euclidean| Job::Euclidean(EuclideanInput { euclidean })));
            }
            Metric::Angular => {
                let beats = Beat::of(self.query, candidate).into_iter().flatten();
                self.beats.extend(beats.map(|euclidean| Job::Angular(AngularInput { euclidean })));
            }
        }
    }
}
