//! Comparison of a netlist with its models, cycle by cycle.

mod regression;
mod side_by_side;

pub use regression::{CONFIGS, FailedCheck, RegressionChecks};

pub use side_by_side::{Difference, SideBySide};

use crate::engine::{Engine, NetlistEngine, observe};
use crate::traffic::Traffic;
use raypath_model::{Kind, WordModel, Words};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;

/// The result of a comparison.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// The number of jobs whose outcome was taken.
    pub jobs: usize,
    /// The number of these jobs by opcode.
    pub by_opcode: BTreeMap<u64, usize>,
    /// The number of jobs that a reset lost, or that the source withdrew.
    pub lost: usize,
    /// The number of clock cycles.
    pub cycles: u64,
    /// The number of cycles in which a job was offered and not accepted.
    pub stalled: u64,
    /// Messages about the first differences.
    pub differences: Vec<String>,
    /// The number of differences.
    pub different: usize,
}

impl Comparison {
    /// The number of jobs of one operation whose outcome was taken.
    pub fn jobs_of(&self, kind: impl Kind) -> usize {
        self.by_opcode.get(&kind.opcode()).copied().unwrap_or(0)
    }
}

/// The timing of an operation, measured at the ports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Cycles from an accepted job to its valid output, in an empty pipeline with a ready sink.
    pub latency: u64,
    /// Cycles from one output to the next if the source always offers this job and the sink is always ready.
    pub initiation_interval: u64,
}

impl fmt::Display for Timing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "latency {} cycles, initiation interval {}", self.latency, self.initiation_interval)
    }
}

const DIFFERENCES_SHOWN: usize = 5;
/// A comparison ends after this number of differences.
const MAX_DIFFERENCES: usize = 100;

/// Runs jobs through a netlist and its cycle-exact model. Compares all output ports in every cycle, and each outcome
/// with that of `model`. `on_job` gets the number of jobs so far; the comparison ends when it returns false.
pub fn lockstep(
    netlist: &mut NetlistEngine,
    model: WordModel,
    jobs: impl Iterator<Item = Words>,
    traffic: &mut Traffic,
    mut on_job: impl FnMut(usize) -> bool,
) -> Comparison {
    let mut found = Comparison::default();
    let different = Cell::new(0);
    let mut engines = SideBySide::new(netlist, model, |_| different.set(different.get() + 1));
    let run = observe(&mut engines, jobs, traffic, |seen| {
        found.cycles += 1;
        found.stalled += u64::from(seen.cycle.offers && !seen.shown.input_ready);
        if let Some(outcome) = seen.shown.output.as_ref().filter(|_| seen.cycle.takes) {
            *found.by_opcode.entry(outcome.kind().opcode()).or_default() += 1;
            found.jobs += 1;
            return different.get() < MAX_DIFFERENCES && on_job(found.jobs);
        }
        different.get() < MAX_DIFFERENCES
    });
    Comparison { lost: run.dropped, differences: engines.differences, different: different.get(), ..found }
}

/// Measures latency and initiation interval at the ports of an engine, with a reset before and after. `job` may be of
/// any operation. `None` if the engine shows no outcome.
pub fn timing(engine: &mut dyn Engine, job: &Words) -> Option<Timing> {
    const LONG_ENOUGH: u64 = 4000;
    const STREAM: usize = 100;
    engine.reset();
    engine.present(job);
    engine.cycle(true, true);
    let latency = (1..LONG_ENOUGH).find(|_| engine.cycle(false, true).output.is_some())?;
    let mut outputs = Vec::new();
    for cycle in 0..LONG_ENOUGH {
        if engine.cycle(true, true).output.is_some() {
            outputs.push(cycle);
        }
        if outputs.len() == 2 * STREAM {
            break;
        }
    }
    let steady = outputs.get(STREAM..2 * STREAM)?;
    let gaps = steady.windows(2).map(|pair| pair[1] - pair[0]);
    engine.reset();
    Some(Timing { latency, initiation_interval: gaps.max()? })
}
