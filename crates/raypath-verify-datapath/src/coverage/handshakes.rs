//! Coverage of the handshakes at the ports.

use super::model::CoverageModel;
use raypath_model::Control;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// The number of events at the ports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Handshakes {
    /// The number of jobs that fit into the pipeline.
    capacity: usize,
    #[serde(with = "pairs")]
    counts: HashMap<Event, u64>,
}

/// An event at the ports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum Event {
    /// A cycle, by source event, sink event and fill level: positions in `SOURCES`, `SINKS` and `FILLS`.
    Cycle(usize, usize, usize),
    /// A reset with this number of jobs in the pipeline.
    Reset(usize),
    /// An accepted job: the operation before, the operation, by position, and whether it came in the next cycle.
    Pair(usize, usize, bool),
    /// A withdrawn job's operation, by position, and whether the job had been refused.
    Withdrawn(usize, bool),
}

/// Counts as a sorted list: the keys of a JSON object are text.
mod pairs {
    use crate::coverage::handshakes::Event;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::collections::{BTreeMap, HashMap};

    pub fn serialize<S: Serializer>(counts: &HashMap<Event, u64>, to: S) -> Result<S::Ok, S::Error> {
        let sorted: BTreeMap<_, _> = counts.iter().collect();
        sorted.into_iter().collect::<Vec<_>>().serialize(to)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<HashMap<Event, u64>, D::Error> {
        Ok(Vec::deserialize(from)?.into_iter().collect())
    }
}

const SOURCES: [&str; 3] = ["accepted", "refused", "idle"];
const SINKS: [&str; 4] = ["taken", "held", "ready for nothing", "idle"];
const FILLS: [&str; 3] = ["empty", "between", "full"];

impl Handshakes {
    pub(super) fn new(capacity: usize) -> Self {
        Self { capacity, counts: HashMap::new() }
    }

    /// Counts a cycle. `source` is valid and ready of the input, `sink` ready and valid of the output, `inside` the
    /// number of jobs in the pipeline.
    pub(super) fn count_cycle(&mut self, source: (bool, bool), sink: (bool, bool), inside: usize) {
        let source = match source {
            (true, true) => 0,
            (true, false) => 1,
            (false, _) => 2,
        };
        let sink = match sink {
            (true, true) => 0,
            (false, true) => 1,
            (true, false) => 2,
            (false, false) => 3,
        };
        let fill = if inside == 0 { 0 } else { 1 + usize::from(inside >= self.capacity) };
        self.count(Event::Cycle(source, sink, fill));
    }

    pub(super) fn count(&mut self, event: Event) {
        *self.counts.entry(event).or_default() += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
        other.counts.iter().for_each(|(event, count)| *self.counts.entry(*event).or_default() += count);
    }

    /// All reachable coverage points, with their counts.
    pub(super) fn points(&self, model: &CoverageModel) -> Vec<(String, u64)> {
        let mut points = Vec::new();
        let mut add = |name: String, event| points.push((name, self.counts.get(&event).copied().unwrap_or(0)));
        for (source, source_name) in SOURCES.iter().enumerate() {
            for (sink, sink_name) in SINKS.iter().enumerate() {
                for (fill, fill_name) in FILLS.iter().enumerate() {
                    if is_reachable(model, source_name, sink_name, fill_name) {
                        let name = format!("cycle: source {source_name}, sink {sink_name}, {fill_name}");
                        add(name, Event::Cycle(source, sink, fill));
                    }
                }
            }
        }
        (0..=self.capacity).for_each(|inside| add(format!("reset with {inside} inside"), Event::Reset(inside)));
        let name = |index: usize| model.operations[index].kind;
        for before in 0..model.operations.len() {
            for next in 0..model.operations.len() {
                add(format!("{} after {}, with a gap", name(next), name(before)), Event::Pair(before, next, false));
                if !keeps_apart(model, before, next) {
                    let name = format!("{} after {}, in the next cycle", name(next), name(before));
                    add(name, Event::Pair(before, next, true));
                }
            }
        }
        for index in 0..model.operations.len() {
            add(format!("{} withdrawn before it was refused", name(index)), Event::Withdrawn(index, false));
            add(format!("{} withdrawn after it was refused", name(index)), Event::Withdrawn(index, true));
        }
        points
    }
}

/// Whether a gate at the entrance keeps two jobs apart: with an interval, all jobs; with credits, beats of a sum that
/// takes several steps.
fn keeps_apart(model: &CoverageModel, before: usize, next: usize) -> bool {
    let opcode = model.operations[next].kind.opcode();
    let is_loop = || model.shape.loops.iter().any(|a_loop| a_loop.opcode == opcode && a_loop.last > a_loop.first);
    let waits = model.shape.control == Control::Credit && before == next && is_loop();
    waits || model.shape.interval > 1
}

/// Whether a combination of events can occur. An empty pipeline has no output and accepts; a full one has an output and
/// refuses. Without sums of several steps, the pipeline refuses only after the sink has stalled: with credits it is
/// then full, and with skid buffers every step up to the output holds a job, so that there is an output until the
/// entrance is ready again.
fn is_reachable(model: &CoverageModel, source: &str, sink: &str, fill: &str) -> bool {
    let shows = ["taken", "held"].contains(&sink);
    let has_loops = !model.shape.loops.is_empty();
    match fill {
        "empty" => !shows && source != "refused",
        "full" => shows && source != "accepted",
        _ if source == "refused" && !has_loops => shows && model.shape.control == Control::Skid,
        _ => true,
    }
}
