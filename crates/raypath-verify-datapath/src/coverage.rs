//! Coverage: what a campaign must have reached besides the lines and toggles of the text, which `text-coverage` counts.
//!
//! A point is an operand's class of numbers, a decision of an outcome, the sum that a beat finds, or an event at the
//! ports. Whether the stimuli reach the rules is shown otherwise: the item `models` refutes an oracle without each rule.

use raypath_float::Format;
use raypath_model::{Control, OperationId, Shape, WordModel, Words};
use raypath_oracle::layout::{Field, Layout};
use raypath_sim::engine::Seen;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The classes of a number.
const CLASSES: [&str; 12] =
    ["+0", "+subnormal", "+1", "+normal", "+∞", "−0", "−subnormal", "−1", "−normal", "−∞", "NaN", "NaN, not canonical"];

/// The class of a code, as a position in [`CLASSES`].
fn class(format: Format, code: u64) -> usize {
    let minus = 1 << (format.ieee_width() - 1);
    let (magnitude, least_normal) = (code & (minus - 1), 1 << format.fraction_width());
    let one = ((1 << (format.exponent() - 1)) - 1) << format.fraction_width();
    let of_magnitude = match magnitude {
        0 => 0,
        _ if magnitude < least_normal => 1,
        _ if magnitude == one => 2,
        _ if magnitude < format.infinity() => 3,
        _ if magnitude == format.infinity() => 4,
        _ => return if code == format.nan() { 10 } else { 11 },
    };
    5 * usize::from(code & minus != 0) + of_magnitude
}

/// What a sum can be when the next beat is added to it.
const SUMS: [&str; 4] = ["zero", "a number", "±∞", "NaN"];
/// What the source and the sink do in a cycle.
const SOURCES: [&str; 3] = ["accepted", "refused", "idle"];
const SINKS: [&str; 4] = ["taken", "held", "ready for nothing", "idle"];
/// How many jobs are inside.
const FILLS: [&str; 3] = ["empty", "between", "full"];

/// Decisions of an operation: the ports whose words make a decision, and all its values. Words of several ports are
/// written one after the other.
type Decision = (&'static str, fn() -> Vec<String>);

/// The decisions of each operation.
static DECISIONS: [(&str, &[Decision]); 7] = [
    ("quadbox", &[("is_intersect", || hits(4)), ("box_index", orders)]),
    ("quantised_box", &[("is_intersect", || hits(4)), ("box_index", orders)]),
    ("octbox", &[("octbox_is_intersect", || hits(8))]),
    ("triangle", &[("triangle_hit", || numbers(2)), ("facing", || numbers(2))]),
    ("key_compare", &[("child_index", || numbers(37))]),
    ("point_in_box", &[("is_inside", || numbers(16))]),
    ("sphere", &[("sphere_hit", || numbers(2))]),
];

fn numbers(count: u64) -> Vec<String> {
    (0..count).map(|number| number.to_string()).collect()
}

/// Masks of the first boxes of so many: hits come first.
fn hits(boxes: u32) -> Vec<String> {
    (0..=boxes).map(|hits| ((1 << hits) - 1).to_string()).collect()
}

/// The orders of four boxes.
fn orders() -> Vec<String> {
    let all = (0..256).map(|number| [number >> 6, number >> 4 & 3, number >> 2 & 3, number & 3]);
    let orders = all.filter(|order| (0..4).all(|place| order.contains(&place)));
    orders.map(|order| order.map(|place| place.to_string()).concat()).collect()
}

/// The coverage points of a datapath.
pub struct CoverageModel {
    model: WordModel,
    layout: Layout,
    shape: Shape,
}

impl CoverageModel {
    /// The points of a datapath with this pipeline.
    pub fn new(model: &WordModel, shape: &Shape) -> Self {
        Self { layout: Layout::of(model), model: model.clone(), shape: shape.clone() }
    }

    /// The points that a campaign can reach.
    pub fn points(&self) -> BTreeSet<String> {
        let mut points = BTreeSet::new();
        let kinds = self.model.kinds();
        for &kind in &kinds {
            let fields = self.layout.fields(kind.name()).iter();
            let operands: BTreeSet<String> =
                fields.filter(|field| field.is_number()).map(|field| operand(kind, *field)).collect();
            let classes = operands.iter().flat_map(|of| CLASSES.iter().map(move |class| format!("{of} {class}")));
            points.extend(classes);
            points.extend(
                self.decisions(kind).flat_map(|(port, values)| {
                    values().into_iter().map(move |value| format!("{kind}: {port} = {value}"))
                }),
            );
            if self.layout.fields(kind.name()).contains(&Field::Mask) {
                points.extend(SUMS.map(|sum| format!("{kind}: added to {sum}")));
                points.insert(format!("{kind}: the first after a reset that lost a sum"));
            }
            points.extend(["", ", after it was refused"].map(|refused| format!("{kind}: withdrawn{refused}")));
            for &before in &kinds {
                points.insert(format!("{kind} after {before}, with a gap"));
                if !self.keeps_apart(before, kind) {
                    points.insert(format!("{kind} after {before}, in the next cycle"));
                }
            }
        }
        points.extend((0..=self.shape.capacity()).map(|inside| self.reset(inside)));
        for (source, sink, fill) in cycles() {
            if self.is_reachable(source, sink, fill) {
                points.insert(cycle(source, sink, fill));
            }
        }
        points
    }

    /// A reset with so many jobs inside, in sixteenths of the capacity: a single number is rare in a deep pipeline.
    fn reset(&self, inside: usize) -> String {
        let capacity = self.shape.capacity();
        format!("reset with {} sixteenths inside", (16 * inside.min(capacity)).div_ceil(capacity))
    }

    fn decisions(&self, kind: OperationId) -> impl Iterator<Item = &'static Decision> + '_ {
        let decisions = DECISIONS.iter().filter(move |(name, _)| *name == kind.name()).flat_map(|(_, all)| *all);
        let ports = self.model.outputs(kind);
        decisions.filter(move |(port, _)| ports.iter().any(|of| of.name.starts_with(port)))
    }

    /// Whether a gate at the entrance keeps two jobs apart: with an interval, all jobs; with credits, beats of a sum
    /// that takes several steps.
    fn keeps_apart(&self, before: OperationId, next: OperationId) -> bool {
        let is_loop = self.shape.loops.iter().any(|of| of.opcode == next.opcode() && of.last > of.first);
        self.shape.control == Control::Credit && before == next && is_loop || self.shape.interval > 1
    }

    /// Whether a combination of events can occur. An empty pipeline has no output and accepts; a full one has an output
    /// and refuses. Without sums of several steps, the pipeline refuses only after the sink has stalled: with credits
    /// it is then full, and with skid buffers every step up to the output holds a job, so that there is an output until
    /// the entrance is ready again.
    fn is_reachable(&self, source: usize, sink: usize, fill: usize) -> bool {
        let (shows, accepts, refuses) = (sink < 2, source == 0, source == 1);
        match fill {
            0 => !shows && !refuses,
            2 => shows && !accepts,
            _ if refuses && self.shape.loops.is_empty() => shows && self.shape.control == Control::Skid,
            _ => true,
        }
    }
}

fn cycles() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..SOURCES.len() * SINKS.len() * FILLS.len()).map(|number| (number % 3, number / 3 % 4, number / 12))
}

fn cycle(source: usize, sink: usize, fill: usize) -> String {
    format!("cycle: source {}, sink {}, {}", SOURCES[source], SINKS[sink], FILLS[fill])
}

/// The name of an operand: that of its kind of field, such as `Origin`.
fn operand(kind: OperationId, field: Field) -> String {
    let name = format!("{field:?}");
    format!("{kind}: {}", name.split(['(', ' ']).next().unwrap_or_default())
}

/// Follows the jobs of an episode through a pipeline, and collects the points that they reach.
pub struct Tracker<'t> {
    coverage: &'t CoverageModel,
    jobs: &'t [Words],
    points: BTreeSet<String>,
    /// The classes of the operands of jobs that have left.
    classes: BTreeSet<(OperationId, usize, usize)>,
    /// Whether the job at the entrance has been refused.
    refused: bool,
    /// The operation that entered last, and whether it entered in the last cycle.
    entered: Option<(OperationId, bool)>,
    /// What the next beat of an operation and accumulator finds; after a reset, whether a sum was lost.
    sums: BTreeMap<(OperationId, u64), usize>,
    lost: BTreeSet<(OperationId, u64)>,
    cycles: [bool; 36],
}

impl<'t> Tracker<'t> {
    /// A tracker of an empty pipeline.
    pub fn new(coverage: &'t CoverageModel, jobs: &'t [Words]) -> Self {
        Self {
            coverage,
            jobs,
            points: BTreeSet::new(),
            classes: BTreeSet::new(),
            refused: false,
            entered: None,
            sums: BTreeMap::new(),
            lost: BTreeSet::new(),
            cycles: [false; 36],
        }
    }

    /// Follows one cycle.
    pub fn observe(&mut self, seen: &Seen) {
        if let Some(job) = seen.withdrawn.and_then(|index| self.jobs.get(index)) {
            let after = if std::mem::take(&mut self.refused) { ", after it was refused" } else { "" };
            self.points.insert(format!("{}: withdrawn{after}", job.kind()));
        }
        if seen.cycle.resets {
            self.points.insert(self.coverage.reset(seen.inside));
            let sums = std::mem::take(&mut self.sums).into_iter().filter(|(_, sum)| *sum != 0);
            self.lost.extend(sums.map(|(of, _)| of));
            self.entered = None;
            return;
        }
        let (offers, takes, shown) = (seen.cycle.offers, seen.cycle.takes, &seen.shown.output);
        let source = if !offers { 2 } else { usize::from(!seen.shown.input_ready) };
        let sink = usize::from(!takes) + if shown.is_some() { 0 } else { 2 };
        let fill = if seen.inside == 0 { 0 } else { 1 + usize::from(seen.inside >= self.coverage.shape.capacity()) };
        self.cycles[source + 3 * sink + 12 * fill] = true;
        if let (Some(index), Some(outcome)) = (seen.left, shown) {
            self.leaves(index, outcome);
        }
        match seen.entered.and_then(|index| self.jobs.get(index)) {
            Some(job) => {
                self.refused = false;
                if let Some((before, is_next)) = self.entered.replace((job.kind(), true)) {
                    let gap = if is_next { "in the next cycle" } else { "with a gap" };
                    self.points.insert(format!("{} after {before}, {gap}", job.kind()));
                }
            }
            None => {
                self.refused |= offers;
                self.entered = self.entered.map(|(operation, _)| (operation, false));
            }
        }
    }

    /// The points of the episode.
    pub fn finish(mut self) -> BTreeSet<String> {
        for (kind, field, class) in std::mem::take(&mut self.classes) {
            let field = self.coverage.layout.fields(kind.name())[field];
            self.points.insert(format!("{} {}", operand(kind, field), CLASSES[class]));
        }
        let seen = cycles().filter(|(source, sink, fill)| self.cycles[source + 3 * sink + 12 * fill]);
        self.points.extend(seen.map(|(source, sink, fill)| cycle(source, sink, fill)));
        self.points
    }

    fn leaves(&mut self, index: usize, outcome: &Words) {
        let (kind, format, coverage) = (outcome.kind(), self.coverage.model.format(), self.coverage);
        let (fields, words) = (coverage.layout.fields(kind.name()), self.jobs[index].as_words());
        let word = |wanted: Field| fields.iter().zip(words).find(|(field, _)| **field == wanted).map(|(_, word)| *word);
        let mask = word(Field::Mask);
        for (place, (field, code)) in fields.iter().zip(words).enumerate() {
            // A masked lane is no operand.
            let is_masked = matches!(field, Field::Lane { lane, .. } if mask.unwrap_or(u64::MAX) >> lane & 1 == 0);
            if field.is_number() && !is_masked {
                self.classes.insert((kind, place, class(format, *code)));
            }
        }
        let ports = coverage.model.outputs(kind).iter().zip(outcome.as_words());
        for (name, _) in coverage.decisions(kind) {
            let words = ports.clone().filter(|(port, _)| port.name.starts_with(name));
            // Writing to a String always succeeds.
            let mut point = format!("{kind}: {name} = ");
            words.for_each(|(_, word)| _ = write!(point, "{word}"));
            self.points.insert(point);
        }
        if mask.is_some() {
            let which = (kind, word(Field::Accumulator).unwrap_or(0));
            let found = self.sums.get(&which).copied().unwrap_or(0);
            self.points.insert(format!("{kind}: added to {}", SUMS[found]));
            if self.lost.remove(&which) {
                self.points.insert(format!("{kind}: the first after a reset that lost a sum"));
            }
            let is_last = word(Field::Reset).is_some_and(|word| word & 1 == 1);
            let sum = match class(format, outcome.as_words().first().copied().unwrap_or(0)) {
                _ if is_last => 0,
                0 | 5 => 0,
                4 | 9 => 2,
                10.. => 3,
                _ => 1,
            };
            self.sums.insert(which, sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_ieee_754() {
        let of = |number: f32| CLASSES[class(Format::BINARY32, number.to_bits().into())];
        let numbers = [0.0, 1e-40, 1.0, 2.0, f32::INFINITY, -0.0, -1e-40, -1.0, -2.0, f32::NEG_INFINITY];
        assert_eq!(numbers.map(of), CLASSES[..10]);
        assert_eq!(
            [0x7fc0_0000, 0x7fc0_0001, 0xffc0_0000].map(f32::from_bits).map(of),
            [10, 11, 11].map(|i| CLASSES[i])
        );
        assert_eq!([f32::MAX, f32::MIN_POSITIVE, f32::from_bits(0x007f_ffff)].map(of), [3, 3, 1].map(|i| CLASSES[i]));
        assert_eq!(
            (orders().len(), orders()[0].as_str(), hits(2)),
            (24, "0123", vec!["0".into(), "1".into(), "3".into()])
        );
    }
}
