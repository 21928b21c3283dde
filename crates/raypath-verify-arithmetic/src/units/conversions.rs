//! The encoding and decoding units of binary32, on all numbers.

use super::bench::{Simulated, Units};
use super::campaign::Campaign;
use super::testfloat::{Level, singles};
use raypath_tools::grouped;
use raypath_verify::{Error, Request, Verdict};

const SIGN: u64 = 1 << 31;
const INFINITY: u64 = 0x7f80_0000;
const NAN: u64 = 0x7fc0_0000;

/// The recoded sign, infinity and NaN, by the table of `docs/reference/formats.md`.
const RECODED_SIGN: u64 = 1 << 32;
const RECODED_INFINITY: u64 = 0x180 << 23;
const RECODED_NAN: u64 = 0x1c0 << 23 | 1 << 22;

/// Cases of one phase: the numbers of binary32.
const NUMBERS: u64 = 1 << 32;
/// Cases of another: the recoded words of the classes zero, infinity and NaN, which ignore most other bits.
const SPECIAL_WORDS: u64 = 3 << 30;

/// The stride of numbers and words at level `regression`: a prime, so that all bits vary.
const STRIDE: u64 = 257;

/// Runs every number of binary32 and every recoded word of a special class through the units' netlists; at level
/// `regression` every 257th, and the edges.
pub fn conversions(units: &Units, request: &mut Request<'_>) -> Result<Verdict, Error> {
    let stride = request.level.pick(STRIDE, 1, 1);
    let edges = edges(request.seed);
    let phase = |cases| request.cases(cases, 1 << 16);
    let phases = [edges.len() as u64, NUMBERS.div_ceil(stride), SPECIAL_WORDS.div_ceil(stride)].map(phase);
    let mut campaign = Campaign::new(request, &phases);
    let mut ends = Vec::new();
    for (index, phase) in phases.into_iter().enumerate() {
        let begin = || Ok((Simulated::new(&units.encode)?, Simulated::new(&units.decode)?));
        campaign.run(phase, begin, |(encode, decode), cases| match index {
            0 => numbers(encode, decode, cases.map(|case| edges[case as usize])),
            1 => numbers(encode, decode, cases.map(|case| case * stride)),
            _ => cases.filter_map(|case| special_word(decode, case * stride)).collect(),
        })?;
        ends.push(campaign.done());
    }
    let covered =
        format!("{} numbers and {} words of zero, infinity and NaN", grouped(ends[1]), grouped(ends[2] - ends[1]));
    Ok(campaign.verdict(covered))
}

/// Every sign and exponent with fractions near each power of two; TestFloat's cases; and the successor of each.
fn edges(seed: u64) -> Vec<u64> {
    let powers = (0..23).flat_map(|bit| [1_u64 << bit, (1 << 23) - (1 << bit)]);
    let fractions: Vec<u64> = powers.flat_map(|power| [power - 1, power, (power + 1) & 0x7f_ffff]).collect();
    let patterns = (0..1_u64 << 9).flat_map(|upper| fractions.iter().map(move |fraction| upper << 23 | fraction));
    patterns
        .chain(singles(Level::Two, seed).into_iter().map(u64::from))
        .flat_map(|code| [code, (code + 1) % NUMBERS])
        .collect()
}

/// The failures of these numbers. Each must be encoded by the table of `docs/reference/formats.md`, be decoded to
/// itself, and have a greater word than the next smaller magnitude.
fn numbers(encode: &mut Simulated, decode: &mut Simulated, codes: impl Iterator<Item = u64>) -> Vec<String> {
    let mut faults = Vec::new();
    let mut last = None;
    for code in codes {
        let [recoded] = encode.run([code]);
        let (magnitude, is_nan) = (code & !SIGN, code & !SIGN > INFINITY);
        if recoded != by_the_table(code as u32) {
            faults
                .push(format!("encoding {code:#010x}: {recoded:#011x}, expected {:#011x}", by_the_table(code as u32)));
        }
        let [again] = decode.run([recoded]);
        let expected = if is_nan { NAN } else { code };
        if again != expected {
            faults.push(format!(
                "decoding {recoded:#011x}, which is {code:#010x}: {again:#010x}, expected {expected:#010x}"
            ));
        }
        if magnitude > 0 && !is_nan {
            let before = match last {
                Some((before, word)) if before + 1 == code => word,
                _ => encode.run::<1>([code - 1])[0],
            };
            if recoded <= before || (recoded ^ before) & RECODED_SIGN != 0 {
                faults.push(format!(
                    "order of {code:#010x}: {recoded:#011x}, expected more than {before:#011x}, its predecessor's word"
                ));
            }
        }
        last = Some((code, recoded));
    }
    faults
}

/// A number's recoded word. Its exponent and fraction are those of the number in binary64, in which no number of
/// binary32 is subnormal; the host converts it.
fn by_the_table(code: u32) -> u64 {
    let number = f32::from_bits(code);
    let sign = if number.is_sign_negative() { RECODED_SIGN } else { 0 };
    if number.is_nan() {
        return RECODED_NAN;
    }
    if number == 0.0 {
        return sign;
    }
    if number.is_infinite() {
        return sign | RECODED_INFINITY;
    }
    let double = f64::from(number.abs()).to_bits();
    let (exponent, fraction) = ((double >> 52) as i64 - 1023, double >> 29 & 0x7f_ffff);
    sign | ((exponent + 256) as u64) << 23 | fraction
}

/// The failure of decoding the special word with this number, if it fails.
fn special_word(decode: &mut Simulated, case: u64) -> Option<String> {
    let (class, sign, free) = (case >> 30, case >> 29 & 1, case & ((1 << 29) - 1));
    let (top_three, magnitude) = [(0b000, 0), (0b110, INFINITY), (0b111, NAN)][class as usize];
    let expected = if magnitude == NAN { NAN } else { sign << 31 | magnitude };
    let word = sign << 32 | top_three << 29 | free;
    let [found] = decode.run([word]);
    (found != expected).then(|| format!("decoding {word:#011x}: {found:#010x}, expected {expected:#010x}"))
}
