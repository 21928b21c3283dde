//! binary32 against the host's `f32`.

use crate::{bench, converter};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_float::{Format, decode, encode};
use raypath_verify::bench::{Answer, Ports};
use std::cmp::Ordering;

const CASES: u64 = 6_000_000;
const FRACTION: u32 = 0x007f_ffff;

#[test]
fn operands_that_make_sums_hard() {
    let census = check(1, |random| {
        let a = number(random);
        let exponent = a >> 23 & 0xff;
        let distance = below(random, 28);
        let near = exponent.saturating_sub(distance) << 23 | random.next_u32() & 0x8000_0000;
        let b = match below(random, 4) {
            // Cancellation down to the last places.
            0 => (a ^ 0x8000_0000).wrapping_add(below(random, 9)).wrapping_sub(4),
            1 => near | (a & FRACTION).wrapping_add(below(random, 9)).wrapping_sub(4) & FRACTION,
            _ => near | fraction(random),
        };
        if below(random, 2) == 0 { (a, b) } else { (b, a) }
    });
    census.expect(|seen| seen.sums);
}

#[test]
fn operands_that_make_products_hard() {
    let census = check(2, |random| {
        let a = number(random);
        let exponent = a >> 23 & 0xff;
        if below(random, 16) == 0 {
            return (a, special(random));
        }
        let target = match below(random, 4) {
            // The product's biased exponent: from total underflow to the first normal numbers, about the largest, any.
            0 | 1 => below(random, 30) as i32 - 27,
            2 => below(random, 6) as i32 + 251,
            _ => below(random, 256) as i32,
        };
        let needed = (target + 127 - exponent as i32).clamp(0, 254) as u32;
        (a, needed << 23 | fraction(random) | random.next_u32() & 0x8000_0000)
    });
    census.expect(|seen| seen.products);
}

#[test]
fn operands_that_make_comparisons_hard() {
    let census = check(3, |random| {
        let a = if below(random, 2) == 0 { random.next_u32() } else { number(random) };
        let b = match below(random, 8) {
            0 | 1 => a,
            2 => a ^ 0x8000_0000,
            3 | 4 => a.wrapping_add(below(random, 5)).wrapping_sub(2),
            5 => a ^ 1 << below(random, 32),
            6 => number(random),
            _ => random.next_u32(),
        };
        (a, b)
    });
    let relations = census.relations;
    let Relations { less, equal, greater, unordered } = relations;
    assert!(less.min(equal).min(greater).min(unordered) >= cases(CASES) / 100, "{relations:?}");
}

/// Words with the same meaning as canonical ones: zeros and infinities with any bits below the class, NaNs with any sign and payload.
#[test]
fn recoded_words_that_are_not_canonical() {
    let format = Format::BINARY32;
    let mut bench = bench(format, Ports::Recoded);
    let mut decoder = converter(decode(format));
    let mut random = generator(5);
    let mut seen = [[0; 4]; 4];
    for _ in 0..cases(2_000_000) {
        let [(a, x), (b, y)] = [(); 2].map(|_| {
            let number = match below(&mut random, 8) {
                0 | 1 => 0.0_f32.to_bits(),
                2 | 3 => f32::INFINITY.to_bits(),
                4 | 5 => f32::NAN.to_bits(),
                _ => number(&mut random),
            } | random.next_u32() & 0x8000_0000;
            let word = disguised(format.encode(number.into()), &mut random);
            assert_eq!(format.decode(word), canonical(f32::from_bits(number)), "decoding {word:#011x}");
            assert_eq!(decoder.run(word), canonical(f32::from_bits(number)), "decoding {word:#011x} in hardware");
            (word, f32::from_bits(format.decode(word) as u32))
        });
        let kind = |number: f32| match number {
            number if number.is_nan() => 0,
            number if number.is_infinite() => 1,
            0.0 => 2,
            _ => 3,
        };
        seen[kind(x)][kind(y)] += 1;
        let expected = answer(x, y);
        let [sum, difference, product] =
            [expected.sum, expected.difference, expected.product].map(|code| format.encode(code));
        let expected = Answer { sum, difference, product, ..expected };
        assert_eq!(bench.run(a, b), expected, "{a:#011x} ({x:e}), {b:#011x} ({y:e})");
    }
    assert!(seen.as_flattened().iter().all(|&count| count >= cases(2_000_000) / 100), "{seen:?}");
}

/// A recoded binary32 word with random bits where they mean nothing.
fn disguised(word: u64, random: &mut impl Rng) -> u64 {
    let (lower_exponent, fraction, sign) = (0x3f << 23, (1 << 23) - 1, 1 << 32);
    let free = match word >> 29 & 0b111 {
        0b000 | 0b110 => lower_exponent | fraction,
        0b111 => sign | lower_exponent | fraction,
        _ => 0,
    };
    word & !free | random.next_u64() & free
}

#[test]
fn every_pair_of_edges() {
    let exponents = [0, 1, 2, 23, 24, 25, 126, 127, 128, 150, 151, 152, 230, 253, 254, 255];
    let fractions = [0, 1, 2, FRACTION / 2, FRACTION / 2 + 1, FRACTION / 2 + 2, FRACTION - 1, FRACTION];
    let signs_and_exponents = exponents.into_iter().flat_map(|exponent| [exponent, exponent | 1 << 8]);
    let numbers: Vec<u32> =
        signs_and_exponents.flat_map(|upper| fractions.map(|fraction| upper << 23 | fraction)).collect();
    let mut bench = bench(Format::BINARY32, Ports::Ieee);
    for &a in &numbers {
        for &b in &numbers {
            let (x, y) = (f32::from_bits(a), f32::from_bits(b));
            assert_eq!(bench.run(a.into(), b.into()), answer(x, y), "{a:#010x} ({x:e}), {b:#010x} ({y:e})");
        }
    }
}

/// Hardware and software recode alike. That they are right for every number is `raypath verify conversions`.
#[test]
fn conversions() {
    let format = Format::BINARY32;
    let mut encoder = converter(encode(format));
    let mut decoder = converter(decode(format));
    let mut check = |code: u32| {
        let recoded = encoder.run(code.into());
        assert_eq!(recoded, format.encode(code.into()), "encoding {code:#010x}");
        assert_eq!(decoder.run(recoded), canonical(f32::from_bits(code)), "decoding {code:#010x}");
    };
    let edges = (0..23).flat_map(|bit| [1 << bit, (1 << bit) - 1, FRACTION ^ 1 << bit, FRACTION ^ ((1 << bit) - 1)]);
    for fraction in edges.chain([FRACTION]) {
        for sign_and_exponent in 0..1 << 9 {
            check(sign_and_exponent << 23 | fraction);
        }
    }
    let mut random = generator(4);
    for _ in 0..cases(CASES) {
        check(random.next_u32() & if below(&mut random, 4) == 0 { 0x80ff_ffff } else { u32::MAX });
    }
}

/// A random number generator, the same in every run.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// How many cases to run: a twentieth in an unoptimised build.
pub fn cases(optimised: u64) -> u64 {
    if cfg!(debug_assertions) { optimised / 20 } else { optimised }
}

/// What the units must say of two binary32 numbers.
pub fn answer(x: f32, y: f32) -> Answer {
    Answer {
        sum: canonical(x + y),
        difference: canonical(x - y),
        product: canonical(x * y),
        less: x < y,
        equal: x == y,
        unordered: x.is_nan() || y.is_nan(),
        parts_differ: 0,
    }
}

/// A number with any sign and exponent and an edge of a fraction; now and then a special value.
pub fn number(random: &mut impl Rng) -> u32 {
    let sign = random.next_u32() & 0x8000_0000;
    sign | match below(random, 16) {
        0 => special(random),
        1 => fraction(random),
        2 => below(random, 30) << 23 | fraction(random),
        3 => (254 - below(random, 3)) << 23 | fraction(random),
        _ => below(random, 255) << 23 | fraction(random),
    }
}

/// Runs the cases and gives how often the results were of a kind that deserves to be seen.
fn check(seed: u64, mut operands: impl FnMut(&mut ChaCha8Rng) -> (u32, u32)) -> Census {
    let mut bench = bench(Format::BINARY32, Ports::Ieee);
    let mut random = generator(seed);
    let mut census = Census::default();
    for _ in 0..cases(CASES) {
        let (a, b) = operands(&mut random);
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        assert_eq!(bench.run(a.into(), b.into()), answer(x, y), "{a:#010x} ({x:e}), {b:#010x} ({y:e})");
        census.relations.count(x, y);
        census.sums.count(x, y, x + y, f64::from(x) + f64::from(y));
        census.products.count(x, y, x * y, f64::from(x) * f64::from(y));
    }
    census
}

#[derive(Default)]
struct Census {
    sums: Kinds,
    products: Kinds,
    relations: Relations,
}

/// How many pairs of operands stood in each relation.
#[derive(Debug, Default, Clone, Copy)]
struct Relations {
    less: u64,
    equal: u64,
    greater: u64,
    unordered: u64,
}

/// How many results were of each kind.
#[derive(Debug, Default, Clone, Copy)]
struct Kinds {
    zero: u64,
    subnormal: u64,
    overflow: u64,
    nan: u64,
    tie_down: u64,
    tie_up: u64,
}

impl Census {
    /// A generator that misses a kind tests less than it seems to.
    fn expect(&self, of: impl Fn(&Self) -> Kinds) {
        let kinds = of(self);
        let Kinds { zero, subnormal, overflow, nan, tie_down, tie_up } = kinds;
        let fewest = zero.min(subnormal).min(overflow).min(nan).min(tie_down).min(tie_up);
        assert!(fewest >= cases(CASES) / 10_000, "{kinds:?}");
    }
}

impl Relations {
    fn count(&mut self, x: f32, y: f32) {
        match x.partial_cmp(&y) {
            Some(Ordering::Less) => self.less += 1,
            Some(Ordering::Equal) => self.equal += 1,
            Some(Ordering::Greater) => self.greater += 1,
            None => self.unordered += 1,
        }
    }
}

impl Kinds {
    fn count(&mut self, x: f32, y: f32, result: f32, exact: f64) {
        self.zero += u64::from(result == 0.0);
        self.subnormal += u64::from(result.is_subnormal());
        self.overflow += u64::from(result.is_infinite() && x.is_finite() && y.is_finite());
        self.nan += u64::from(result.is_nan() && !x.is_nan() && !y.is_nan());
        let (below, above) = (f64::from(result.next_down()), f64::from(result.next_up()));
        let half = |neighbour: f64| exact != f64::from(result) && exact == (f64::from(result) + neighbour) / 2.0;
        let (towards_zero, away) = if result > 0.0 { (below, above) } else { (above, below) };
        self.tie_up += u64::from(half(towards_zero));
        self.tie_down += u64::from(half(away));
    }
}

/// Random, few leading bits, few trailing bits, runs of ones: what ties, carries and cancellations are made of.
fn fraction(random: &mut impl Rng) -> u32 {
    let bits = random.next_u32() & FRACTION;
    let place = below(random, 24);
    match below(random, 6) {
        0 | 1 => bits,
        2 => bits & FRACTION << place & FRACTION,
        3 => bits & FRACTION >> place,
        4 => FRACTION << place & FRACTION,
        _ => FRACTION >> place,
    }
}

fn special(random: &mut impl Rng) -> u32 {
    let smallest_normal = f32::MIN_POSITIVE.to_bits();
    let edges = [0, smallest_normal, 1_f32.to_bits(), f32::MAX.to_bits(), f32::INFINITY.to_bits(), f32::NAN.to_bits()];
    let edge = edges[below(random, edges.len() as u32) as usize];
    // The neighbours are subnormal, and NaNs, signalling ones among them, with a payload.
    edge.saturating_add(below(random, 3)).saturating_sub(1) | random.next_u32() & 0x8000_0000
}

fn canonical(number: f32) -> u64 {
    if number.is_nan() { 0x7fc0_0000 } else { number.to_bits().into() }
}

fn below(random: &mut impl Rng, bound: u32) -> u32 {
    ((u64::from(random.next_u32()) * u64::from(bound)) >> 32) as u32
}
