//! Searches in datapaths whose number of lanes is known at run time. The code of every number of lanes is compiled in
//! this crate, once for all callers.

use crate::{
    Exact, Graph, GraphParameters, Metric, SearchError, SearchResults, SearchSpec, SearchTrace, TimingError, Vectors,
    Work, sweep_search, time_search,
};
use raypath_timing::{Progress, Sample, Sweep, System, Timing};
use std::fmt::Debug;

/// Searches in a datapath with a number of lanes; see [`lanes`].
pub trait LaneSearch: Sync {
    /// Prepares a base and searches it as [`Exact::search`].
    ///
    /// # Errors
    /// Those of [`Exact::search`].
    fn exact(
        &self,
        base: &Vectors,
        metric: Metric,
        queries: &Vectors,
        count: usize,
        progress: Progress,
    ) -> Result<SearchResults, SearchError>;

    /// Builds a graph as [`Graph::build`].
    ///
    /// # Errors
    /// Those of [`Graph::build`].
    fn graph<'v>(
        &self,
        base: &'v Vectors,
        metric: Metric,
        parameters: &GraphParameters,
        progress: Progress,
    ) -> Result<Box<dyn LaneGraph + 'v>, SearchError>;

    /// As [`SearchSpec::within`].
    fn within(&self, spec: &SearchSpec, beats: u64) -> Sample;

    /// Simulates a search as [`time_search`], without an observer.
    ///
    /// # Errors
    /// Those of [`time_search`].
    fn time(
        &self,
        spec: &SearchSpec,
        sample: Sample,
        system: &System,
        progress: Progress,
    ) -> Result<Timing, TimingError>;

    /// Simulates a search as [`sweep_search`].
    ///
    /// # Errors
    /// Those of [`sweep_search`].
    fn sweep(
        &self,
        spec: &SearchSpec,
        sample: Sample,
        in_flight: &[usize],
        latencies: &[u64],
        system: &System,
        progress: Progress,
    ) -> Result<Sweep, TimingError>;
}

/// A [`Graph`] of any number of lanes.
pub trait LaneGraph: Debug {
    /// As [`Graph::build_work`].
    fn build_work(&self) -> Work;

    /// As [`Graph::search`].
    ///
    /// # Errors
    /// Those of [`Graph::search`].
    fn search(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        progress: Progress,
    ) -> Result<SearchResults, SearchError>;

    /// As [`Graph::trace`].
    ///
    /// # Errors
    /// Those of [`Graph::trace`].
    fn trace(&self, query: &[f32], count: usize, ef: usize) -> Result<SearchTrace, SearchError>;

    /// As [`Graph::traces`].
    ///
    /// # Errors
    /// Those of [`Graph::traces`].
    fn traces(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        beats: u64,
        progress: Progress,
    ) -> Result<Vec<SearchTrace>, SearchError>;
}

/// Searches in a datapath of `count` Euclidean lanes and half as many angular ones; `None` unless `count` is 2, 4, 8,
/// 16, 32 or 64.
// Inlined, it would be compiled in the crates of the callers, with all that it refers to.
#[inline(never)]
pub fn lanes(count: usize) -> Option<&'static dyn LaneSearch> {
    Some(match count {
        2 => &Lanes::<2, 1>,
        4 => &Lanes::<4, 2>,
        8 => &Lanes::<8, 4>,
        16 => &Lanes::<16, 8>,
        32 => &Lanes::<32, 16>,
        64 => &Lanes::<64, 32>,
        _ => return None,
    })
}

struct Lanes<const E: usize, const A: usize>;

impl<const E: usize, const A: usize> LaneSearch for Lanes<E, A> {
    fn exact(
        &self,
        base: &Vectors,
        metric: Metric,
        queries: &Vectors,
        count: usize,
        progress: Progress,
    ) -> Result<SearchResults, SearchError> {
        Exact::<E, A>::new(base, metric).search(queries, count, progress)
    }

    fn graph<'v>(
        &self,
        base: &'v Vectors,
        metric: Metric,
        parameters: &GraphParameters,
        progress: Progress,
    ) -> Result<Box<dyn LaneGraph + 'v>, SearchError> {
        Ok(Box::new(Graph::<E, A>::build(base, metric, parameters, progress)?))
    }

    fn within(&self, spec: &SearchSpec, beats: u64) -> Sample {
        spec.within::<E, A>(beats)
    }

    fn time(
        &self,
        spec: &SearchSpec,
        sample: Sample,
        system: &System,
        progress: Progress,
    ) -> Result<Timing, TimingError> {
        time_search::<E, A>(spec, sample, system, &mut (), progress).map(|(timing, _)| timing)
    }

    fn sweep(
        &self,
        spec: &SearchSpec,
        sample: Sample,
        in_flight: &[usize],
        latencies: &[u64],
        system: &System,
        progress: Progress,
    ) -> Result<Sweep, TimingError> {
        sweep_search::<E, A>(spec, sample, in_flight, latencies, system, progress)
    }
}

impl<const E: usize, const A: usize> LaneGraph for Graph<'_, E, A> {
    fn build_work(&self) -> Work {
        self.build_work()
    }

    fn search(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        progress: Progress,
    ) -> Result<SearchResults, SearchError> {
        self.search(queries, count, ef, progress)
    }

    fn trace(&self, query: &[f32], count: usize, ef: usize) -> Result<SearchTrace, SearchError> {
        self.trace(query, count, ef)
    }

    fn traces(
        &self,
        queries: &Vectors,
        count: usize,
        ef: usize,
        beats: u64,
        progress: Progress,
    ) -> Result<Vec<SearchTrace>, SearchError> {
        self.traces(queries, count, ef, beats, progress)
    }
}
