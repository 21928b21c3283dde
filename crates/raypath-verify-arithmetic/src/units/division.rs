//! Quotients, reciprocals and square roots, pipelined and iterative, against Berkeley SoftFloat and LLVM's soft float.

mod stream;

pub use stream::{Divider, Dividers};

use super::answers::Answers;
use super::campaign::Campaign;
use super::small_formats::SIZES;
use super::softfloat::{divide_binary16, divide_binary32};
use super::testfloat::{BLOCK, Level as TestFloatLevel, Pairs};
use raypath_float::Format;
use raypath_tools::{grouped, pool::Cases};
use raypath_verify::{Error, Request, Verdict};
use std::ops::Range;
use stream::Stream;

/// The operands of cases.
type OperandsOf<'a> = dyn Fn(Range<u64>) -> Vec<(u64, u64)> + Sync + 'a;

/// Cases of one format with one oracle.
struct Phase<'a> {
    format: Format,
    cases: Cases,
    operands: Box<OperandsOf<'a>>,
    oracle: fn(u64, u64) -> Answers,
}

/// Compares the dividers' results, between the encoding and decoding units: TestFloat's cases and a share of all
/// numbers in binary32, all numbers and a share of all pairs in binary16, and all pairs of the small formats. At level
/// `long` the shares are whole.
pub fn division(
    dividers: &dyn Fn(Format) -> Result<Dividers, Error>,
    request: &mut Request<'_>,
) -> Result<Verdict, Error> {
    let level = request.level;
    let (rounds, test_float_stride) = level.pick((1, 25), (1, 1), (10, 1));
    let second = (0..rounds).map(|round| Pairs::new(TestFloatLevel::Two, request.seed, round).every(test_float_stride));
    let lists: Vec<Pairs> = [Pairs::new(TestFloatLevel::One, request.seed, 0)].into_iter().chain(second).collect();
    // Strides are primes, so that all bits vary.
    let mut groups: Vec<(&str, Vec<Phase<'_>>)> = vec![
        ("cases of TestFloat", lists.iter().map(|pairs| test_float(pairs, request)).collect()),
        ("numbers of binary32", vec![numbers(Format::BINARY32, level.pick(65_537, 257, 1), divide_binary32, request)]),
        ("numbers of binary16", vec![numbers(Format::BINARY16, 1, divide_binary16, request)]),
        ("pairs of binary16", vec![pairs(Format::BINARY16, level.pick(16_411, 257, 1), divide_binary16, request)]),
    ];
    let mut small = Vec::new();
    for size in SIZES.iter().filter(|size| size.from <= level && size.exponent + size.significand < 16) {
        small.push(pairs(Format::new(size.exponent, size.significand)?, 1, size.division, request));
    }
    let names: Vec<String> = small.iter().map(|phase| phase.format.to_string()).collect();
    groups.push(("pairs of small formats", small));

    let all: Vec<Cases> = groups.iter().flat_map(|(_, phases)| phases).map(|phase| phase.cases).collect();
    let mut campaign = Campaign::new(request, &all);
    let mut covered = Vec::new();
    for (what, phases) in &groups {
        let before = campaign.done();
        for phase in phases {
            let units = dividers(phase.format)?;
            campaign.run(phase.cases, || units.streams(), |streams, cases| mismatches(streams, phase, cases))?;
        }
        covered.push(format!("{} {what}", grouped(campaign.done() - before)));
    }
    let covered = format!("{} ({}), each through every unit", covered.join(", "), names.join(" "));
    Ok(campaign.verdict(covered))
}

fn test_float<'a>(pairs: &'a Pairs, request: &Request<'_>) -> Phase<'a> {
    Phase {
        format: Format::BINARY32,
        cases: request.cases(pairs.count(), BLOCK),
        operands: Box::new(|cases| {
            pairs.block(cases.start / BLOCK).map(|(a, b)| (u64::from(a), u64::from(b))).collect()
        }),
        oracle: divide_binary32,
    }
}

/// Every `stride`-th number as `a`, and each of as many other numbers as `b`.
fn numbers(format: Format, stride: u64, oracle: fn(u64, u64) -> Answers, request: &Request<'_>) -> Phase<'static> {
    let count = 1_u64 << format.ieee_width();
    // An odd factor permutes all numbers.
    let operands = move |case: u64| (case * stride, (case * stride).wrapping_mul(0x9e37_79b1) % count);
    Phase {
        format,
        cases: request.cases(count.div_ceil(stride), BLOCK),
        operands: Box::new(move |cases| cases.map(operands).collect()),
        oracle,
    }
}

/// Every `stride`-th pair of numbers.
fn pairs(format: Format, stride: u64, oracle: fn(u64, u64) -> Answers, request: &Request<'_>) -> Phase<'static> {
    let width = format.ieee_width();
    let operands = move |case: u64| ((case * stride) >> width, (case * stride) & ((1 << width) - 1));
    Phase {
        format,
        cases: request.cases((1_u64 << (2 * width)).div_ceil(stride), BLOCK),
        operands: Box::new(move |cases| cases.map(operands).collect()),
        oracle,
    }
}

fn mismatches(streams: &mut [Stream], phase: &Phase<'_>, cases: Range<u64>) -> Vec<String> {
    let operands = (phase.operands)(cases);
    let answers: Vec<Answers> = operands.iter().map(|&(a, b)| (phase.oracle)(a, b)).collect();
    streams.iter_mut().flat_map(|stream| stream.mismatches(&operands, &answers)).collect()
}
