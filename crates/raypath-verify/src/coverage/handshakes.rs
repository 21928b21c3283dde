//! Coverage of the handshakes at the ports.

use super::model::CoverageModel;
use raypath_model::Control;
use raypath_ops::JobKind;

const KINDS: usize = JobKind::ALL.len();

/// What happened at the ports, in numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Handshakes {
    /// Cycles by source event, sink event, and fill level.
    cycles: [[[u64; 3]; 4]; 3],
    /// Resets by the number of jobs in the pipeline.
    resets: Vec<u64>,
    /// Accepted jobs by the operation before, the operation, and whether it came in the next cycle.
    pairs: [[[u64; 2]; KINDS]; KINDS],
    /// Withdrawn jobs by operation, and whether they had been refused.
    withdrawn: [[u64; 2]; KINDS],
}

const SOURCES: [&str; 3] = ["accepted", "refused", "idle"];
const SINKS: [&str; 4] = ["taken", "held", "ready for nothing", "idle"];
const FILLS: [&str; 3] = ["empty", "between", "full"];

impl Handshakes {
    pub(super) fn new(capacity: usize) -> Self {
        Self {
            cycles: Default::default(),
            resets: vec![0; capacity + 1],
            pairs: Default::default(),
            withdrawn: Default::default(),
        }
    }

    /// Counts a cycle. `source` is valid and ready of the input, `sink` ready and valid of the output, `inside` the
    /// number of jobs in the pipeline.
    pub(super) fn cycle(&mut self, source: (bool, bool), sink: (bool, bool), inside: usize) {
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
        let full = self.resets.len() - 1;
        let fill = if inside == 0 { 0 } else { 1 + usize::from(inside >= full) };
        self.cycles[source][sink][fill] += 1;
    }

    pub(super) fn reset(&mut self, inside: usize) {
        let capacity = self.resets.len() - 1;
        self.resets[inside.min(capacity)] += 1;
    }

    pub(super) fn pair(&mut self, before: JobKind, kind: JobKind, is_next_cycle: bool) {
        self.pairs[before as usize][kind as usize][usize::from(is_next_cycle)] += 1;
    }

    pub(super) fn withdrawn(&mut self, kind: JobKind, was_refused: bool) {
        self.withdrawn[kind as usize][usize::from(was_refused)] += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
        let sum = |mine: &mut u64, others: &u64| *mine += others;
        let cycles = self.cycles.as_flattened_mut().as_flattened_mut().iter_mut();
        cycles.zip(other.cycles.as_flattened().as_flattened()).for_each(|(mine, others)| sum(mine, others));
        self.resets.iter_mut().zip(&other.resets).for_each(|(mine, others)| sum(mine, others));
        let pairs = self.pairs.as_flattened_mut().as_flattened_mut().iter_mut();
        pairs.zip(other.pairs.as_flattened().as_flattened()).for_each(|(mine, others)| sum(mine, others));
        let withdrawn = self.withdrawn.as_flattened_mut().iter_mut();
        withdrawn.zip(other.withdrawn.as_flattened()).for_each(|(mine, others)| sum(mine, others));
    }

    /// All reachable coverage points, with their counts.
    pub(super) fn points(&self, model: &CoverageModel) -> Vec<(String, u64)> {
        let mut points = Vec::new();
        for (source, of_source) in SOURCES.iter().zip(&self.cycles) {
            for (sink, of_sink) in SINKS.iter().zip(of_source) {
                for (fill, &count) in FILLS.iter().zip(of_sink) {
                    if is_reachable(model, source, sink, fill) {
                        points.push((format!("cycle: source {source}, sink {sink}, {fill}"), count));
                    }
                }
            }
        }
        points.extend(
            self.resets.iter().enumerate().map(|(inside, &count)| (format!("reset with {inside} inside"), count)),
        );
        for &before in model.kinds {
            for &kind in model.kinds {
                let [later, next] = self.pairs[before as usize][kind as usize];
                points.push((format!("{kind} after {before}, with a gap"), later));
                if !keeps_apart(model, before, kind) {
                    points.push((format!("{kind} after {before}, in the next cycle"), next));
                }
            }
        }
        for &kind in model.kinds {
            let [unoffered, refused] = self.withdrawn[kind as usize];
            points.push((format!("{kind} withdrawn before it was refused"), unoffered));
            points.push((format!("{kind} withdrawn after it was refused"), refused));
        }
        points
    }
}

/// Whether a gate at the entrance keeps two jobs apart: with credits, beats of a sum that takes several steps.
fn keeps_apart(model: &CoverageModel, before: JobKind, kind: JobKind) -> bool {
    let is_loop = |kind: JobKind| {
        model.shape.loops.iter().any(|a_loop| a_loop.opcode == kind.opcode() && a_loop.last > a_loop.first)
    };
    model.shape.control == Control::Credit && before == kind && is_loop(kind)
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
