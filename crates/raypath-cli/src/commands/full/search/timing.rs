//! The timing view: the same queries through the cycle-exact datapath.

use crate::commands::full::timed::Subject;
use crate::error::CliError;
use crate::progress::watched;
use raypath_search::{Candidates, Dataset, Graph, Log, Metric, Subject as Searched, sweep_search, time_search};
use raypath_timing::report::Recorder;
use raypath_timing::{Sample, Sweep, System, Timing};

/// Queries that are asked.
pub struct Queries<'d, const E: usize, const A: usize> {
    pub name: String,
    pub dataset: &'d Dataset,
    pub metric: Metric,
    /// How many are searched for.
    pub neighbours: usize,
    /// Candidates kept in a graph.
    pub ef: usize,
    /// What leads to few of the vectors; without it all are looked at.
    pub graph: Option<&'d Graph<'d, E, A>>,
    /// How many are timed; else as many as [`BEATS`] allow.
    pub most: Option<usize>,
}

/// The number of simulated beats if no number of queries is given.
const BEATS: u64 = 5_000_000;

/// How many queries each point of a sweep simulates, and with how many vectors at most where all are looked at: each
/// vector is like the one before.
const SWEPT: usize = 128;
const SWEPT_VECTORS: usize = 256;
const IN_FLIGHT: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
const LATENCIES: [u64; 4] = [0, 100, 300, 1000];

impl<const E: usize, const A: usize> Queries<'_, E, A> {
    /// What the graph looks at for the first queries: so many, or as many as the beats allow, but one.
    fn logs(&self, graph: &Graph<'_, E, A>, most: Option<usize>) -> Result<Vec<Log>, CliError> {
        let queries = &self.dataset.queries;
        let first = queries.first(most.unwrap_or(usize::MAX));
        let beats = if most.is_some() { u64::MAX } else { BEATS };
        let mut logs = watched("queries looked through", first.len(), |watch| {
            graph.logs(&first, self.neighbours, self.ef, beats, watch)
        })?;
        if logs.is_empty() {
            let query = queries.get(0).unwrap_or_default();
            logs.push(graph.log(query, self.neighbours, self.ef).map_err(CliError::unusable)?);
        }
        Ok(logs)
    }
}

impl<const E: usize, const A: usize> Subject for Queries<'_, E, A> {
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
        let logs = self.graph.map(|graph| self.logs(graph, self.most)).transpose()?;
        let candidates = match &logs {
            Some(logs) => Candidates::Logged(logs),
            None => Candidates::All { count: self.neighbours },
        };
        let subject = Searched { base, queries, metric: self.metric, candidates };
        let sample = match self.most {
            Some(most) => Sample::first(most),
            None => Sample::first(subject.within::<E, A>(BEATS).max.max(1)),
        };
        watched("queries timed", sample.numbers(subject.len()).len(), |watch| {
            time_search::<E, A>(&subject, sample, system, recorder, watch).map(|(timing, _)| timing)
        })
    }

    fn sweep(&self, system: &System) -> Result<Sweep, CliError> {
        let Dataset { base, queries, .. } = self.dataset;
        let logs = self.graph.map(|graph| self.logs(graph, Some(SWEPT))).transpose()?;
        let few = base.first(SWEPT_VECTORS);
        let (base, candidates) = match &logs {
            Some(logs) => (base, Candidates::Logged(logs)),
            None => (&few, Candidates::All { count: self.neighbours.min(few.len()) }),
        };
        let subject = Searched { base, queries, metric: self.metric, candidates };
        let sample = Sample::first(SWEPT);
        let total = sample.numbers(subject.len()).len() * IN_FLIGHT.len() * LATENCIES.len();
        watched("queries swept", total, |watch| {
            sweep_search::<E, A>(&subject, sample, &IN_FLIGHT, &LATENCIES, system, watch)
        })
    }

    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)> {
        // With a beat in every cycle, which is what each metric can reach.
        let dimensions = self.dataset.base.dimensions();
        let of_own = self.metric.beats::<E, A>(dimensions);
        let vectors = timing.total_jobs() as f64 / of_own as f64 / timing.agents.max(1) as f64;
        let rate = |metric: Metric| {
            let beats = metric.beats::<E, A>(dimensions) as f64;
            let label = format!("queries per second at {clock_mhz} MHz, {metric}, a beat a cycle");
            (label, format!("{:.4e}", clock_mhz * 1e6 / (vectors * beats)))
        };
        Metric::ALL.map(rate).to_vec()
    }
}
