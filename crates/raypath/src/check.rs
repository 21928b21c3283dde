//! Netlist and models side by side.

mod everyday;

pub use everyday::{Everyday, Failed};

use crate::engine::{CycleEngine, Engine, NetlistEngine, Shown, drive};
use crate::traffic::Traffic;
use raypath_model::{Model, OnPorts};
use raypath_ops::JobKind;
use std::cell::Cell;
use std::collections::VecDeque;
use std::fmt;

/// What a comparison found.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// Jobs that left the netlist.
    pub jobs: usize,
    /// Of them, by opcode.
    pub by_kind: [usize; JobKind::ALL.len()],
    /// Clock cycles.
    pub cycles: u64,
    /// Cycles in which the source was held back.
    pub stalled: u64,
    /// Cycles, or jobs, in which the engines differed, in words; the first few.
    pub differences: Vec<String>,
    /// How many differences there were.
    pub different: usize,
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
pub fn lockstep<M: Model>(
    netlist: &mut NetlistEngine<M>,
    model: M,
    jobs: impl Iterator<Item = M::Job>,
    traffic: &mut Traffic,
    mut on_job: impl FnMut(usize) -> bool,
) -> Comparison {
    let different = Cell::new(0);
    let mut engines = SideBySide {
        cycle_model: CycleEngine::new(model.clone(), netlist.shape()),
        netlist,
        functional: model,
        in_flight: VecDeque::new(),
        found: Comparison::default(),
        different: &different,
    };
    drive(&mut engines, jobs, traffic, |index, _| different.get() < TOO_MANY && on_job(index + 1));
    engines.found.different = different.get();
    engines.found
}

/// Netlist and models as one engine, which shows what the netlist shows.
struct SideBySide<'n, M: Model> {
    netlist: &'n mut NetlistEngine<M>,
    cycle_model: CycleEngine<M>,
    functional: M,
    /// What the functional model answers to the jobs presented, oldest first.
    in_flight: VecDeque<M::Outcome>,
    found: Comparison,
    /// Seen from outside while the engines run.
    different: &'n Cell<usize>,
}

impl<M: Model> Engine<M> for SideBySide<'_, M> {
    fn present(&mut self, job: &M::Job) {
        self.netlist.present(job);
        self.cycle_model.present(job);
        self.in_flight.push_back(self.functional.run(job));
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown<M::Outcome> {
        let shown = self.netlist.cycle(input_valid, output_ready);
        let modelled = self.cycle_model.cycle(input_valid, output_ready);
        if shown != modelled {
            self.differs(format!("the netlist shows {shown:?}, the cycle-exact model {modelled:?}"));
        }
        self.found.cycles += 1;
        self.found.stalled += u64::from(input_valid && !shown.input_ready);
        if let Some(outcome) = shown.output {
            let improper = self.netlist.improper_outputs(&outcome);
            if !improper.is_empty() {
                self.differs(format!("the netlist shows {outcome:?}, but {}", improper.join(", ")));
            }
            if output_ready {
                let expected = self.in_flight.pop_front();
                if expected != Some(outcome) {
                    self.differs(format!("the netlist answers {outcome:?}, the functional model {expected:?}"));
                }
                self.found.by_kind[outcome.kind() as usize] += 1;
                self.found.jobs += 1;
            }
        }
        shown
    }

    fn reset(&mut self) {
        self.netlist.reset();
        self.cycle_model.reset();
        self.functional.reset();
        self.in_flight.clear();
    }
}

impl<M: Model> SideBySide<'_, M> {
    fn differs(&mut self, what: String) {
        self.different.set(self.different.get() + 1);
        if self.found.differences.len() < DIFFERENCES_SHOWN {
            self.found.differences.push(format!("cycle {}, job {}: {what}", self.found.cycles, self.found.jobs));
        }
    }
}

/// Measures latency and initiation interval at an engine's ports, after a reset. `job` may be any; a beat of a distance
/// leaves its sum behind. `None` where nothing comes out.
pub fn timing<M: Model>(engine: &mut dyn Engine<M>, job: &M::Job) -> Option<Timing> {
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
