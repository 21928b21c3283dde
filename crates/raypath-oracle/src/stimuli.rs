//! Random jobs, as words. Most are near the limits of rules and number ranges.

mod numbers;
mod scenes;

use crate::layout::{Field, Layout};
use numbers::{NumberClass, Numbers};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::{OperationId, WordModel};
use raypath_sim::random::CloneableRng;
use scenes::Scene;

/// An endless stream of jobs of a datapath, reproducible by seed.
#[derive(Debug, Clone)]
pub struct Stimuli {
    layout: Layout,
    format: Format,
    numbers: Numbers,
    rng: CloneableRng,
    /// The operations, each with the words of its last few jobs.
    operations: Vec<(OperationId, Vec<Vec<u64>>)>,
    /// The position of the last job's operation.
    last: usize,
}

const RECENT: usize = 8;

impl Stimuli {
    /// Jobs of a model's operations.
    pub fn new(model: &WordModel, seed: u64) -> Self {
        Self {
            layout: Layout::of(model),
            format: model.format(),
            numbers: Numbers::of(model.format()),
            rng: CloneableRng(ChaCha8Rng::seed_from_u64(seed)),
            operations: model.kinds().into_iter().map(|kind| (kind, Vec::new())).collect(),
            last: 0,
        }
    }

    /// Writes the next job to `words` and returns its operation. About half of the jobs have the operation of the job
    /// before, so that beats follow beats.
    pub fn next(&mut self, words: &mut Vec<u64>) -> OperationId {
        if self.rng.0.random_bool(0.6) {
            self.last = self.rng.0.random_range(0..self.operations.len());
        }
        let (kind, _) = self.operations[self.last];
        self.next_of(kind, words);
        kind
    }

    /// Writes the next job of this operation to `words`.
    pub fn next_of(&mut self, kind: OperationId, words: &mut Vec<u64>) {
        let Self { layout, numbers, rng: CloneableRng(rng), .. } = self;
        let fields = layout.fields(kind.name());
        let (has_mask, has_key) = (fields.contains(&Field::Mask), fields.contains(&Field::Key));
        words.clear();
        words.extend(if has_mask { beat(fields, numbers, rng) } else { scene(fields, numbers, rng) });
        let Some(index) = self.operations.iter().position(|(known, _)| *known == kind) else { return };
        if self.rng.0.random_bool(0.2) {
            self.recombine(index, words);
        }
        let recent = &mut self.operations[index].1;
        if recent.len() < RECENT {
            recent.push(words.clone());
        } else {
            recent[self.rng.0.random_range(0..RECENT)].clone_from(words);
        }
        if has_key && self.rng.0.random_bool(0.9) {
            sort_separators(self.format, self.layout.fields(kind.name()), words);
        }
    }

    /// Replaces some fields by those of an earlier job of the operation.
    fn recombine(&mut self, index: usize, words: &mut [u64]) {
        let recent = &self.operations[index].1;
        if recent.is_empty() {
            return;
        }
        let other = &recent[self.rng.0.random_range(0..recent.len())];
        let share = [0.05, 0.5, 0.95][self.rng.0.random_range(0..3)];
        for (word, other) in words.iter_mut().zip(other) {
            if self.rng.0.random_bool(share) {
                *word = *other;
            }
        }
    }
}

/// A job without lanes: mostly a ray with what it may hit.
fn scene(fields: &[Field], numbers: &Numbers, rng: &mut ChaCha8Rng) -> Vec<u64> {
    let scene = match rng.random_range(0..100) {
        0..45 => Some(Scene::lattice(rng)),
        45..65 => Some(Scene::typical(rng)),
        _ => None,
    };
    // A few numbers of some jobs are replaced by random ones.
    let replaced = if rng.random_bool(0.3) { 0.03 } else { 0.0 };
    let class = NumberClass::random(rng);
    let word = |&field: &Field| match (&scene, field) {
        (Some(scene), Field::Axis(_) | Field::Offset { .. }) if replaced == 0.0 => scene.word(field),
        (_, Field::Axis(_)) => rng.random_range(0..4),
        (_, Field::Offset { .. }) => [0, 255, rng.random_range(0..256)][rng.random_range(0..3)],
        (_, Field::Used) => [15, 15, rng.random_range(0..16)][rng.random_range(0..3)],
        (_, Field::Tag) => [0, u64::MAX, rng.random()][rng.random_range(0..3)],
        (Some(scene), field) if replaced == 0.0 || !rng.random_bool(replaced) => numbers.nearest(scene.number(field)),
        _ => numbers.draw(class, rng),
    };
    fields.iter().map(word).collect()
}

/// A beat. Masked lanes often hold numbers that would change the sum.
fn beat(fields: &[Field], numbers: &Numbers, rng: &mut ChaCha8Rng) -> Vec<u64> {
    let lanes = fields.iter().filter(|field| matches!(field, Field::Lane { of_candidate: true, .. })).count();
    let mask = mask(lanes, rng);
    let class = if rng.random_bool(0.4) { NumberClass::Lattice } else { NumberClass::random(rng) };
    let disturbed = if rng.random_bool(0.5) { 0.3 } else { 0.0 };
    let word = |&field: &Field| match field {
        Field::Mask => mask,
        Field::Reset => rng.random_bool(0.15).into(),
        Field::Accumulator => rng.random(),
        Field::Tag => [0, u64::MAX, rng.random()][rng.random_range(0..3)],
        Field::Lane { lane, .. } if mask >> lane & 1 == 0 && disturbed > 0.0 && rng.random_bool(disturbed) => {
            numbers.draw(NumberClass::Edges, rng)
        }
        _ => numbers.draw(class, rng),
    };
    fields.iter().map(word).collect()
}

/// Puts the separators of a key into ascending order, NaN last.
fn sort_separators(format: Format, fields: &[Field], words: &mut [u64]) {
    let is_separator = |index: &usize| matches!(fields[*index], Field::Separator(_));
    let places: Vec<usize> = (0..words.len()).filter(is_separator).collect();
    let mut sorted: Vec<u64> = places.iter().map(|&place| words[place]).collect();
    sorted.sort_by(|&a, &b| format.compare(a, b).unwrap_or_else(|| format.is_nan(a).cmp(&format.is_nan(b))));
    places.iter().zip(sorted).for_each(|(&place, word)| words[place] = word);
}

/// A mask of this many lanes: all, the first few as at a vector's end, random ones, one, or none.
fn mask(lanes: usize, rng: &mut ChaCha8Rng) -> u64 {
    let all = u64::MAX >> (64 - lanes.clamp(1, 64));
    match rng.random_range(0..20) {
        0..8 => all,
        8..12 => all >> rng.random_range(0..lanes.max(1)),
        12..16 => rng.random::<u64>() & all,
        16..18 => 1 << rng.random_range(0..lanes.max(1)),
        _ => 0,
    }
}
