//! Pairs of binary32 operands that are aimed at the points of [`Covered`].

use super::coverage::Covered;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The number of pairs in a block, which has random numbers of its own.
pub const BLOCK: u64 = 4096;

const SIGN: u32 = 1 << 31;
const HIDDEN: u32 = 1 << 23;
const FRACTION: u32 = HIDDEN - 1;
const LARGEST: u32 = 0x7f7f_ffff;
const LEAST_NORMAL: u32 = HIDDEN;

/// The pairs of a block.
pub fn block(seed: u64, number: u64) -> impl Iterator<Item = (u32, u32)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1 << 40 | number);
    (0..BLOCK).map(move |index| pair(&mut rng, number * BLOCK + index))
}

/// What the pairs of this many blocks cover.
pub fn covered(seed: u64, blocks: u64) -> Covered {
    let mut covered = Covered::default();
    (0..blocks).flat_map(|number| block(seed, number)).for_each(|(a, b)| covered.add(a, b));
    covered
}

/// Words of each basic type, without sign.
const TYPES: [u32; 12] = [
    0,
    1,
    0x0000_1234,
    LEAST_NORMAL - 1,
    LEAST_NORMAL,
    0x4123_4567,
    LARGEST,
    0x3f80_0000,
    0x7f80_0000,
    0x7fc0_0000,
    0x7fc0_0001,
    0x7f80_0001,
];

fn pair(rng: &mut ChaCha8Rng, index: u64) -> (u32, u32) {
    let signs =
        |rng: &mut ChaCha8Rng, (a, b): (u32, u32)| (a ^ rng.random::<u32>() & SIGN, b ^ rng.random::<u32>() & SIGN);
    let types = 2 * TYPES.len() as u64;
    if index < types * types {
        let word = |kind: u64| TYPES[kind as usize % TYPES.len()] | if kind < types / 2 { 0 } else { SIGN };
        return (word(index / types), word(index % types));
    }
    let one_of_two = rng.random::<bool>();
    let magnitudes = match rng.random_range(0..9) {
        0 => products_that_lose(rng),
        1 => {
            // The product has three bits set, the last at the sum of both places.
            let [j, k] = [rng.random_range(1..24), rng.random_range(1..24)];
            let one = 127 << 23;
            (one | 1 << (23 - j), one | 1 << (23 - k))
        }
        2 => (with_exponent(rng, 64..192) | significand(rng), with_exponent(rng, 64..192) | significand(rng)),
        3 => sums_that_lose(rng),
        4 => {
            // Neighbours, which cancel up to the last bits.
            let a = with_exponent(rng, 1..254) | significand(rng);
            let distance = 1 << rng.random_range(0..24);
            (a, if one_of_two { a.saturating_sub(distance) } else { (a + distance).min(LARGEST) })
        }
        5 => {
            // Near the largest number: a sum with some of its units, or a product with nearly 1, 2 or 1/2.
            let near = LARGEST - rng.random_range(0..5);
            let units = (104 + 127 + rng.random_range(0..2_u32)) << 23 | rng.random_range(0..2_u32) << 22;
            let factor = ((126 + rng.random_range(0..3_u32)) << 23).wrapping_add_signed(rng.random_range(-3..4));
            (near, if one_of_two { units } else { factor })
        }
        6 => {
            // Near zero and the least normal number, as sums and products with about 1.
            let small = [rng.random_range(0..8), LEAST_NORMAL + rng.random_range(0..8) - 4][usize::from(one_of_two)];
            let one = (0x3f80_0000_u32).wrapping_add_signed(rng.random_range(-2..3));
            (small, if rng.random() { one } else { rng.random_range(0..8) })
        }
        7 => {
            // Products about the least subnormal number.
            let a = rng.random_range(1..120);
            let b = (127 + 127 - 149 - a as i32 + rng.random_range(-3..2)).max(1) as u32;
            let digits = |rng: &mut ChaCha8Rng| if rng.random() { 0 } else { significand(rng) };
            (a << 23 | digits(rng), b << 23 | digits(rng))
        }
        _ => {
            // Fields that two numbers share.
            let (a, b) = (rng.random::<u32>(), rng.random::<u32>());
            (a, if one_of_two { a & !FRACTION | b & FRACTION } else { b & !FRACTION | a & FRACTION })
        }
    };
    let (a, b) = if rng.random() { magnitudes } else { (magnitudes.1, magnitudes.0) };
    signs(rng, (a, b))
}

fn with_exponent(rng: &mut ChaCha8Rng, fields: std::ops::Range<u32>) -> u32 {
    rng.random_range(fields) << 23
}

/// A fraction with a run of zeros or ones at an end, with alternating bits, or random.
fn significand(rng: &mut ChaCha8Rng) -> u32 {
    let (length, any) = (rng.random_range(0..24), rng.random::<u32>());
    let low = (1 << length) - 1;
    FRACTION
        & match rng.random_range(0..7) {
            0 => any & !low | (1_u32 << length),
            1 => (any | low) & !(1 << length),
            2 => any & low >> 1 | low.wrapping_add(1) >> 1,
            3 => !(any & low >> 1 | low.wrapping_add(1) >> 1),
            4 => 0x0055_5555,
            5 => 0x002a_aaaa,
            _ => any,
        }
}

/// Lost bits that are near nothing, a half, or a whole unit: bits below the last place, of which there are `count`.
fn lost(rng: &mut ChaCha8Rng, count: u32) -> u32 {
    let half = 1_u32 << (count - 1);
    [0, 1, half - 1, half, half + 1, 2 * half - 1, rng.random::<u32>() & (2 * half - 1)][rng.random_range(0..7)]
}

/// Two numbers from 1 to 2 whose product, if it is below 2, loses chosen bits: an odd first significand has an inverse.
fn products_that_lose(rng: &mut ChaCha8Rng) -> (u32, u32) {
    let a = (rng.random::<u32>() & FRACTION >> rng.random_range(0..12)) | 1 | HIDDEN;
    // Newton's iteration doubles the number of right bits, of which an odd number has three.
    let inverse = (0..4).fold(a, |inverse, _| inverse.wrapping_mul(2_u32.wrapping_sub(a.wrapping_mul(inverse))));
    let b = inverse.wrapping_mul(lost(rng, 23)) & FRACTION;
    let fields = [with_exponent(rng, 100..150), with_exponent(rng, 100..150)];
    (fields[0] | a & FRACTION, fields[1] | b)
}

/// Two numbers whose sum loses chosen bits: the second is up to 28 places below the first.
fn sums_that_lose(rng: &mut ChaCha8Rng) -> (u32, u32) {
    let (field, distance) = (rng.random_range(40..200), rng.random_range(0..29));
    let a = field << 23 | significand(rng);
    let bits = lost(rng, distance.clamp(1, 23)) | rng.random::<u32>() << distance.clamp(1, 23);
    (a, (field - distance) << 23 | bits & FRACTION)
}
