use crate::{Agent, Environment, Progress, SimulationError, Timing, simulate};
use rayon::prelude::*;
use raypath_model::{CycleModel, Model};
use raypath_ops::JobKind;
use std::sync::atomic::{AtomicU64, Ordering};

/// The timing of the same agents in several environments.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sweep {
    /// A point for each memory latency and, within it, each number of agents in flight, in the given orders.
    pub points: Vec<Point>,
}

/// The timing in one environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The environment.
    pub environment: Environment,
    /// The timing in it.
    pub timing: Timing,
}

/// Simulates the agents that `agents` makes with each number of agents in flight and each memory latency, in place of
/// those of `environment`. The points run in parallel; the result does not depend on the number of threads. `progress`
/// gets the number of completed agents of all points together.
///
/// # Errors
/// The errors of [`simulate`].
pub fn sweep<M, A, I>(
    in_flight: &[usize],
    latencies: &[u64],
    environment: &Environment,
    pipeline: &CycleModel<M>,
    agents: impl Fn() -> I + Sync,
    progress: Progress,
) -> Result<Sweep, SimulationError>
where
    M: Model<Kind = JobKind>,
    CycleModel<M>: Sync,
    A: Agent<M>,
    I: IntoIterator<Item = A>,
{
    let environments: Vec<Environment> = latencies
        .iter()
        .flat_map(|latency| in_flight.iter().map(|in_flight| (*latency, *in_flight)))
        .map(|(memory_latency, in_flight)| Environment { in_flight, memory_latency, ..*environment })
        .collect();
    let completed = AtomicU64::new(0);
    let point = |environment: &Environment| {
        let counted = AtomicU64::new(0);
        let count = |agents: u64| {
            let more = agents - counted.swap(agents, Ordering::Relaxed);
            completed.fetch_add(more, Ordering::Relaxed) + more
        };
        let timing = simulate(agents(), environment, pipeline.clone(), &mut (), &|agents| progress(count(agents)))?;
        count(timing.agents);
        Ok(Point { environment: *environment, timing })
    };
    let points: Result<_, SimulationError> = environments.par_iter().map(point).collect();
    Ok(Sweep { points: points? })
}
