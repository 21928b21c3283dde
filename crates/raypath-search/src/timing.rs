//! How long the datapath takes for a search, cycle by cycle.
//!
//! An agent is a query: a [`Walk`]. Queries begin in the order of their numbers. What the external circuit does (root,
//! division, keeping the nearest, finding the way through a graph) takes no cycles, but reading candidates does: each is
//! one fetch.

use crate::agent::Walk;
use crate::answers::{Neighbour, Work};
use crate::error::SearchError;
use crate::graph::Log;
use crate::metric::Metric;
use crate::vectors::Vectors;
use raypath_model::{CycleModel, Functional};
use raypath_ops::Rules;
use raypath_timing::{Observer, Progress, Sample, SimulationError, Sweep, System, Timing, simulate, sweep};
use thiserror::Error;

/// Queries whose nearest neighbours are sought.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'s> {
    /// What may be near.
    pub base: &'s Vectors,
    /// The queries.
    pub queries: &'s Vectors,
    /// Which distance.
    pub metric: Metric,
    /// What the queries are compared with.
    pub candidates: Candidates<'s>,
}

/// What queries are compared with.
#[derive(Debug, Clone, Copy)]
pub enum Candidates<'s> {
    /// All vectors of the base, as by [`Exact`](crate::Exact): no fetch waits for an answer.
    All {
        /// How many neighbours are sought: 1 to the size of the base.
        count: usize,
    },
    /// What a graph looked at, as [`Graph::logs`](crate::Graph::logs) says with the same base, queries, metric and lanes:
    /// each candidate is fetched when the one before has been answered. The first queries have a log each; those after
    /// them are not asked.
    Logged(&'s [Log]),
}

/// Why a search is not timed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TimingError {
    /// There is no such search.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// The simulation came to no end.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

impl Subject<'_> {
    /// How many queries there are to ask.
    pub fn len(&self) -> usize {
        match self.candidates {
            Candidates::All { .. } => self.queries.len(),
            Candidates::Logged(logs) => self.queries.len().min(logs.len()),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the queries of a sample cost in a datapath of `E` Euclidean and `A` angular lanes. The simulation issues as
    /// many beats. It fetches as often as there are evaluations, but for an angular query's own norm: the query is there.
    pub fn work<const E: usize, const A: usize>(&self, sample: Sample) -> Work {
        let works = sample.numbers(self.len()).map(|number| self.work_of::<E, A>(number));
        works.fold(Work::default(), |all, work| Work {
            evaluations: all.evaluations.saturating_add(work.evaluations),
            beats: all.beats.saturating_add(work.beats),
        })
    }

    /// The first queries: as many as have, together, at most `beats` beats. None if the first alone has more.
    pub fn within<const E: usize, const A: usize>(&self, beats: u64) -> Sample {
        let mut left = beats;
        let fits = |&number: &usize| {
            let rest = left.checked_sub(self.work_of::<E, A>(number).beats);
            left = rest.unwrap_or(0);
            rest.is_some()
        };
        Sample::first((0..self.len()).take_while(fits).count())
    }

    /// What one query costs.
    fn work_of<const E: usize, const A: usize>(&self, number: usize) -> Work {
        let dimensions = self.base.dimensions();
        match self.candidates {
            Candidates::All { .. } => {
                let norms = u64::from(self.metric == Metric::Angular);
                Work::of::<E, A>(self.base.len() as u64 + norms, self.metric, dimensions)
            }
            Candidates::Logged(logs) => {
                logs.get(number).map_or(Work::default(), |log| log.work::<E, A>(self.metric, dimensions))
            }
        }
    }
}

/// Searches with every beat on its way through the datapath. Answers the neighbours of each query of the sample, in order;
/// they have the bits of [`Exact::search`](crate::Exact::search), or of [`Graph::search`](crate::Graph::search). `watch`
/// hears now and then how many queries are done.
///
/// # Errors
/// Queries of another dimension than the base; a `count` that is not 1 to the size of the base; logs with candidates
/// that the base does not have. Those of [`simulate`].
pub fn time_search<const E: usize, const A: usize>(
    subject: &Subject,
    sample: Sample,
    system: &System,
    observer: &mut impl Observer,
    watch: Progress,
) -> Result<(Timing, Vec<Vec<Neighbour>>), TimingError> {
    let mut walks = walks(subject, sample)?;
    let timing = simulate(walks.iter_mut(), &system.environment, model::<E, A>(system), observer, watch)?;
    Ok((timing, walks.into_iter().map(Walk::into_neighbours).collect()))
}

/// Times a search with each number of queries in flight and each memory latency, in place of those of `system`. `watch`
/// hears how many queries are done at all points together.
///
/// # Errors
/// Those of [`time_search`].
pub fn sweep_search<const E: usize, const A: usize>(
    subject: &Subject,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    system: &System,
    watch: Progress,
) -> Result<Sweep, TimingError> {
    let walks = walks(subject, sample)?;
    let agents = || walks.iter().cloned();
    Ok(sweep(in_flight, latencies, &system.environment, &model::<E, A>(system), agents, watch)?)
}

/// The queries of a sample, before they begin.
fn walks<'s>(subject: &Subject<'s>, sample: Sample) -> Result<Vec<Walk<'s>>, SearchError> {
    let Subject { base, queries, metric, candidates } = *subject;
    let asked = sample.numbers(subject.len()).filter_map(|number| Some((number, queries.get(number)?)));
    match candidates {
        Candidates::All { count } => asked.map(|(_, query)| Walk::exact(base, query, metric, count)).collect(),
        Candidates::Logged(logs) => {
            asked.filter_map(|(number, query)| Some(Walk::logged(base, query, metric, logs.get(number)?))).collect()
        }
    }
}

/// Distances have no rules at the edges, so it makes no difference which.
fn model<const E: usize, const A: usize>(system: &System) -> CycleModel<Functional<E, A>> {
    const { assert!(E == 2 * A, "half as many angular lanes as Euclidean ones") };
    system.pipeline(Functional::new(Rules::Paper))
}
