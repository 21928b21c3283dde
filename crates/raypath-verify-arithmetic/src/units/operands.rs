//! Hard operands for the binary32 units, and the expected results by the host's `f32`.
//!
//! The item `testfloat` runs them on the units; mutation runs the same families on units with faults.

use super::bench::UnitResults;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use raypath_float::Format;

/// Pairs of operands of each family on units with faults, in mutation.
pub const CASES: u64 = 6_000_000;
/// Pairs of words that are not canonical, there.
pub const RECODED_CASES: u64 = 2_000_000;

/// The bits of a binary32 fraction.
const FRACTION: u32 = 0x007f_ffff;

/// The host's results for two binary32 numbers, in IEEE 754's format, with the canonical NaN.
pub fn host_results(x: f32, y: f32) -> UnitResults {
    UnitResults {
        sum: canonical(x + y),
        difference: canonical(x - y),
        product: canonical(x * y),
        quotient: canonical(x / y),
        root: canonical(x.sqrt()),
        less: x < y,
        equal: x == y,
        unordered: x.is_nan() || y.is_nan(),
    }
}

/// The bits of a number, with the canonical NaN for every NaN.
pub fn canonical(number: f32) -> u64 {
    if number.is_nan() { 0x7fc0_0000 } else { number.to_bits().into() }
}

/// A random number generator, the same in every run.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Operands whose sum cancels or is a tie, or of which the smaller is shifted by a few bits.
pub fn for_sums(random: &mut ChaCha8Rng) -> (u32, u32) {
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
}

/// Operands whose product is subnormal, underflows to zero, is near the largest number, or has any exponent.
pub fn for_products(random: &mut ChaCha8Rng) -> (u32, u32) {
    let a = number(random);
    let exponent = a >> 23 & 0xff;
    if below(random, 16) == 0 {
        return (a, special(random));
    }
    let target = match below(random, 4) {
        // The product's biased exponent: from underflow to the first normal numbers, near the largest, any.
        0 | 1 => below(random, 30) as i32 - 27,
        2 => below(random, 6) as i32 + 251,
        _ => below(random, 256) as i32,
    };
    let needed = (target + 127 - exponent as i32).clamp(0, 254) as u32;
    (a, needed << 23 | fraction(random) | random.next_u32() & 0x8000_0000)
}

/// Operands that are equal, opposite, or differ by a few ulps or by one bit.
pub fn for_comparisons(random: &mut ChaCha8Rng) -> (u32, u32) {
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
}

/// Numbers with exponents and fractions at the ends of their ranges, of both signs. Tests run all pairs of them.
pub fn edges() -> Vec<u32> {
    let exponents = [0, 1, 2, 23, 24, 25, 126, 127, 128, 150, 151, 152, 230, 253, 254, 255];
    let fractions = [0, 1, 2, FRACTION / 2, FRACTION / 2 + 1, FRACTION / 2 + 2, FRACTION - 1, FRACTION];
    let signs_and_exponents = exponents.into_iter().flat_map(|exponent| [exponent, exponent | 1 << 8]);
    signs_and_exponents.flat_map(|upper| fractions.map(|fraction| upper << 23 | fraction)).collect()
}

/// A recoded word and the number that it encodes. Three of four words are zeros, infinities or NaNs with random bits in
/// the positions that their class ignores.
pub fn recoded(random: &mut ChaCha8Rng) -> (u64, f32) {
    let format = Format::BINARY32;
    let number = match below(random, 8) {
        0 | 1 => 0.0_f32.to_bits(),
        2 | 3 => f32::INFINITY.to_bits(),
        4 | 5 => f32::NAN.to_bits(),
        _ => number(random),
    } | random.next_u32() & 0x8000_0000;
    (with_random_ignored_bits(format.encode(number.into()), random), f32::from_bits(number))
}

/// A random word for the converters; one in four has the exponent field 0 or 1, so that half of these are subnormal.
pub fn for_conversions(random: &mut ChaCha8Rng) -> u32 {
    random.next_u32() & if below(random, 4) == 0 { 0x80ff_ffff } else { u32::MAX }
}

/// Every sign and exponent with these fractions: one bit set, all bits below one set, and the complements of both.
pub fn edges_of_conversions() -> impl Iterator<Item = u32> {
    let fractions =
        (0..23).flat_map(|bit| [1 << bit, (1 << bit) - 1, FRACTION ^ 1 << bit, FRACTION ^ ((1 << bit) - 1)]);
    let fractions = fractions.chain([FRACTION]);
    fractions.flat_map(|fraction| (0..1 << 9).map(move |upper| upper << 23 | fraction))
}

/// A number with any sign and exponent and a fraction near an end of its range; one in 16 is a special value.
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

/// A recoded binary32 word with random bits in the positions that its class ignores.
fn with_random_ignored_bits(word: u64, random: &mut impl Rng) -> u64 {
    let (lower_exponent, fraction, sign) = (0x3f << 23, (1 << 23) - 1, 1 << 32);
    let free = match word >> 29 & 0b111 {
        0b000 | 0b110 => lower_exponent | fraction,
        0b111 => sign | lower_exponent | fraction,
        _ => 0,
    };
    word & !free | random.next_u64() & free
}

/// A fraction of random bits, of few leading or trailing bits, or of a run of ones: they cause ties, carries and
/// cancellation.
fn fraction(random: &mut impl Rng) -> u32 {
    let bits = random.next_u32() & FRACTION;
    let shift = below(random, 24);
    match below(random, 6) {
        0 | 1 => bits,
        2 => bits & FRACTION << shift & FRACTION,
        3 => bits & FRACTION >> shift,
        4 => FRACTION << shift & FRACTION,
        _ => FRACTION >> shift,
    }
}

fn special(random: &mut impl Rng) -> u32 {
    let smallest_normal = f32::MIN_POSITIVE.to_bits();
    let edges = [0, smallest_normal, 1_f32.to_bits(), f32::MAX.to_bits(), f32::INFINITY.to_bits(), f32::NAN.to_bits()];
    let edge = edges[below(random, edges.len() as u32) as usize];
    // The neighbours are subnormal, and NaNs, signalling ones among them, with a payload.
    edge.saturating_add(below(random, 3)).saturating_sub(1) | random.next_u32() & 0x8000_0000
}

fn below(random: &mut impl Rng, bound: u32) -> u32 {
    ((u64::from(random.next_u32()) * u64::from(bound)) >> 32) as u32
}
