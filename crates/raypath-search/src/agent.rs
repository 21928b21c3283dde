use crate::exact::check;
use crate::results::Nearest;
use crate::{Metric, Neighbour, SearchError, SearchTrace, Vectors, cosine_distance, euclidean_distance};
use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Binary32, Job, Outcome};
use raypath_timing::{Action, Agent};
use std::collections::HashSet;

/// The [`Agent`] of one query: it fetches candidates, issues their beats, and keeps the nearest.
///
/// Each candidate takes one fetch, with any dimension, which starts when the beats of the previous candidate have been
/// accepted. The query itself takes no fetch; with the angular metric its own beats come first, for its norm. The agent
/// locks the datapath from the first beat of a vector to the last, because all agents share one accumulator. It works
/// with any number of lanes.
#[derive(Debug, Clone)]
pub struct QueryAgent<'v> {
    base: &'v Vectors,
    query: &'v [f32],
    metric: Metric,
    candidates: Candidates<'v>,
    fetched: usize,
    /// The number of candidates with a distance.
    evaluated: usize,
    /// The coordinates of the current vector that are not yet issued.
    remaining: &'v [f32],
    /// The number of beats without an outcome.
    outstanding: u64,
    query_norm: Option<f32>,
    nearest: Nearest,
    /// The candidates that may become neighbours; all if `None`.
    eligible: Option<HashSet<u32>>,
}

/// The vectors of the base that a query is compared with.
#[derive(Debug, Clone, Copy)]
enum Candidates<'v> {
    /// The first vectors, in order of index.
    All(usize),
    /// The listed vectors, in this order.
    Listed(&'v [u32]),
}

impl<'v> QueryAgent<'v> {
    /// The agent of an exact search for the `count` nearest vectors. It fetches a candidate while the beats of previous
    /// ones are in the pipeline.
    ///
    /// # Errors
    /// A query of another dimension than the base; a `count` that is not 1 to the size of the base.
    pub fn exact(base: &'v Vectors, query: &'v [f32], metric: Metric, count: usize) -> Result<Self, SearchError> {
        check(base.dimensions(), base.len(), query.len(), count)?;
        Ok(Self::new(base, query, metric, Candidates::All(base.len()), count, None))
    }

    /// The agent of a graph search. The choice of a candidate depends on the distances of the previous ones, so the
    /// agent fetches each candidate after the previous outcomes. It keeps the neighbours that the search kept.
    ///
    /// # Errors
    /// A query of another dimension than the base; a candidate that the base does not have.
    pub fn traced(
        base: &'v Vectors,
        query: &'v [f32],
        metric: Metric,
        trace: &'v SearchTrace,
    ) -> Result<Self, SearchError> {
        check(base.dimensions(), base.len(), query.len(), 1)?;
        if let Some(&found) = trace.candidates.iter().find(|&&index| index as usize >= base.len()) {
            return Err(SearchError::Parameter(format!("candidate is {found}, expected an index of the base")));
        }
        let eligible: HashSet<u32> = trace.found.iter().copied().collect();
        Ok(Self::new(base, query, metric, Candidates::Listed(&trace.candidates), eligible.len(), Some(eligible)))
    }

    fn new(
        base: &'v Vectors,
        query: &'v [f32],
        metric: Metric,
        candidates: Candidates<'v>,
        count: usize,
        eligible: Option<HashSet<u32>>,
    ) -> Self {
        let remaining = match metric {
            Metric::Euclidean => &[],
            Metric::Angular => query,
        };
        Self {
            base,
            query,
            metric,
            candidates,
            fetched: 0,
            evaluated: 0,
            remaining,
            outstanding: 0,
            query_norm: None,
            nearest: Nearest::new(count),
            eligible,
        }
    }

    /// The nearest candidates with a distance so far, nearest first, and by index at equal distances.
    pub fn into_neighbours(self) -> Vec<Neighbour> {
        self.nearest.into_sorted()
    }

    /// The next beat of the current vector, if any is left.
    #[inline]
    fn beat<const N: usize>(&mut self) -> Option<Beat<Binary32, N>> {
        let (query, remaining) = (self.query.get(self.query.len() - self.remaining.len()..)?, self.remaining);
        let width = remaining.len().min(N);
        let mut beat = Beat::of(&query[..width], &remaining[..width]).ok()?.next()?;
        self.remaining = &remaining[width..];
        beat.reset_accum = self.remaining.is_empty().into();
        Some(beat)
    }

    /// Records the distance of the oldest candidate without one.
    #[inline]
    fn record(&mut self, distance: f64) {
        let index = self.candidates.get(self.evaluated);
        self.evaluated += 1;
        if let Some(index) = index
            && self.eligible.as_mut().is_none_or(|eligible| eligible.remove(&index))
        {
            self.nearest.offer(Neighbour { index, distance });
        }
    }
}

impl<const E: usize, const A: usize> Agent<Functional<E, A>> for QueryAgent<'_> {
    #[inline]
    fn next_action(&mut self) -> Action<Job<E, A>> {
        let job = match self.metric {
            Metric::Euclidean => self.beat().map(|euclidean| Job::Euclidean(BeatInput { euclidean })),
            Metric::Angular => self.beat().map(|euclidean| Job::Angular(BeatInput { euclidean })),
        };
        if let Some(job) = job {
            self.outstanding += 1;
            return Action::Issue { job, lock: !self.remaining.is_empty() };
        }
        let Some(next) = self.candidates.get(self.fetched) else { return Action::Done };
        if self.outstanding > 0 && self.fetched > 0 && self.candidates.are_dependent() {
            return Action::Wait;
        }
        self.remaining = self.base.get(next as usize).unwrap_or_default();
        self.fetched += 1;
        Action::Fetch
    }

    /// Outcomes of rays are ignored: the agent does not issue such jobs.
    #[inline]
    fn receive(&mut self, outcome: &Outcome) {
        self.outstanding = self.outstanding.saturating_sub(1);
        match outcome {
            Outcome::Euclidean(sum) if sum.euclidean_reset_accum.into() => {
                self.record(euclidean_distance(sum.euclidean_accumulator.into()));
            }
            Outcome::Angular(sums) if sums.angular_reset_accum.into() => match self.query_norm {
                None => self.query_norm = Some(sums.angular_norm.into()),
                Some(query_norm) => {
                    let (dot_product, norm) = (sums.angular_dot_product.into(), sums.angular_norm.into());
                    self.record(cosine_distance(dot_product, query_norm, norm));
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

    /// Whether the choice of a candidate depends on the distances of the previous ones.
    #[inline]
    fn are_dependent(self) -> bool {
        matches!(self, Self::Listed(_))
    }
}
