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

    /// The level of the cases.
    pub fn level(&self) -> Level {
        self.level
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

/// The cases with one operand of a level: the patterns of the wider set of exponents, each preceded by two weighted
/// random numbers at level one and by one at level two.
pub fn singles(level: Level, seed: u64) -> Vec<u32> {
    let (weighted, mut random) = (Weighted::new(), ChaCha8Rng::seed_from_u64(seed));
    let before = match level {
        Level::One => 2,
        Level::Two => 1,
    };
    let mut cases = Vec::new();
    for pattern in patterns(&result_exponents(), level) {
        cases.extend((0..before).map(|_| weighted.draw(&mut random)));
        cases.push(pattern);
    }
    cases
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
        assert_eq!((singles(Level::One, 1).len(), singles(Level::Two, 1).len()), (600, 8_800));
        assert_eq!((all(Level::One, 1).len(), all(Level::Two, 1).len()), (46_464, 7_496_192));
        assert_eq!((Pairs::new(Level::One, 1, 0).count(), Pairs::new(Level::Two, 1, 0).count()), (46_464, 7_496_192));
        assert_eq!(Pairs::new(Level::Two, 1, 0).block(7_496_192 / BLOCK + 1).count(), 0);
    }

    #[test]
    fn every_pattern_meets_every_other_and_none_is_there_twice() {
        let patterns = patterns(&operand_exponents(), Level::Two);
        assert_eq!(patterns.iter().collect::<HashSet<_>>().len(), 22 * 88);
        let pairs: HashSet<(u32, u32)> = all(Level::Two, 1).into_iter().skip(1).step_by(2).collect();
        assert_eq!(pairs.len(), (22 * 88) * (22 * 88));
        assert!(patterns.iter().all(|&a| pairs.contains(&(a, patterns[7])) && pairs.contains(&(patterns[7], a))));
    }

    #[test]
    fn a_stride_takes_patterns_and_random_numbers_alike() {
        let some = Pairs::new(Level::Two, 1, 0).every(5);
        let cases: HashSet<(u32, u32)> =
            (0..some.count().div_ceil(BLOCK)).flat_map(|block| some.block(block).collect::<Vec<_>>()).collect();
        let patterns: HashSet<u32> = patterns(&operand_exponents(), Level::Two).into_iter().collect();
        let of_patterns: Vec<_> = cases.iter().filter(|(a, b)| patterns.contains(a) && patterns.contains(b)).collect();
        assert_eq!(some.count(), 1_499_239);
        assert!(of_patterns.len() >= 749_619 && of_patterns.len() < 800_000, "{}", of_patterns.len());
        for place in [0, 1] {
            let met: HashSet<u32> = of_patterns.iter().map(|(a, b)| [*a, *b][place]).collect();
            assert_eq!(met.len(), 22 * 88);
        }
    }

    #[test]
    fn edges_are_there() {
        let cases: HashSet<(u32, u32)> = all(Level::Two, 1).into_iter().collect();
        let edges = [
            ("zeros of both signs", 0x0000_0000, 0x8000_0000),
            ("the least subnormal numbers", 0x0000_0001, 0x8000_0001),
            ("the largest subnormal and the least normal number", 0x007f_ffff, 0x0080_0000),
            ("the largest number twice", 0x7f7f_ffff, 0x7f7f_ffff),
            ("infinities of both signs", 0x7f80_0000, 0xff80_0000),
            ("an infinity and zero", 0x7f80_0000, 0x0000_0000),
            ("a quiet NaN", 0x7fc0_0000, 0x3f80_0000),
            ("a signalling NaN", 0x7f80_0001, 0x3f80_0000),
            ("a tie", 0x3f80_0001, 0x3380_0000),
            ("cancellation to the last place", 0x3f80_0000, 0xbf7f_ffff),
        ];
        for (name, a, b) in edges {
            assert!(cases.contains(&(a, b)), "{name}: {a:#x}, {b:#x}");
        }
    }

    #[test]
    fn a_seed_is_a_reproduction() {
        assert_eq!(all(Level::Two, 5), all(Level::Two, 5));
        assert_eq!(singles(Level::Two, 5), singles(Level::Two, 5));
        let first = |seed, round| Pairs::new(Level::Two, seed, round).block(0).collect::<Vec<_>>();
        let (here, other_seed, other_round) = (first(5, 0), first(6, 0), first(5, 1));
        let alike = |other: &[(u32, u32)]| here.iter().zip(other).filter(|(x, y)| x == y).count();
        // The patterns, and next to none of the random numbers.
        assert!((2048..2060).contains(&alike(&other_seed)) && (2048..2060).contains(&alike(&other_round)));
        assert_ne!(here.first().copied(), Pairs::new(Level::Two, 5, 0).block(1).next());
    }

    /// Every exponent occurs, most often those near the middle; a quarter of the fractions are random bits.
    #[test]
    fn random_numbers_are_weighted() {
        let (weighted, mut random) = (Weighted::new(), ChaCha8Rng::seed_from_u64(1));
        let draws: Vec<u32> = (0..1_000_000).map(|_| weighted.draw(&mut random)).collect();
        let share = |wanted: &dyn Fn(u32) -> bool| draws.iter().filter(|&&draw| wanted(draw)).count() as f64 / 1e6;
        let field = |draw: u32| draw >> 23 & 0xff;
        assert!((0..256).all(|value| draws.iter().any(|&draw| field(draw) == value)));
        // Half of the numbers are from 50 signs and exponents; 8 of their 25 exponents are in the narrowest window. Of
        // the others, 8 of n are in it for a window of n.
        let windows = (2.0 / 256.0 + 1.0 / 128.0 + 1.0 / 64.0 + 1.0 / 32.0 + 1.0 / 16.0 + 1.0 / 8.0) * 8.0 / 7.0;
        let expected = 0.5 * 8.0 / 25.0 + 0.5 * windows;
        assert!((share(&|draw| (124..132).contains(&field(draw))) - expected).abs() < 0.003);
        assert!((share(&|draw| draw & SIGN != 0) - 0.5).abs() < 0.003);
        let sums: HashSet<u32> = {
            let fractions = fractions(Level::Two);
            fractions.iter().flat_map(|a| fractions.iter().map(move |b| (a + b) & FRACTION)).collect()
        };
        assert!((share(&|draw| !sums.contains(&(draw & FRACTION))) - 0.25).abs() < 0.003);
    }
}
