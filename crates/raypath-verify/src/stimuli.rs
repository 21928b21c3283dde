//! Random jobs for campaigns, as words. Most are near the limits of rules and number ranges.

mod numbers;
mod scenes;

use crate::layout::{Field, Layout};
use numbers::{NumberClass, Numbers};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::JobKind;
use raypath_rtl::Config;
use raypath_sim::random::CloneableRng;
use scenes::Scene;

/// An endless stream of jobs for a configuration, reproducible by seed.
#[derive(Debug, Clone)]
pub struct Stimuli<'l> {
    layout: &'l Layout,
    kinds: &'static [JobKind],
    lanes: usize,
    numbers: Numbers,
    rng: CloneableRng,
    last: JobKind,
    /// The words of the last few jobs of each operation.
    recent: [Vec<Vec<u64>>; JobKind::ALL.len()],
}

const RECENT: usize = 8;

impl<'l> Stimuli<'l> {
    /// Jobs for a configuration, with the layout of its jobs.
    pub fn new(layout: &'l Layout, config: Config, seed: u64) -> Self {
        Self {
            layout,
            kinds: config.kinds(),
            lanes: config.semantics.lanes.count(),
            numbers: Numbers::of(config.semantics.format),
            rng: CloneableRng(ChaCha8Rng::seed_from_u64(seed)),
            last: JobKind::Triangle,
            recent: Default::default(),
        }
    }

    /// Writes the next job to `words` and returns its operation. About half of the jobs have the operation of the job
    /// before, so that beats follow beats.
    pub fn next(&mut self, words: &mut Vec<u64>) -> JobKind {
        if self.rng.0.random_bool(0.6) {
            self.last = self.kinds[self.rng.0.random_range(0..self.kinds.len())];
        }
        let kind = self.last;
        self.next_of(kind, words);
        kind
    }

    /// Writes the next job of this operation to `words`.
    pub fn next_of(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        match kind {
            JobKind::Triangle | JobKind::Quadbox => self.ray(kind, words),
            JobKind::Euclidean | JobKind::Angular => self.beat(kind, words),
        }
        if self.rng.0.random_bool(0.2) {
            self.recombine(kind, words);
        }
        let recent = &mut self.recent[kind as usize];
        if recent.len() < RECENT {
            recent.push(words.clone());
        } else {
            recent[self.rng.0.random_range(0..RECENT)].clone_from(words);
        }
    }

    /// Writes a ray with boxes or a triangle.
    fn ray(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        let (layout, rng, numbers) = (self.layout, &mut self.rng.0, &self.numbers);
        let scene = match rng.random_range(0..100) {
            0..45 => Some(Scene::lattice(rng)),
            45..65 => Some(Scene::typical(rng)),
            _ => None,
        };
        // A few numbers of some jobs are replaced by random ones.
        let replaced = if rng.random_bool(0.3) { 0.03 } else { 0.0 };
        let class = NumberClass::random(rng);
        words.clear();
        words.extend(layout.fields(kind).iter().map(|&field| match (&scene, field) {
            (Some(scene), Field::Axis(axis)) if replaced == 0.0 => scene.axes[axis],
            (_, Field::Axis(_)) => rng.random_range(0..4),
            (Some(scene), field) if replaced == 0.0 || !rng.random_bool(replaced) => {
                numbers.nearest(scene.number(field))
            }
            _ => numbers.draw(class, rng),
        }));
    }

    /// Writes a beat. Masked lanes often hold numbers that would change the sum.
    fn beat(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        let lanes = if kind == JobKind::Angular { self.lanes / 2 } else { self.lanes };
        let (layout, rng, numbers) = (self.layout, &mut self.rng.0, &self.numbers);
        let mask = mask(lanes, rng);
        let class = if rng.random_bool(0.4) { NumberClass::Lattice } else { NumberClass::random(rng) };
        let disturbed = if rng.random_bool(0.5) { 0.3 } else { 0.0 };
        words.clear();
        words.extend(layout.fields(kind).iter().map(|&field| match field {
            Field::Mask => mask,
            Field::Reset => rng.random_bool(0.15).into(),
            Field::Lane { lane, .. } if mask >> lane & 1 == 0 && disturbed > 0.0 && rng.random_bool(disturbed) => {
                numbers.draw(NumberClass::Edges, rng)
            }
            _ => numbers.draw(class, rng),
        }));
    }

    /// Replaces some fields by those of an earlier job of the operation.
    fn recombine(&mut self, kind: JobKind, words: &mut [u64]) {
        let recent = &self.recent[kind as usize];
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

/// A seed of an independent random stream for each number: the finalizer of SplitMix64 (Steele, Lea and Flood, OOPSLA
/// 2014).
pub(crate) fn splitmix64(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
