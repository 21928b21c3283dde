//! The coverage points of a configuration, and which of them a job covers.

use super::operands::{CLASSES, class, group, groups};
use super::paths::{JobEnd, PATHS};
use super::rules::{AccumulatorState, BeatRule, BoxRule, PERMUTATIONS, Rounded, TriangleRule, permutation};
use crate::layout::{Field, Layout};
use raypath_float::Format;
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
    pub(super) kinds: &'static [JobKind],
    format: Format,
    rules: Rules,
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
        let points =
            JobKind::ALL.map(|kind| if config.kinds().contains(&kind) { points(kind, config) } else { vec![] });
        Self {
            points: points.into(),
            capacity: shape.capacity(),
            shape: shape.clone(),
            kinds: config.kinds(),
            format: config.semantics.format,
            rules: config.semantics.rules,
            layout,
        }
    }

    /// The points that a job covers, as far as they are known when it enters.
    pub fn job_points(&self, kind: JobKind, words: &[u64]) -> JobPoints {
        let mut covered = JobPoints { kind, points: [0; 3] };
        let mask = self.mask(kind, words);
        for (&field, &code) in self.layout.fields(kind).iter().zip(words) {
            // A masked lane is no operand; rule 7 has points for its value.
            if matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0) {
                continue;
            }
            if let Some(group) = group(kind, self.rules, field) {
                covered.set(CLASSES.len() * group + class(self.format, code));
            }
            if let (JobKind::Triangle, Field::Axis(axis)) = (kind, field) {
                covered.set(axes_begin() + 4 * axis + (code as usize & 3));
            }
        }
        let (first, rounded) = (rules_begin(kind, self.rules), Rounded(self.format));
        match kind {
            JobKind::Triangle => {
                TriangleRule::each(rounded, &self.layout, words, |rule| covered.set(first + rule as usize));
            }
            JobKind::Quadbox => {
                let order = BoxRule::each(rounded, &self.layout, words, |rule| covered.set(first + rule as usize));
                covered.set(first + BoxRule::NAMES.len() + order);
            }
            JobKind::Euclidean | JobKind::Angular => {
                let set = |rule| covered.set(first + rule as usize);
                BeatRule::each(kind, self.format, &self.layout, words, set);
            }
        }
        covered
    }

    /// Adds the points that a beat covers when it leaves.
    pub fn add_exit_points(&self, covered: &mut JobPoints, found: AccumulatorState) {
        let first = rules_begin(covered.kind, self.rules);
        BeatRule::each_at_exit(self.format, found, |rule| covered.set(first + rule as usize));
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

fn points(kind: JobKind, config: Config) -> Vec<CoveragePoint> {
    let rules = config.semantics.rules;
    let groups = groups(kind, rules).iter();
    let mut names: Vec<String> =
        groups.flat_map(|group| CLASSES.iter().map(move |class| format!("{group} {class}"))).collect();
    if kind == JobKind::Triangle {
        names.extend(["kx", "ky", "kz"].iter().flat_map(|axis| (0..4).map(move |value| format!("{axis} = {value}"))));
    }
    let of_rules = match kind {
        JobKind::Triangle => TriangleRule::NAMES,
        JobKind::Quadbox => BoxRule::NAMES,
        JobKind::Euclidean | JobKind::Angular => BeatRule::NAMES,
    };
    let first_rule = names.len();
    names.extend(of_rules.iter().map(ToString::to_string));
    if kind == JobKind::Quadbox {
        names.extend((0..PERMUTATIONS).map(|number| format!("5: order {:?}", permutation(number))));
    }
    let is_beat = matches!(kind, JobKind::Euclidean | JobKind::Angular);
    let lanes =
        if kind == JobKind::Angular { config.semantics.lanes.count() / 2 } else { config.semantics.lanes.count() };
    let too_few = [(BeatRule::MaskOne, 1), (BeatRule::MaskSome, 2)].into_iter().filter(|(_, most)| lanes <= *most);
    let impossible: Vec<usize> = too_few.map(|(rule, _)| first_rule + rule as usize).collect();
    let first_at_exit = first_rule + BeatRule::FIRST_AT_EXIT as usize;
    let named = names.into_iter().enumerate();
    named
        .map(|(index, name)| CoveragePoint {
            name: format!("{kind}: {name}"),
            is_known_at_exit_only: is_beat && index >= first_at_exit,
            is_impossible: is_beat && impossible.contains(&index),
        })
        .collect()
}
