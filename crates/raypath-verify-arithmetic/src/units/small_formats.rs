//! All pairs of operands of small formats, against LLVM's soft float.

use super::answers::Answers;
use super::bench::{Bench, PortFormat, UnitResults, Units};
use super::campaign::Campaign;
use raypath_float::Format;
use raypath_tools::{grouped, pool::Cases};
use raypath_verify::{Error, Level, Request, Verdict};
use rustc_apfloat::ieee::{Double, HalfS, IeeeFloat, Semantics};
use rustc_apfloat::{Float, FloatConvert};
use std::cmp::Ordering;

/// A format, its oracles, and the lowest level that runs it.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub exponent: u32,
    pub significand: u32,
    oracle: fn(u64, u64) -> UnitResults,
    pub division: fn(u64, u64) -> Answers,
    pub from: Level,
}

/// At level `regression` the formats of 7 and 8 bits; at `full` also the others of up to 11 bits; at `long` binary16.
pub(super) const SIZES: &[Size] = &[
    size::<3, 4>(Level::Regression),
    size::<4, 4>(Level::Regression),
    size::<5, 3>(Level::Regression),
    size::<3, 3>(Level::Full),
    size::<3, 5>(Level::Full),
    size::<4, 3>(Level::Full),
    size::<4, 5>(Level::Full),
    size::<4, 6>(Level::Full),
    size::<4, 7>(Level::Full),
    size::<5, 4>(Level::Full),
    size::<5, 5>(Level::Full),
    size::<5, 6>(Level::Full),
    size::<6, 3>(Level::Full),
    size::<6, 4>(Level::Full),
    size::<6, 5>(Level::Full),
    size::<7, 3>(Level::Full),
    size::<7, 4>(Level::Full),
    size::<8, 3>(Level::Full),
    Size {
        exponent: 5,
        significand: 11,
        oracle: of_semantics::<HalfS>,
        division: division_of_semantics::<HalfS>,
        from: Level::Long,
    },
];

const fn size<const E: usize, const S: usize>(from: Level) -> Size {
    let division = division_of_semantics::<Widths<E, S>>;
    Size { exponent: E as u32, significand: S as u32, oracle: oracle::<E, S>, division, from }
}

/// A format of `E` exponent and `S` significand bits, in the form that `rustc_apfloat` needs.
struct Widths<const E: usize, const S: usize>;

impl<const E: usize, const S: usize> Semantics for Widths<E, S> {
    const BITS: usize = E + S;
    const EXP_BITS: usize = E;
}

/// Compares sums, differences, products and comparisons of all pairs of operands. The netlist holds the units, unsplit
/// and split, between the encoding and decoding units.
pub fn small_formats(
    units: &dyn Fn(Format) -> Result<Units, Error>,
    request: &mut Request<'_>,
) -> Result<Verdict, Error> {
    let sizes: Vec<Size> = SIZES.iter().copied().filter(|size| size.from <= request.level).collect();
    let phase = |size: &Size| request.cases(1 << (2 * (size.exponent + size.significand)), 1 << 12);
    let phases: Vec<Cases> = sizes.iter().map(phase).collect();
    let mut campaign = Campaign::new(request, &phases);
    for (size, phase) in sizes.iter().zip(phases) {
        let format = Format::new(size.exponent, size.significand)?;
        let (units, width) = (units(format)?, format.ieee_width());
        campaign.run(
            phase,
            || Ok(Bench::new(&units, PortFormat::Ieee)?),
            |bench, cases| {
                cases.flat_map(|case| mismatches(bench, size, case >> width, case & ((1 << width) - 1))).collect()
            },
        )?;
    }
    let names: Vec<String> = sizes.iter().map(|size| format!("({}, {})", size.exponent, size.significand)).collect();
    let covered = format!(
        "{} pairs of operands of {} formats, each of addition, subtraction, multiplication and comparison: {}",
        grouped(campaign.done()),
        names.len(),
        names.join(" ")
    );
    Ok(campaign.verdict(covered))
}

fn mismatches(bench: &mut Bench, size: &Size, a: u64, b: u64) -> Vec<String> {
    let (found, expected) = (bench.run(a, b), (size.oracle)(a, b));
    if found == expected {
        return Vec::new();
    }
    found.mismatches(expected, &format!("{a:#x} and {b:#x} of e{}s{}", size.exponent, size.significand))
}

/// The expected results for two IEEE 754 codes of a format of `E` exponent and `S` significand bits.
pub fn oracle<const E: usize, const S: usize>(a: u64, b: u64) -> UnitResults {
    of_semantics::<Widths<E, S>>(a, b)
}

fn of_semantics<S: Semantics>(a: u64, b: u64) -> UnitResults {
    let (x, y) = (IeeeFloat::<S>::from_bits(a.into()), IeeeFloat::<S>::from_bits(b.into()));
    let order = x.partial_cmp(&y);
    UnitResults {
        sum: code((x + y).value),
        difference: code((x - y).value),
        product: code((x * y).value),
        less: order == Some(Ordering::Less),
        equal: order == Some(Ordering::Equal),
        unordered: order.is_none(),
        others_differ: 0,
    }
}

/// The host takes the root in binary64. A root that is not a midpoint between numbers of at most 24 bits differs from
/// all of them within 50 bits, so that the second rounding changes nothing.
fn division_of_semantics<S: Semantics>(a: u64, b: u64) -> Answers {
    let (x, y) = (IeeeFloat::<S>::from_bits(a.into()), IeeeFloat::<S>::from_bits(b.into()));
    let of_f64 = |number: f64| -> IeeeFloat<S> { Double::from_bits(number.to_bits().into()).convert(&mut false).value };
    let wide: Double = x.convert(&mut false).value;
    Answers {
        quotient: code((x / y).value),
        reciprocal: code((of_f64(1.0) / y).value),
        root: code(of_f64(f64::from_bits(wide.to_bits() as u64).sqrt())),
    }
}

/// The bits of a number. All NaNs become the canonical one: quiet, positive, without payload.
fn code<S: Semantics>(number: IeeeFloat<S>) -> u64 {
    if !number.is_nan() {
        return number.to_bits() as u64;
    }
    let fraction = S::BITS - S::EXP_BITS - 1;
    ((1 << S::EXP_BITS) - 1) << fraction | 1 << (fraction - 1)
}
