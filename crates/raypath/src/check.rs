//! Netlist and models side by side.

use crate::engine::{CycleEngine, Engine, NetlistEngine, Shown};
use crate::traffic::Traffic;
use raypath_model::Functional;
use raypath_ops::{Job, JobKind, Outcome, Rules};
use std::collections::VecDeque;

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
    /// Cycles from one output to the next while the source always offers and the sink always takes.
    pub initiation_interval: u64,
}

const DIFFERENCES_SHOWN: usize = 5;
/// After so many differences the rest tells nothing new; a netlist that answers nothing would go on for ever.
const TOO_MANY: usize = 100;

/// Streams jobs through the netlist and the cycle-exact model, comparing all that their ports show in every cycle, and
/// each outcome with the functional model's. `on_cycle` is told how many jobs have left and says whether to go on.
pub fn lockstep(
    netlist: &mut NetlistEngine,
    rules: Rules,
    jobs: impl Iterator<Item = Job>,
    traffic: &mut Traffic,
    mut on_cycle: impl FnMut(usize) -> bool,
) -> Comparison {
    let mut cycle_model = CycleEngine::new(rules);
    let mut functional = Functional::new(rules);
    let mut jobs = jobs.peekable();
    let mut in_flight: VecDeque<Outcome> = VecDeque::new();
    let mut found = Comparison::default();
    while (jobs.peek().is_some() || !in_flight.is_empty()) && found.different < TOO_MANY && on_cycle(found.jobs) {
        let (offers, output_ready) = traffic.next_cycle();
        let offered = jobs.peek().filter(|_| offers);
        if let Some(job) = offered {
            netlist.present(job);
            cycle_model.present(job);
        }
        let input_valid = offered.is_some();
        let shown = netlist.cycle(input_valid, output_ready);
        let modelled = cycle_model.cycle(input_valid, output_ready);
        if shown != modelled {
            found.differs(format!("the netlist shows {shown:?}, the cycle-exact model {modelled:?}"));
        }
        found.cycles += 1;
        found.stalled += u64::from(input_valid && !shown.input_ready);
        if let Shown { output: Some(outcome), .. } = shown {
            let strays = netlist.stray_outputs();
            if !strays.is_empty() {
                found.differs(format!("outputs of other modes are not zero: {}", strays.join(", ")));
            }
            if output_ready {
                let expected = in_flight.pop_front();
                if expected != Some(outcome) {
                    found.differs(format!("the netlist answers {outcome:?}, the functional model {expected:?}"));
                }
                found.by_kind[outcome.kind() as usize] += 1;
                found.jobs += 1;
            }
        }
        if input_valid && shown.input_ready {
            in_flight.extend(jobs.next().map(|job| functional.run(&job)));
        }
    }
    found
}

impl Comparison {
    fn differs(&mut self, what: String) {
        self.different += 1;
        if self.differences.len() < DIFFERENCES_SHOWN {
            self.differences.push(format!("cycle {}, job {}: {what}", self.cycles, self.jobs));
        }
    }
}

/// Measures latency and initiation interval at an engine's ports, after a reset. `job` may be any; a beat of a distance
/// leaves its sum behind. `None` where nothing comes out.
pub fn timing(engine: &mut dyn Engine, job: &Job) -> Option<Timing> {
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
