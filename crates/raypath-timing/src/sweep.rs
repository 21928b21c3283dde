use crate::agent::Agent;
use crate::machine::Machine;
use crate::simulation::{SimulationError, Watch, simulate};
use crate::timing::Timing;
use rayon::prelude::*;
use raypath_model::{CycleModel, Model};
use raypath_ops::JobKind;
use std::sync::atomic::{AtomicU64, Ordering};

/// The same agents on many machines.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sweep {
    /// One for each number of agents in flight and each latency; latencies in the order in which they were given, and for
    /// each of them the numbers in flight.
    pub points: Vec<Point>,
}

/// One machine, and how long it took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The machine.
    pub machine: Machine,
    /// How long it took.
    pub timing: Timing,
}

/// Runs the agents that `agents` makes on machines like `machine` with each number of agents in flight and each memory
/// latency. The points are spread over the cores; what comes out does not depend on how many there are.
///
/// # Errors
/// Those of [`simulate`]; `watch` is told of the agents of all points together.
pub fn sweep<M, A, I>(
    in_flight: &[usize],
    latencies: &[u64],
    machine: &Machine,
    model: &CycleModel<M>,
    agents: impl Fn() -> I + Sync,
    watch: Watch,
) -> Result<Sweep, SimulationError>
where
    M: Model<Kind = JobKind>,
    CycleModel<M>: Sync,
    A: Agent<M>,
    I: IntoIterator<Item = A>,
{
    let machines: Vec<Machine> = latencies
        .iter()
        .flat_map(|latency| in_flight.iter().map(|in_flight| (*latency, *in_flight)))
        .map(|(memory_latency, in_flight)| Machine { in_flight, memory_latency, ..*machine })
        .collect();
    let all = AtomicU64::new(0);
    let point = |machine: &Machine| {
        let told = AtomicU64::new(0);
        let count = |agents: u64| {
            let more = agents - told.swap(agents, Ordering::Relaxed);
            all.fetch_add(more, Ordering::Relaxed) + more
        };
        let timing = simulate(agents(), machine, model.clone(), &mut (), &|agents| watch(count(agents)))?;
        count(timing.agents);
        Ok(Point { machine: *machine, timing })
    };
    let points: Result<_, SimulationError> = machines.par_iter().map(point).collect();
    Ok(Sweep { points: points? })
}
