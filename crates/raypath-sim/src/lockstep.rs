//! Netlist and models side by side.

mod canonical;
mod regression;
mod side_by_side;

pub use regression::{FailedCheck, RegressionChecks};

pub use side_by_side::{Difference, SideBySide};

use crate::engine::{Engine, NetlistEngine, observe};
use crate::traffic::Traffic;
use raypath_model::{Kind, WordModel, Words};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;

/// What a comparison found.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// Jobs that left the netlist.
    pub jobs: usize,
    /// Of them, by opcode.
    pub by_opcode: BTreeMap<u64, usize>,
    /// Clock cycles.
    pub cycles: u64,
    /// Cycles in which the source was held back.
    pub stalled: u64,
    /// Cycles, or jobs, in which the engines differed, in words; the first few.
    pub differences: Vec<String>,
    /// How many differences there were.
    pub different: usize,
}

impl Comparison {
    /// How many jobs of one kind left the netlist.
    pub fn jobs_of(&self, kind: impl Kind) -> usize {
        self.by_opcode.get(&kind.opcode()).copied().unwrap_or(0)
    }
}

/// Timing as measured at the ports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Cycles from an accepted job to its valid output, in an empty pipeline with a ready sink.
    pub latency: u64,
    /// Cycles from one output to the next while the source always offers this job and the sink always takes.
    pub initiation_interval: u64,
}

impl fmt::Display for Timing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "latency {} cycles, initiation interval {}", self.latency, self.initiation_interval)
    }
}

const DIFFERENCES_SHOWN: usize = 5;
/// After so many differences the rest tells nothing new.
const TOO_MANY: usize = 100;

/// Streams jobs through the netlist and the cycle-exact model, comparing all that their ports show in every cycle, and
/// each outcome with what `model` answers. `on_job` is told how many jobs have left and says whether to go on.
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
    observe(&mut engines, jobs, traffic, |seen| {
        found.cycles += 1;
        found.stalled += u64::from(seen.cycle.offers && !seen.shown.input_ready);
        if let Some(outcome) = seen.shown.output.as_ref().filter(|_| seen.cycle.takes) {
            *found.by_opcode.entry(outcome.kind().opcode()).or_default() += 1;
            found.jobs += 1;
            return different.get() < TOO_MANY && on_job(found.jobs);
        }
        different.get() < TOO_MANY
    });
    Comparison { differences: engines.differences, different: different.get(), ..found }
}

/// Measures latency and initiation interval at an engine's ports, after a reset. `job` may be any; a beat of a distance
/// leaves its sum behind. `None` where nothing comes out.
pub fn timing(engine: &mut dyn Engine, job: &Words) -> Option<Timing> {
    const LONG_ENOUGH: u64 = 1000;
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
    }
    let steady = outputs.get(STREAM..2 * STREAM)?;
    let gaps = steady.windows(2).map(|pair| pair[1] - pair[0]);
    engine.reset();
    Some(Timing { latency, initiation_interval: gaps.max()? })
}
