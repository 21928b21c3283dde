//! The test cases of Berkeley TestFloat for binary32.
//!
//! The code is our own. It follows John R. Hauser's TestFloat 3e (`doc/TestFloat-general.html`, section 4, and the
//! tables of `source/genCases_f32.c`) in the exponents and fractions of its cases, in the order of patterns and random
//! numbers, and in the number of cases of a level. Two things differ. Random numbers come from ChaCha8 instead of C's
//! `rand`, with TestFloat's distribution, so that a seed gives the same cases on every machine. And the cases come in
//! independent blocks of [`BLOCK`], so that cores and machines can share them.
//!
//! A *pattern* is one of a set of signs and exponents with one of a set of fractions. A *weighted random* number has
//! one time in two a sign and exponent of the wider set, and else one from a window about 2, of any of several widths;
//! its fraction is three times in four a sum of two pattern fractions, else random bits.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};

/// TestFloat's two levels, which differ in the fractions of the patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Four fractions: the two smallest and the two largest.
    One,
    /// All 88 fractions that are one run of ones beside one run of zeros, or of which one bit differs from all others.
    Two,
}

/// The cases with two operands of a level: every pair of patterns, each preceded by cases in which one operand or both
/// are weighted random.
#[derive(Debug, Clone)]
pub struct Pairs {
    level: Level,
    patterns: Vec<u32>,
    random: Weighted,
    seed: u64,
    round: u32,
    stride: u64,
}

/// The number of cases in a block; the last block may have fewer.
pub const BLOCK: u64 = 4096;

const SIGN: u32 = 1 << 31;
const FRACTION: u32 = (1 << 23) - 1;
const BIAS: i32 = 127;

impl Pairs {
    /// The cases of a level. `seed` and `round` select the random numbers; the patterns are always the same.
    pub fn new(level: Level, seed: u64, round: u32) -> Self {
        let patterns = patterns(&operand_exponents(), level);
        Self { level, patterns, random: Weighted::new(), seed, round, stride: 1 }
    }

    /// Every `stride`-th case from the first on; `stride` is at least 1. An odd stride keeps the proportion of patterns
    /// and random numbers.
    pub fn every(self, stride: u64) -> Self {
        Self { stride: stride.max(1), ..self }
    }

    /// The number of cases.
    pub fn count(&self) -> u64 {
        ((self.patterns.len() as u64).pow(2) * self.turns()).div_ceil(self.stride)
    }

    /// The cases of the block with this number, from 0; no cases after the last block.
    pub fn block(&self, block: u64) -> impl Iterator<Item = (u32, u32)> + '_ {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(u64::from(self.round) << 32 | u64::from(self.level == Level::Two) << 31 | block);
        let first = block * BLOCK;
        (first..self.count().min(first + BLOCK)).map(move |index| self.case(index * self.stride, &mut random))
    }

    /// The number of cases for each pair of patterns.
    fn turns(&self) -> u64 {
        match self.level {
            Level::One => 6,
            Level::Two => 2,
        }
    }

    fn case(&self, case: u64, random: &mut ChaCha8Rng) -> (u32, u32) {
        let (pair, turn) = (case / self.turns(), case % self.turns());
        let count = self.patterns.len() as u64;
        let [a, b] = [pair / count, pair % count].map(|index| self.patterns[index as usize]);
        let mut any = || self.random.draw(random);
        match (self.level, turn) {
            (Level::One, 1) => (a, any()),
            (Level::One, 3) => (any(), b),
            (Level::One, 5) | (Level::Two, 1) => (a, b),
            _ => (any(), any()),
        }
    }
}

/// A generator of weighted random numbers.
#[derive(Debug, Clone)]
struct Weighted {
    exponents: Vec<u32>,
    fractions: Vec<u32>,
}

impl Weighted {
    fn new() -> Self {
        Self { exponents: result_exponents(), fractions: fractions(Level::Two) }
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> u32 {
        let kind = random.random_range(0..8);
        let upper =
            if kind < 4 { self.exponents[random.random_range(0..self.exponents.len())] } else { window(random) };
        let fraction = match kind % 4 {
            3 => random.next_u32(),
            _ => {
                let mut one = || self.fractions[random.random_range(0..self.fractions.len())];
                one() + one()
            }
        };
        upper | fraction & FRACTION
    }
}

/// Any sign, with an exponent field from a window around 128, the field of 2. The window has 256 values in two cases of
/// seven, and 128, 64, 32, 16 or 8 values in one each.
fn window(random: &mut ChaCha8Rng) -> u32 {
    let width = [256, 256, 128, 64, 32, 16, 8][random.random_range(0..7)];
    let field = 128 - width / 2 + random.random_range(0..width);
    random.next_u32() & SIGN | field << 23
}

fn patterns(signs_and_exponents: &[u32], level: Level) -> Vec<u32> {
    let fractions = fractions(level);
    signs_and_exponents.iter().flat_map(|&upper| fractions.iter().map(move |fraction| upper | fraction)).collect()
}

/// Signs and exponents of operands. As in TestFloat, the largest finite exponent is 127 for positive numbers and 126
/// for negative ones.
fn operand_exponents() -> Vec<u32> {
    let with = |largest| [-127, -126, -24, -2, -1, 0, 1, 2, 24, largest, 128];
    let upper = |exponent: i32| ((exponent + BIAS) as u32) << 23;
    with(127).map(upper).into_iter().chain(with(126).map(|exponent| SIGN | upper(exponent))).collect()
}

/// Signs and exponents of the results of conversions and sums; they include the limits of integers.
fn result_exponents() -> Vec<u32> {
    let small = [-127, -126, -125, -24].into_iter().chain(-4..=4);
    let large = [24].into_iter().chain(29..=32).chain(61..=64).chain(126..=128);
    let positive: Vec<u32> = small.chain(large).map(|exponent| ((exponent + BIAS) as u32) << 23).collect();
    positive.iter().copied().chain(positive.iter().map(|upper| SIGN | upper)).collect()
}

/// The fractions of a level's patterns.
fn fractions(level: Level) -> Vec<u32> {
    if level == Level::One {
        return vec![0, 1, FRACTION, FRACTION - 1];
    }
    let one_bit = (0..23).map(|bit| 1 << bit);
    let ones_above = (1..22).rev().map(|bit| FRACTION << bit & FRACTION);
    let one_bit_missing = (1..23).map(|bit| FRACTION ^ 1 << bit);
    let ones_below = (2..22).rev().map(|count| (1 << count) - 1);
    let ends = [0].into_iter().chain(one_bit).chain(ones_above).chain([FRACTION]);
    ends.chain(one_bit_missing).chain(ones_below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn all(level: Level, seed: u64) -> Vec<(u32, u32)> {
        let pairs = Pairs::new(level, seed, 0);
        (0..pairs.count().div_ceil(BLOCK)).flat_map(|block| pairs.block(block).collect::<Vec<_>>()).collect()
    }

    /// The counts that TestFloat states.
    #[test]
    fn the_number_of_patterns_equals_that_of_testfloat() {
        assert_eq!((operand_exponents().len(), result_exponents().len()), (22, 50));
        assert_eq!((fractions(Level::One).len(), fractions(Level::Two).len()), (4, 88));
        assert_eq!((all(Level::One, 1).len(), all(Level::Two, 1).len()), (46_464, 7_496_192));
        assert_eq!((Pairs::new(Level::One, 1, 0).count(), Pairs::new(Level::Two, 1, 0).count()), (46_464, 7_496_192));
        assert_eq!(Pairs::new(Level::Two, 1, 0).block(7_496_192 / BLOCK + 1).count(), 0);
    }

    #[test]
    fn every_pattern_meets_every_other() {
        let pairs: HashSet<(u32, u32)> = all(Level::Two, 1).into_iter().skip(1).step_by(2).collect();
        assert_eq!(pairs.len(), (22 * 88) * (22 * 88));
    }
}
