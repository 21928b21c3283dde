//! Cycle-exact simulation of searches.
//!
//! Each agent is a query: a [`QueryAgent`]. Queries start in the order of their numbers. The work of the external
//! circuit (square root, division, selection of the nearest, navigation of a graph) takes no cycles; each candidate
//! takes one fetch.

use crate::lanes::with_lanes;
use crate::{LaneCount, Metric, Neighbour, QueryAgent, SearchError, SearchTrace, Vectors, Work};
use raypath_model::{CycleModel, Functional};
use raypath_ops::{Job, Rules};
use raypath_timing::{
    Observer, Progress, Sample, SimulationError, Sweep, System, Timing, accepted_jobs, simulate, sweep,
};
use thiserror::Error;

/// A search to simulate.
#[derive(Debug, Clone, Copy)]
pub struct SearchSpec<'s> {
    /// The vectors to search.
    pub base: &'s Vectors,
    /// The queries.
    pub queries: &'s Vectors,
    /// The metric.
    pub metric: Metric,
    /// The lanes of the datapath.
    pub lanes: LaneCount,
    /// The vectors that queries are compared with.
    pub candidates: Candidates<'s>,
}

/// The vectors that queries are compared with.
#[derive(Debug, Clone, Copy)]
pub enum Candidates<'s> {
    /// All vectors of the base, as in [`Exact`](crate::Exact): fetches do not wait for outcomes.
    All {
        /// The number of neighbours: 1 to the size of the base.
        count: usize,
    },
    /// The candidates of a graph search, from [`Graph::traces`](crate::Graph::traces) for the same base, queries,
    /// metric and lanes, each fetched after the outcome of the previous one. Only queries with a trace are simulated.
    Traced(&'s [SearchTrace]),
}

/// The reason why the simulation of a search failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TimingError {
    /// The search is invalid.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// The simulation did not complete.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

impl SearchSpec<'_> {
    /// The number of queries.
    pub fn len(&self) -> usize {
        match self.candidates {
            Candidates::All { .. } => self.queries.len(),
            Candidates::Traced(traces) => self.queries.len().min(traces.len()),
        }
    }

    /// Whether there are no queries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The work for the queries of a sample. The simulation issues this number of beats, and a fetch for each evaluation
    /// except those of the norms of queries.
    pub fn work(&self, sample: Sample) -> Work {
        let works = sample.numbers(self.len()).map(|number| self.work_of(number));
        works.fold(Work::default(), |all, work| Work {
            evaluations: all.evaluations.saturating_add(work.evaluations),
            beats: all.beats.saturating_add(work.beats),
        })
    }

    /// The sample of the first queries that have at most `beats` beats in total; empty if the first has more.
    pub fn within(&self, beats: u64) -> Sample {
        let mut left = beats;
        let fits = |&number: &usize| {
            let rest = left.checked_sub(self.work_of(number).beats);
            left = rest.unwrap_or(0);
            rest.is_some()
        };
        Sample::first((0..self.len()).take_while(fits).count())
    }

    fn work_of(&self, number: usize) -> Work {
        let dimensions = self.base.dimensions();
        match self.candidates {
            Candidates::All { .. } => {
                let norms = u64::from(self.metric == Metric::Angular);
                Work::of(self.base.len() as u64 + norms, self.metric, self.lanes, dimensions)
            }
            Candidates::Traced(traces) => {
                traces.get(number).map_or(Work::default(), |trace| trace.work(self.metric, self.lanes, dimensions))
            }
        }
    }
}

/// Simulates a search and returns the neighbours of each query of the sample, in order. They have the bits of
/// [`Exact::search`](crate::Exact::search) or [`Graph::search`](crate::Graph::search). `progress` gets the number of
/// completed queries.
///
/// # Errors
/// Queries of another dimension than the base; a `count` that is not 1 to the size of the base; traces with candidates
/// that are not in the base; the errors of [`simulate`].
pub fn time_search(
    spec: &SearchSpec,
    sample: Sample,
    system: &System,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<(Timing, Vec<Vec<Neighbour>>), TimingError> {
    let mut agents = agents(spec, sample)?;
    let timing = with_lanes!(spec.lanes, E, A => {
        simulate(agents.iter_mut(), &system.environment, pipeline::<E, A>(system), observer, progress)?
    });
    Ok((timing, agents.into_iter().map(QueryAgent::into_neighbours).collect()))
}

/// The jobs of a search in a datapath of `E` Euclidean and `A` angular lanes, instead of those of `spec`, in the order in
/// which it accepts them. `progress` gets the number of completed
/// queries.
///
/// # Errors
/// The errors of [`time_search`].
pub fn search_jobs<const E: usize, const A: usize>(
    spec: &SearchSpec,
    sample: Sample,
    system: &System,
    progress: Progress,
) -> Result<Vec<Job<E, A>>, TimingError> {
    const { assert!(E == 2 * A, "half as many angular lanes as Euclidean ones") };
    let mut agents = agents(spec, sample)?;
    let model = Functional::<E, A>::new(Rules::Paper);
    Ok(accepted_jobs(agents.iter_mut(), system, model, progress)?)
}

/// Simulates a search with each number of queries in flight and each memory latency, in place of those of `system`.
/// `progress` gets the number of completed queries of all points together.
///
/// # Errors
/// The errors of [`time_search`].
pub fn sweep_search(
    spec: &SearchSpec,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    system: &System,
    progress: Progress,
) -> Result<Sweep, TimingError> {
    let queries = agents(spec, sample)?;
    let agents = || queries.iter().cloned();
    Ok(with_lanes!(spec.lanes, E, A => {
        sweep(in_flight, latencies, &system.environment, &pipeline::<E, A>(system), agents, progress)?
    }))
}

fn agents<'s>(spec: &SearchSpec<'s>, sample: Sample) -> Result<Vec<QueryAgent<'s>>, SearchError> {
    let SearchSpec { base, queries, metric, candidates, .. } = *spec;
    let selected = sample.numbers(spec.len()).filter_map(|number| Some((number, queries.get(number)?)));
    match candidates {
        Candidates::All { count } => selected.map(|(_, query)| QueryAgent::exact(base, query, metric, count)).collect(),
        Candidates::Traced(traces) => selected
            .filter_map(|(number, query)| Some(QueryAgent::traced(base, query, metric, traces.get(number)?)))
            .collect(),
    }
}

/// The pipeline. Distances do not depend on the rules.
fn pipeline<const E: usize, const A: usize>(system: &System) -> CycleModel<Functional<E, A>> {
    const { assert!(E == 2 * A, "half as many angular lanes as Euclidean ones") };
    system.pipeline(Functional::new(Rules::Paper))
}
