//! Simulated timing of searches.

use crate::CliError;
use crate::commands::full::{Subject, watched};
use raypath_search::{
    Candidates, Dataset, Graph, LaneCount, Metric, SearchSpec, SearchTrace, sweep_search, time_search,
};
use raypath_timing::report::Recorder;
use raypath_timing::{Sample, Sweep, System, Timing};

pub struct Queries<'d> {
    pub name: String,
    pub dataset: &'d Dataset,
    pub metric: Metric,
    pub neighbours: usize,
    /// The number of candidates kept in a graph search.
    pub ef: usize,
    /// The graph of an approximate search; `None` for an exact one.
    pub graph: Option<&'d Graph<'d>>,
    pub lanes: LaneCount,
    /// The number of simulated queries; `None` for as many as [`BEATS`] allow.
    pub max: Option<usize>,
}

/// The number of simulated beats if no number of queries is given.
pub const BEATS: u64 = 5_000_000;

/// The number of queries at each point of a sweep, and the maximum number of vectors in an exact search.
const SWEPT: usize = 128;
const SWEPT_VECTORS: usize = 256;
const IN_FLIGHT: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
const LATENCIES: [u64; 4] = [0, 100, 300, 1000];

impl Queries<'_> {
    /// The traces of the first `max` queries, or of as many as [`BEATS`] allow, but at least one.
    fn traces(&self, graph: &Graph<'_>, max: Option<usize>) -> Result<Vec<SearchTrace>, CliError> {
        let queries = &self.dataset.queries;
        let first = queries.first(max.unwrap_or(usize::MAX));
        let beats = if max.is_some() { u64::MAX } else { BEATS };
        let mut traces = watched("queries traced", first.len(), |progress| {
            graph.traces(&first, self.neighbours, self.ef, beats, progress)
        })?;
        if traces.is_empty() {
            let query = queries.get(0).unwrap_or_default();
            traces.push(graph.trace(query, self.neighbours, self.ef).map_err(CliError::unusable)?);
        }
        Ok(traces)
    }
}

impl Subject for Queries<'_> {
    fn title(&self) -> String {
        let how = if self.graph.is_some() { "through a graph" } else { "exact" };
        let (base, metric, k) = (&self.dataset.base, self.metric, self.neighbours);
        format!("{}: {k} nearest of {} x {}, {metric}, {how}", self.name, base.len(), base.dimensions())
    }

    fn names(&self) -> (&'static str, &'static str) {
        ("queries", "query")
    }

    fn count(&self) -> usize {
        self.dataset.queries.len()
    }

    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError> {
        let Dataset { base, queries, .. } = self.dataset;
        let traces = self.graph.map(|graph| self.traces(graph, self.max)).transpose()?;
        let candidates = match &traces {
            Some(traces) => Candidates::Traced(traces),
            None => Candidates::All { count: self.neighbours },
        };
        let spec = SearchSpec { base, queries, metric: self.metric, lanes: self.lanes, candidates };
        let sample = match self.max {
            Some(max) => Sample::first(max),
            None => Sample::first(spec.within(BEATS).max.max(1)),
        };
        watched("queries timed", sample.numbers(spec.len()).len(), |progress| {
            time_search(&spec, sample, system, recorder, progress).map(|(timing, _)| timing)
        })
    }

    fn sweep(&self, system: &System) -> Result<Sweep, CliError> {
        let Dataset { base, queries, .. } = self.dataset;
        let traces = self.graph.map(|graph| self.traces(graph, Some(SWEPT))).transpose()?;
        let few = base.first(SWEPT_VECTORS);
        let (base, candidates) = match &traces {
            Some(traces) => (base, Candidates::Traced(traces)),
            None => (&few, Candidates::All { count: self.neighbours.min(few.len()) }),
        };
        let spec = SearchSpec { base, queries, metric: self.metric, lanes: self.lanes, candidates };
        let sample = Sample::first(SWEPT);
        let total = sample.numbers(spec.len()).len() * IN_FLIGHT.len() * LATENCIES.len();
        watched("queries swept", total, |progress| {
            sweep_search(&spec, sample, &IN_FLIGHT, &LATENCIES, system, progress)
        })
    }

    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)> {
        // The maximum rates, with a beat in every cycle.
        let dimensions = self.dataset.base.dimensions();
        let of_own = self.metric.beats(self.lanes, dimensions);
        let vectors = timing.total_jobs() as f64 / of_own as f64 / timing.agents.max(1) as f64;
        let rate = |metric: Metric| {
            let beats = metric.beats(self.lanes, dimensions) as f64;
            let label = format!("queries per second at {clock_mhz} MHz, {metric}, at one beat per cycle");
            (label, format!("{:.4e}", clock_mhz * 1e6 / (vectors * beats)))
        };
        Metric::ALL.map(rate).to_vec()
    }
}
