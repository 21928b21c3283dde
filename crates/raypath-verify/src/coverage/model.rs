//! The coverage points of a configuration, and which of them a job covers.

use super::operands::{CLASSES, class, group, groups};
use super::rules::{
    AccumulatorState, PERMUTATIONS, RULES_AT_ENTRY, Rounded, Rule, box_rules, permutation, rules_at_entry,
    rules_at_exit, triangle_rules,
};
use crate::layout::{Field, Layout};
use raypath_model::Shape;
use raypath_ops::{JobKind, Rules};
use raypath_rtl::Config;

/// The coverage points of a configuration.
#[derive(Debug, Clone)]
pub struct CoverageModel {
    /// The points of each operation; none for operations that the configuration lacks.
    pub(super) points: Vec<Vec<CoveragePoint>>,
    /// The number of jobs that fit into the pipeline.
    pub(super) capacity: usize,
    /// The pipeline's shape.
    pub(super) shape: Shape,
    pub(super) config: Config,
    layout: Layout,
}

/// A coverage point of an operation: something that a job can exercise.
#[derive(Debug, Clone)]
pub struct CoveragePoint {
    /// The point's name in reports.
    pub name: String,
    is_known_at_exit_only: bool,
    is_impossible: bool,
}

/// How a job entered the pipeline, and how it left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JobPath {
    /// Whether it was refused at least once before it was accepted.
    pub waited: bool,
    /// How it left.
    pub end: JobEnd,
}

/// How a job left the pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobEnd {
    /// The sink took the outcome in its first cycle.
    Taken,
    /// The sink stalled the outcome at least once.
    Held,
    /// A reset discarded the job.
    Lost,
}

/// The names of all paths, in the order of [`JobPath::index`].
pub(super) const PATHS: [&str; 6] = ["taken", "held", "lost", "waited, taken", "waited, held", "waited, lost"];

impl JobPath {
    /// Neither source nor sink stalled.
    pub const STRAIGHT: Self = Self { waited: false, end: JobEnd::Taken };

    /// The path's position in `PATHS`.
    pub fn index(self) -> usize {
        3 * usize::from(self.waited) + self.end as usize
    }
}

/// The coverage points of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JobPoints {
    /// The job's operation.
    pub kind: JobKind,
    points: [u64; 3],
}

impl CoveragePoint {
    /// Whether a job can cover the point, and it is known when the job enters.
    pub fn is_reachable_at_entry(&self) -> bool {
        !self.is_impossible && !self.is_known_at_exit_only
    }

    /// Whether a job on this path, by its position in `PATHS`, can cover the point. A job that is lost in a reset
    /// does not show the accumulator. With one or two lanes, some mask rules coincide.
    pub fn is_reachable(&self, path: usize) -> bool {
        let is_lost = path % (PATHS.len() / 2) == JobEnd::Lost as usize;
        !(self.is_impossible || self.is_known_at_exit_only && is_lost)
    }
}

impl JobPoints {
    fn set(&mut self, point: usize) {
        self.points[point / 64] |= 1 << (point % 64);
    }

    /// Sets the points of exercised rules, of which the first has the number `first`.
    fn set_rules(&mut self, first: usize, rules: &[Rule]) {
        let exercised = rules.iter().enumerate().filter(|(_, (_, is_exercised))| *is_exercised);
        exercised.for_each(|(index, _)| self.set(first + index));
    }

    /// Calls `visit` with the number of each point.
    pub fn each(&self, mut visit: impl FnMut(usize)) {
        for (index, &word) in self.points.iter().enumerate() {
            let mut left = word;
            while left != 0 {
                visit(64 * index + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

impl CoverageModel {
    /// The points of a configuration, with its pipeline's shape and the layout of its jobs.
    pub fn new(config: Config, shape: &Shape, layout: Layout) -> Self {
        let points = JobKind::ALL.map(|kind| match config.kinds().contains(&kind) {
            true => points(kind, config, &layout),
            false => vec![],
        });
        Self { points: points.into(), capacity: shape.capacity(), shape: shape.clone(), config, layout }
    }

    /// The points that a job covers, as far as they are known when it enters.
    pub fn job_points(&self, kind: JobKind, words: &[u64]) -> JobPoints {
        let mut covered = JobPoints { kind, points: [0; 3] };
        let (rules, format) = (self.config.semantics.rules_in_full(), self.config.semantics.format);
        let mask = self.mask(kind, words);
        for (&field, &code) in self.layout.fields(kind).iter().zip(words) {
            // A masked lane is no operand; rule 7 has points for its value.
            if matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0) {
                continue;
            }
            if let Some(group) = group(kind, rules, field) {
                covered.set(CLASSES.len() * group + class(format, code));
            }
            if let (JobKind::Triangle, Field::Axis(axis)) = (kind, field) {
                covered.set(axes_begin() + 4 * axis + (code as usize & 3));
            }
        }
        let (first, rounded) = (rules_begin(kind, rules), Rounded(format));
        match kind {
            JobKind::Triangle => covered.set_rules(first, &triangle_rules(rounded, &self.layout, words)),
            JobKind::Quadbox => {
                let (rules, order) = box_rules(rounded, &self.layout, words);
                covered.set_rules(first, &rules);
                covered.set(first + rules.len() + order);
            }
            JobKind::Euclidean | JobKind::Angular => {
                covered.set_rules(first, &rules_at_entry(kind, format, &self.layout, words));
            }
        }
        covered
    }

    /// Adds the points that a beat covers when it leaves.
    pub fn add_exit_points(&self, covered: &mut JobPoints, found: AccumulatorState) {
        let first = rules_begin(covered.kind, self.config.semantics.rules_in_full()) + RULES_AT_ENTRY;
        covered.set_rules(first, &rules_at_exit(self.config.semantics.format, found));
    }

    fn mask(&self, kind: JobKind, words: &[u64]) -> u64 {
        let index = self.layout.fields(kind).iter().position(|field| *field == Field::Mask);
        index.and_then(|index| words.get(index)).copied().unwrap_or(u64::MAX)
    }
}

fn axes_begin() -> usize {
    CLASSES.len() * groups(JobKind::Triangle, Rules::Paper).len()
}

/// The number of an operation's first rule point, after the points of operands.
fn rules_begin(kind: JobKind, rules: Rules) -> usize {
    CLASSES.len() * groups(kind, rules).len() + if kind == JobKind::Triangle { 12 } else { 0 }
}

fn points(kind: JobKind, config: Config, layout: &Layout) -> Vec<CoveragePoint> {
    let (rules, format, lanes) =
        (config.semantics.rules_in_full(), config.semantics.format, config.semantics.lanes.count());
    let point = |name: &str| CoveragePoint {
        name: format!("{kind}: {name}"),
        is_known_at_exit_only: false,
        is_impossible: false,
    };
    let groups = groups(kind, rules).iter();
    let mut points: Vec<CoveragePoint> =
        groups.flat_map(|group| CLASSES.iter().map(move |class| point(&format!("{group} {class}")))).collect();
    match kind {
        JobKind::Triangle => {
            let axes = ["kx", "ky", "kz"].into_iter().flat_map(|axis| (0..4).map(move |value| (axis, value)));
            points.extend(axes.map(|(axis, value)| point(&format!("{axis} = {value}"))));
            points.extend(triangle_rules(Rounded(format), layout, &[]).map(|(name, _)| point(name)));
        }
        JobKind::Quadbox => {
            points.extend(box_rules(Rounded(format), layout, &[]).0.map(|(name, _)| point(name)));
            points.extend((0..PERMUTATIONS).map(|number| point(&format!("5: order {:?}", permutation(number)))));
        }
        JobKind::Euclidean | JobKind::Angular => {
            let lanes = if kind == JobKind::Angular { lanes / 2 } else { lanes };
            points.extend(rules_at_entry(kind, format, layout, &[]).map(|(name, _)| CoveragePoint {
                is_impossible: lanes <= 1 && name == "7: one lane is enabled"
                    || lanes <= 2 && name == "7: some lanes are enabled",
                ..point(name)
            }));
            let empty = AccumulatorState { sum: 0, after_others: true, after_loss: false };
            points.extend(
                rules_at_exit(format, empty)
                    .map(|(name, _)| CoveragePoint { is_known_at_exit_only: true, ..point(name) }),
            );
        }
    }
    points
}
