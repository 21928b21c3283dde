//! binary32 against Berkeley SoftFloat, on the cases of Berkeley TestFloat; and SoftFloat's division.

use super::aimed;
use super::answers::Answers;
use super::bench::{Bench, PortFormat, UnitResults, Units};
use super::campaign::Campaign;
use super::exceptions::{FUNCTIONS, FlagBench, Flagged};
use super::testfloat::{BLOCK, Level, Pairs};
use raypath_float::flags;
use raypath_tools::{grouped, pool::Cases};
use raypath_verify::{Error, Request, Verdict};
use softfloat_rs::{f16_div, f16_sqrt, float16_t};
use softfloat_rs::{f32_add, f32_div, f32_eq, f32_le_quiet, f32_lt_quiet, f32_mul, f32_sqrt, f32_sub, float32_t};
use softfloat_rs::{
    softfloat_detectTininess_write_helper, softfloat_exceptionFlags_read_helper, softfloat_exceptionFlags_write_helper,
};

/// Compares sums, differences, products and comparisons of TestFloat's cases, and the exceptions that `flagged` units
/// raise. The netlists hold the units, unsplit and split, between the encoding and decoding units. All cases of
/// TestFloat's level 1 run; of level 2 every fifth, at level `full` all, and at `long` all a hundred times, each time
/// with other random numbers. Cases that are aimed at the models of IBM's test suite run as well, and must hit each of
/// their coverage points.
pub fn testfloat(units: &Units, flagged: &Units, request: &mut Request<'_>) -> Result<Verdict, Error> {
    let seed = request.seed;
    let (rounds, stride) = request.level.pick((1, 5), (1, 1), (100, 1));
    let second = (0..rounds).map(|round| Pairs::new(Level::Two, seed, round).every(stride));
    let lists: Vec<Pairs> = [Pairs::new(Level::One, seed, 0)].into_iter().chain(second).collect();
    let blocks = request.level.pick(60, 600, 6000);
    let aimed_cases = request.cases(blocks * aimed::BLOCK, aimed::BLOCK);
    let phases: Vec<Cases> = lists.iter().map(|pairs| request.cases(pairs.count(), BLOCK)).collect();
    let mut campaign = Campaign::new(request, &[phases.as_slice(), &[aimed_cases]].concat());
    let begin = || Ok((Bench::new(units, PortFormat::Ieee)?, FlagBench::new(flagged)?));
    let mut level_one = 0;
    for (pairs, phase) in lists.iter().zip(phases) {
        campaign.run(phase, begin, |benches, cases| {
            pairs.block(cases.start / BLOCK).flat_map(|(a, b)| all_mismatches(benches, a, b)).collect()
        })?;
        if pairs.level() == Level::One {
            level_one = campaign.done();
        }
    }
    let level_two = campaign.done() - level_one;
    campaign.run(aimed_cases, begin, |benches, cases| {
        aimed::block(seed, cases.start / aimed::BLOCK).flat_map(|(a, b)| all_mismatches(benches, a, b)).collect()
    })?;
    let covered = format!(
        "{} cases of level 1, {} of level 2 and {} aimed ones, each of addition, subtraction, multiplication and \
         comparison, and of their exceptions",
        grouped(level_one),
        grouped(level_two),
        grouped(campaign.done() - level_one - level_two),
    );
    let mut verdict = campaign.verdict(covered);
    if !verdict.is_stopped {
        let (points, missing) = aimed::covered(seed, blocks).missing();
        verdict.remarks.push(format!("{points} coverage points of IBM's test suite, hit by the aimed cases"));
        verdict.failures.extend(missing);
    }
    Ok(verdict)
}

/// What is wrong of the results and of the exceptions.
fn all_mismatches((bench, flagged): &mut (Bench, FlagBench), a: u32, b: u32) -> Vec<String> {
    mismatches(bench, a, b).into_iter().chain(wrong_flags(flagged, a, b)).collect()
}

fn mismatches(bench: &mut Bench, a: u32, b: u32) -> Vec<String> {
    let (found, (expected, less_or_equal)) = (bench.run(a.into(), b.into()), oracle(a, b));
    if found == expected && (found.less | found.equal) == less_or_equal {
        return Vec::new();
    }
    let operands = format!("{a:#010x} and {b:#010x}");
    let mut mismatches = found.mismatches(expected, &operands);
    if (found.less | found.equal) != less_or_equal {
        mismatches.push(format!("less or equal of {operands}: {}, expected {less_or_equal}", !less_or_equal));
    }
    mismatches
}

/// What the units with flags give wrong.
fn wrong_flags(bench: &mut FlagBench, a: u32, b: u32) -> Vec<String> {
    let ((found, differing), expected) = (bench.run(a.into(), b.into()), exceptions(a, b));
    if found == expected && differing == 0 {
        return Vec::new();
    }
    let operands = format!("{a:#010x} and {b:#010x}");
    let pairs = FUNCTIONS.iter().zip(found.into_iter().zip(expected));
    let wrong = pairs.filter(|(_, (found, expected))| found != expected).map(|(name, (found, expected))| {
        let shown = |flagged: Flagged| format!("{:#x} with flags {:04b}", flagged.number, flagged.flags);
        format!("{name} of {operands}: {}, expected {}", shown(found), shown(expected))
    });
    let others = format!("units with flags for {operands}: {differing} differ from the unsplit ones");
    wrong.chain((differing > 0).then_some(others)).collect()
}

/// SoftFloat's results for two binary32 words, with the exceptions that it raises. Tininess is detected before
/// rounding, and no NaN is signalling, as docs/reference/features.md states.
#[allow(unsafe_code)]
fn exceptions(a: u32, b: u32) -> [Flagged; FUNCTIONS.len()] {
    const BEFORE_ROUNDING: u8 = 0;
    let has_nan = [a, b].iter().any(|word| word & 0x7fff_ffff > 0x7f80_0000);
    let functions = [f32_add, f32_sub, f32_mul];
    functions.map(|function| {
        // SAFETY: the C functions take and return words by value and have no preconditions. The state that they read
        // and write belongs to the thread.
        let (number, raised) = unsafe {
            softfloat_detectTininess_write_helper(BEFORE_ROUNDING);
            softfloat_exceptionFlags_write_helper(0);
            (function(float32_t { v: a }, float32_t { v: b }), softfloat_exceptionFlags_read_helper())
        };
        let flag = |softfloat: u8, ours: u64| if raised & softfloat == 0 { 0 } else { ours };
        let invalid = if has_nan { 0 } else { flag(16, flags::INVALID) };
        let flags = invalid | flag(4, flags::OVERFLOW) | flag(2, flags::UNDERFLOW) | flag(1, flags::INEXACT);
        Flagged { number: canonical(number), flags }
    })
}

/// SoftFloat's results for two binary32 words, and whether the first is less than or equal to the second.
///
/// SoftFloat rounds to nearest, ties to even, unless a thread sets another rounding mode. This crate never sets one.
#[allow(unsafe_code)]
fn oracle(a: u32, b: u32) -> (UnitResults, bool) {
    let (x, y) = (float32_t { v: a }, float32_t { v: b });
    // SAFETY: the C functions take and return words by value and have no preconditions. The state that they read and
    // write (rounding mode, exception flags) belongs to the thread.
    let (sum, difference, product) = unsafe { (f32_add(x, y), f32_sub(x, y), f32_mul(x, y)) };
    // SAFETY: as above.
    let (equal, less, less_or_equal, greater_or_equal) =
        unsafe { (f32_eq(x, y), f32_lt_quiet(x, y), f32_le_quiet(x, y), f32_le_quiet(y, x)) };
    let results = UnitResults {
        sum: canonical(sum),
        difference: canonical(difference),
        product: canonical(product),
        less,
        equal,
        unordered: !less_or_equal && !greater_or_equal,
        others_differ: 0,
    };
    (results, less_or_equal)
}

/// SoftFloat's quotient, reciprocal and root for two binary32 words.
#[allow(unsafe_code)]
pub(super) fn divide_binary32(a: u64, b: u64) -> Answers {
    let [a, b, one] = [a as u32, b as u32, 0x3f80_0000].map(|v| float32_t { v });
    // SAFETY: as above.
    let (quotient, reciprocal, root) = unsafe { (f32_div(a, b), f32_div(one, b), f32_sqrt(a)) };
    Answers { quotient: canonical(quotient), reciprocal: canonical(reciprocal), root: canonical(root) }
}

/// SoftFloat's quotient, reciprocal and root for two binary16 words.
#[allow(unsafe_code)]
pub(super) fn divide_binary16(a: u64, b: u64) -> Answers {
    let [a, b, one] = [a as u16, b as u16, 0x3c00].map(|v| float16_t { v });
    // SAFETY: as above.
    let (quotient, reciprocal, root) = unsafe { (f16_div(a, b), f16_div(one, b), f16_sqrt(a)) };
    let canonical = |number: float16_t| if number.v & 0x7fff > 0x7c00 { 0x7e00 } else { number.v.into() };
    Answers { quotient: canonical(quotient), reciprocal: canonical(reciprocal), root: canonical(root) }
}

/// The bits of a result, with every NaN replaced by the canonical one. SoftFloat propagates the payloads of NaNs, as
/// x86 processors do; the datapath has one NaN.
fn canonical(number: float32_t) -> u64 {
    if number.v & 0x7fff_ffff > 0x7f80_0000 { 0x7fc0_0000 } else { number.v.into() }
}
