//! The coverage points of a datapath, and which of them a job covers.

use super::operands::{CLASSES, class, operand};
use super::rules::{AccumulatorState, Job, Rule, numbered, rules_at_entry, rules_at_exit};
use crate::layout::{Field, Layout};
use raypath_model::{OperationId, Shape, WordModel};
use raypath_rtl::Semantics;

/// The coverage points of a datapath.
#[derive(Debug, Clone)]
pub struct CoverageModel {
    /// The operations, in the order of their opcodes.
    pub(super) operations: Vec<CoveredOperation>,
    /// The number of jobs that fit into the pipeline.
    pub(super) capacity: usize,
    /// The pipeline's shape.
    pub(super) shape: Shape,
    semantics: Semantics,
    layout: Layout,
}

/// The coverage points of an operation.
#[derive(Debug, Clone)]
pub(super) struct CoveredOperation {
    pub kind: OperationId,
    pub points: Vec<CoveragePoint>,
    /// For each field of a job, the first point of its operand's classes.
    classes: Vec<Option<usize>>,
    /// The first point of the axes, of the rules at entry, and of those at exit.
    axes: usize,
    at_entry: usize,
    at_exit: usize,
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
    /// The position of the job's operation, in the order of the opcodes.
    pub operation: usize,
    /// The accumulator that the job names.
    pub accumulator: usize,
    points: [u64; 5],
}

impl CoveragePoint {
    /// Whether a job can cover the point, and it is known when the job enters.
    pub fn is_reachable_at_entry(&self) -> bool {
        !self.is_impossible && !self.is_known_at_exit_only
    }

    /// Whether a job on this path, by its position in `PATHS`, can cover the point. A job that is lost in a reset
    /// does not show what is known at the exit.
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
        let exercised = rules.iter().enumerate().filter(|(_, rule)| rule.is_exercised);
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
    /// The points of a datapath, with its pipeline's shape.
    pub fn new(semantics: Semantics, shape: &Shape, model: &WordModel) -> Self {
        let layout = Layout::of(model);
        let operations = model.kinds().into_iter().map(|kind| CoveredOperation::new(kind, semantics, &layout));
        Self { operations: operations.collect(), capacity: shape.capacity(), shape: shape.clone(), semantics, layout }
    }

    /// The points that a job covers, as far as they are known when it enters. A job of an unknown operation covers
    /// none.
    pub fn job_points(&self, kind: OperationId, words: &[u64]) -> JobPoints {
        let position = self.operations.iter().position(|operation| operation.kind == kind);
        let mut covered = JobPoints { operation: position.unwrap_or(0), accumulator: 0, points: [0; 5] };
        let Some(operation) = position.map(|position| &self.operations[position]) else { return covered };
        let fields = self.layout.fields(kind.name());
        let job = Job { name: kind.name(), semantics: self.semantics, fields, words };
        let mask = job.word(Field::Mask).unwrap_or(u64::MAX);
        covered.accumulator = job.word(Field::Accumulator).unwrap_or(0) as usize;
        for ((&field, &code), classes) in fields.iter().zip(words).zip(&operation.classes) {
            // A masked lane is no operand; rule 7 has points for its value.
            if matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0) {
                continue;
            }
            if let Some(first) = classes {
                covered.set(first + class(self.semantics.format, code));
            }
            if let ("triangle", Field::Axis(axis)) = (kind.name(), field) {
                covered.set(operation.axes + 4 * axis + (code as usize & 3));
            }
        }
        let (rules, order) = rules_at_entry(&job);
        covered.set_rules(operation.at_entry, &rules);
        order.into_iter().for_each(|place| covered.set(operation.at_entry + rules.len() + place));
        covered
    }

    /// Adds the points that a job covers when it leaves: those of the accumulator that it found, and of its exceptions.
    pub fn add_exit_points(&self, covered: &mut JobPoints, found: AccumulatorState, exceptions: Option<u64>) {
        let operation = &self.operations[covered.operation];
        let rules = rules_at_exit(operation.kind.name(), self.semantics, found, exceptions);
        covered.set_rules(operation.at_exit, &rules);
    }
}

impl CoverageModel {
    /// Whether outcomes show the exceptions of their jobs.
    pub(super) fn has_exceptions(&self) -> bool {
        self.semantics.features.exception_flags
    }
}

impl CoveredOperation {
    fn new(kind: OperationId, semantics: Semantics, layout: &Layout) -> Self {
        let fields = layout.fields(kind.name());
        let point = |name: &str, is_known_at_exit_only| CoveragePoint {
            name: format!("{kind}: {name}"),
            is_known_at_exit_only,
            is_impossible: false,
        };
        let (mut points, mut operands) = (Vec::new(), Vec::new());
        let mut classes = Vec::new();
        for &field in fields {
            classes.push(operand(kind.name(), semantics, field).map(|name| {
                let known = operands.iter().position(|known| *known == name);
                let index = known.unwrap_or_else(|| {
                    operands.push(name);
                    points.extend(CLASSES.iter().map(|class| point(&format!("{name} {class}"), false)));
                    operands.len() - 1
                });
                CLASSES.len() * index
            }));
        }
        let axes = points.len();
        if kind.name() == "triangle" {
            let values = ["kx", "ky", "kz"].into_iter().flat_map(|axis| (0..4).map(move |value| (axis, value)));
            points.extend(values.map(|(axis, value)| point(&format!("{axis} = {value}"), false)));
        }
        let at_entry = points.len();
        let words = vec![0; fields.len()];
        let job = Job { name: kind.name(), semantics, fields, words: &words };
        points.extend(
            rules_at_entry(&job)
                .0
                .iter()
                .map(|rule| CoveragePoint { is_impossible: rule.is_impossible, ..point(&rule.name, false) }),
        );
        points.extend(numbered(kind.name(), semantics).iter().map(|name| point(name, false)));
        let at_exit = points.len();
        let exceptions = semantics.features.exception_flags.then_some(0);
        let rules = rules_at_exit(kind.name(), semantics, AccumulatorState::EMPTY, exceptions);
        points.extend(
            rules.iter().map(|rule| CoveragePoint { is_impossible: rule.is_impossible, ..point(&rule.name, true) }),
        );
        Self { kind, points, classes, axes, at_entry, at_exit }
    }
}
