//! Jobs for campaigns, as words: few plain ones, many at the edges of the rules and of the numbers.

mod geometry;
mod numbers;

use crate::verify::layout::{Field, Layout};
use geometry::Geometry;
use numbers::{Numbers, Sort};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_ops::JobKind;
use raypath_rtl::Config;

/// An endless stream of jobs for a configuration, reproducible by seed.
#[derive(Debug, Clone)]
pub struct Stimuli<'l> {
    layout: &'l Layout,
    kinds: &'static [JobKind],
    lanes: usize,
    numbers: Numbers,
    rng: ChaCha8Rng,
    last: JobKind,
    /// Words of the last few jobs of each kind.
    recent: [Vec<Vec<u64>>; JobKind::ALL.len()],
}

const RECENT: usize = 8;

impl<'l> Stimuli<'l> {
    /// Jobs for a configuration, with the layout of its model's jobs.
    pub fn new(layout: &'l Layout, config: Config, seed: u64) -> Self {
        Self {
            layout,
            kinds: config.kinds(),
            lanes: config.semantics.lanes.count(),
            numbers: Numbers::of(config.semantics.format),
            rng: ChaCha8Rng::seed_from_u64(seed),
            last: JobKind::Triangle,
            recent: Default::default(),
        }
    }

    /// The next job: its kind, and its words in place of what `words` held. Half of the time it is of the last one's
    /// kind, so that beats follow beats.
    pub fn next(&mut self, words: &mut Vec<u64>) -> JobKind {
        if self.rng.random_bool(0.6) {
            self.last = self.kinds[self.rng.random_range(0..self.kinds.len())];
        }
        let kind = self.last;
        self.next_of(kind, words);
        kind
    }

    /// The next job of this kind.
    pub fn next_of(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        match kind {
            JobKind::Triangle | JobKind::Quadbox => self.ray(kind, words),
            JobKind::Euclidean | JobKind::Angular => self.beat(kind, words),
        }
        if self.rng.random_bool(0.2) {
            self.recombine(kind, words);
        }
        let recent = &mut self.recent[kind as usize];
        if recent.len() < RECENT {
            recent.push(words.clone());
        } else {
            recent[self.rng.random_range(0..RECENT)].clone_from(words);
        }
    }

    /// A ray and what it meets.
    fn ray(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        let (layout, rng, numbers) = (self.layout, &mut self.rng, &self.numbers);
        let geometry = match rng.random_range(0..100) {
            0..45 => Some(Geometry::lattice(rng)),
            45..65 => Some(Geometry::scene(rng)),
            _ => None,
        };
        // Few of a lattice's numbers are others.
        let strays = if rng.random_bool(0.3) { 0.03 } else { 0.0 };
        let sort = Sort::random(rng);
        words.clear();
        words.extend(layout.fields(kind).iter().map(|&field| match (&geometry, field) {
            (Some(geometry), Field::Axis(axis)) if strays == 0.0 => geometry.axes[axis],
            (_, Field::Axis(_)) => rng.random_range(0..4),
            (Some(geometry), field) if strays == 0.0 || !rng.random_bool(strays) => {
                numbers.nearest(geometry.number(field))
            }
            _ => numbers.draw(sort, rng),
        }));
    }

    /// A beat. Lanes that do not count often hold what would spoil a sum.
    fn beat(&mut self, kind: JobKind, words: &mut Vec<u64>) {
        let lanes = if kind == JobKind::Angular { self.lanes / 2 } else { self.lanes };
        let (layout, rng, numbers) = (self.layout, &mut self.rng, &self.numbers);
        let mask = mask(lanes, rng);
        let sort = if rng.random_bool(0.4) { Sort::Lattice } else { Sort::random(rng) };
        let spoils = if rng.random_bool(0.5) { 0.3 } else { 0.0 };
        words.clear();
        words.extend(layout.fields(kind).iter().map(|&field| match field {
            Field::Mask => mask,
            Field::Reset => rng.random_bool(0.15).into(),
            Field::Lane { lane, .. } if mask >> lane & 1 == 0 && spoils > 0.0 && rng.random_bool(spoils) => {
                numbers.draw(Sort::Edges, rng)
            }
            _ => numbers.draw(sort, rng),
        }));
    }

    /// Some fields of an earlier job of the kind.
    fn recombine(&mut self, kind: JobKind, words: &mut [u64]) {
        let recent = &self.recent[kind as usize];
        if recent.is_empty() {
            return;
        }
        let other = &recent[self.rng.random_range(0..recent.len())];
        let share = [0.05, 0.5, 0.95][self.rng.random_range(0..3)];
        for (word, other) in words.iter_mut().zip(other) {
            if self.rng.random_bool(share) {
                *word = *other;
            }
        }
    }
}

/// Which of so many lanes count: all, the first few as at a vector's end, any, one, or none.
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
