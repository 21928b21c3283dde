//! binary32 against Berkeley SoftFloat, on the cases of Berkeley TestFloat.

use super::bench::{Bench, UnitResults, Units};
use super::operands;
use super::testfloat::{BLOCK, Level, Pairs};
use raypath_tools::grouped;
use raypath_verify::campaign::Campaign;
use raypath_verify::{Error, Request, Verdict};
use softfloat_rs::{f32_add, f32_div, f32_eq, f32_le_quiet, f32_lt_quiet, f32_mul, f32_sqrt, f32_sub, float32_t};

/// Compares sums, differences, products, quotients, roots and comparisons of TestFloat's cases and of operands that are
/// hard for one of the units. The netlist holds the units between the encoding and decoding units. All cases of
/// TestFloat's level 1 run; of level 2 every fifth, at level `full` all, and at `long` all a hundred times, each time
/// with other random numbers.
pub fn testfloat(units: &Units, request: &mut Request<'_>) -> Result<Verdict, Error> {
    const OF_TESTFLOAT: &str = "of TestFloat";
    const HARD: &str = "hard";
    let seed = request.seed;
    let (rounds, stride) = request.level.pick((1, 5), (1, 1), (100, 1));
    let second = (0..rounds).map(|round| Pairs::new(Level::Two, seed, round).every(stride));
    let lists: Vec<Pairs> = [Pairs::new(Level::One, seed, 0)].into_iter().chain(second).collect();
    let blocks: Vec<(&Pairs, u64)> =
        lists.iter().flat_map(|pairs| (0..pairs.count().div_ceil(BLOCK)).map(move |block| (pairs, block))).collect();
    let hard = request.level.pick(60, 600, 6000);
    let campaign = Campaign { block: 1, ..Campaign::new(5, blocks.len() as u64 + hard) };
    let begin = || Ok(Bench::new(units)?);
    let (tally, is_stopped) = campaign.run(request, begin, |bench, number, random, tally| {
        let mut check = |name, (a, b)| {
            tally.add(name, 1_u64);
            mismatches(bench, a, b).into_iter().for_each(|mismatch| tally.fail(|| mismatch));
        };
        match blocks.get(number as usize) {
            Some((pairs, block)) => pairs.block(*block).for_each(|pair| check(OF_TESTFLOAT, pair)),
            None => {
                let families = [operands::for_sums, operands::for_products, operands::for_comparisons];
                families.iter().cycle().take(BLOCK as usize).for_each(|family| check(HARD, family(random)));
            }
        }
        Ok(())
    })?;
    let covered = format!(
        "{} cases of TestFloat and {} hard ones, each of addition, subtraction, multiplication, division, square root \
         and comparison",
        grouped(tally.count(OF_TESTFLOAT)),
        grouped(tally.count(HARD)),
    );
    Ok(tally.verdict(is_stopped, covered, Vec::new(), ("", [], false)))
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

/// SoftFloat's results for two binary32 words, and whether the first is less than or equal to the second.
///
/// SoftFloat rounds to nearest, ties to even, unless a thread sets another rounding mode. This crate never sets one.
#[allow(unsafe_code)]
fn oracle(a: u32, b: u32) -> (UnitResults, bool) {
    let (x, y) = (float32_t { v: a }, float32_t { v: b });
    // SAFETY: the C functions take and return words by value and have no preconditions. The state that they read and
    // write (rounding mode, exception flags) belongs to the thread.
    let results = unsafe { [f32_add(x, y), f32_sub(x, y), f32_mul(x, y), f32_div(x, y), f32_sqrt(x)] };
    let [sum, difference, product, quotient, root] = results.map(canonical);
    // SAFETY: as above.
    let (equal, less, less_or_equal, greater_or_equal) =
        unsafe { (f32_eq(x, y), f32_lt_quiet(x, y), f32_le_quiet(x, y), f32_le_quiet(y, x)) };
    let results = UnitResults {
        sum,
        difference,
        product,
        quotient,
        root,
        less,
        equal,
        unordered: !less_or_equal && !greater_or_equal,
    };
    (results, less_or_equal)
}

/// The bits of a result, with every NaN replaced by the canonical one. SoftFloat propagates the payloads of NaNs, as
/// x86 processors do; the datapath has one NaN.
fn canonical(number: float32_t) -> u64 {
    if number.v & 0x7fff_ffff > 0x7f80_0000 { 0x7fc0_0000 } else { number.v.into() }
}
