use super::operands::{CLASSES, class, group, groups};
use super::rules::{BeatRule, BoxRule, Onto, PERMUTATIONS, Rounded, TriangleRule, permutation};
use super::{End, WAYS};
use crate::verify::layout::{Field, Layout};
use raypath_float::Format;
use raypath_model::Shape;
use raypath_ops::{JobKind, Rules};
use raypath_rtl::Config;

/// All that jobs of a configuration can exercise.
#[derive(Debug, Clone)]
pub struct Atlas {
    /// The cells of each kind of job; of kinds that the configuration has no mode for, none.
    pub(super) cells: Vec<Vec<Cell>>,
    /// How many jobs fit inside.
    pub(super) capacity: usize,
    /// How the datapath is shaped.
    pub(super) shape: Shape,
    pub(super) kinds: &'static [JobKind],
    format: Format,
    rules: Rules,
    layout: Layout,
}

/// Something that a job can exercise.
#[derive(Debug, Clone)]
pub struct Cell {
    /// What it is called.
    pub name: String,
    is_known_at_exit_only: bool,
    is_impossible: bool,
}

/// What a job exercises: a set of its kind's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Features {
    /// The kind.
    pub kind: JobKind,
    cells: [u64; 3],
}

impl Cell {
    /// Whether a job can exercise it so that it is known when it enters.
    pub fn is_reachable_at_entry(&self) -> bool {
        !self.is_impossible && !self.is_known_at_exit_only
    }

    /// Whether a job can exercise it that goes this way, by its position in [`WAYS`]. One that is lost in a reset never
    /// shows what it found in the accumulator; where lanes are few, one is all, or more than one is.
    pub fn is_reachable(&self, way: usize) -> bool {
        let is_lost = way % (WAYS.len() / 2) == End::Lost as usize;
        !(self.is_impossible || self.is_known_at_exit_only && is_lost)
    }
}

impl Features {
    fn set(&mut self, cell: usize) {
        self.cells[cell / 64] |= 1 << (cell % 64);
    }

    /// Tells each cell.
    pub fn each(&self, mut tell: impl FnMut(usize)) {
        for (index, &word) in self.cells.iter().enumerate() {
            let mut left = word;
            while left != 0 {
                tell(64 * index + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

impl Atlas {
    /// That of a configuration, its datapath's shape, and its model's jobs.
    pub fn new(config: Config, shape: &Shape, layout: Layout) -> Self {
        let cells = JobKind::ALL.map(|kind| if config.kinds().contains(&kind) { cells(kind, config) } else { vec![] });
        Self {
            cells: cells.into(),
            capacity: shape.capacity(),
            shape: shape.clone(),
            kinds: config.kinds(),
            format: config.semantics.format,
            rules: config.semantics.rules,
            layout,
        }
    }

    /// What a job exercises, as far as it is known when it enters.
    pub fn features(&self, kind: JobKind, words: &[u64]) -> Features {
        let mut features = Features { kind, cells: [0; 3] };
        let mask = self.mask(kind, words);
        for (&field, &code) in self.layout.fields(kind).iter().zip(words) {
            // A lane that does not count is no operand; ruling 7 has cells for what it holds.
            if matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0) {
                continue;
            }
            if let Some(group) = group(kind, self.rules, field) {
                features.set(CLASSES.len() * group + class(self.format, code));
            }
            if let (JobKind::Triangle, Field::Axis(axis)) = (kind, field) {
                features.set(axes_begin() + 4 * axis + (code as usize & 3));
            }
        }
        let (first, rounded) = (rules_begin(kind, self.rules), Rounded(self.format));
        match kind {
            JobKind::Triangle => {
                TriangleRule::each(rounded, &self.layout, words, |rule| features.set(first + rule as usize));
            }
            JobKind::Quadbox => {
                let order = BoxRule::each(rounded, &self.layout, words, |rule| features.set(first + rule as usize));
                features.set(first + BoxRule::NAMES.len() + order);
            }
            JobKind::Euclidean | JobKind::Angular => {
                let set = |rule| features.set(first + rule as usize);
                BeatRule::each(kind, self.format, &self.layout, words, set);
            }
        }
        features
    }

    /// Adds what a beat exercises that leaves.
    pub fn at_exit(&self, features: &mut Features, onto: Onto) {
        let first = rules_begin(features.kind, self.rules);
        BeatRule::each_at_exit(self.format, onto, |rule| features.set(first + rule as usize));
    }

    fn mask(&self, kind: JobKind, words: &[u64]) -> u64 {
        let place = self.layout.fields(kind).iter().position(|field| *field == Field::Mask);
        place.and_then(|place| words.get(place)).copied().unwrap_or(u64::MAX)
    }
}

fn axes_begin() -> usize {
    CLASSES.len() * groups(JobKind::Triangle, Rules::Paper).len()
}

/// Where the cells of rules begin, behind those of operands.
fn rules_begin(kind: JobKind, rules: Rules) -> usize {
    CLASSES.len() * groups(kind, rules).len() + if kind == JobKind::Triangle { 12 } else { 0 }
}

fn cells(kind: JobKind, config: Config) -> Vec<Cell> {
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
        .map(|(index, name)| Cell {
            name: format!("{kind}: {name}"),
            is_known_at_exit_only: is_beat && index >= first_at_exit,
            is_impossible: is_beat && impossible.contains(&index),
        })
        .collect()
}
