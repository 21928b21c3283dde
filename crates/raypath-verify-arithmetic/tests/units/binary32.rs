//! binary32 against the host's `f32`.

use crate::units::{bench, converter};
use rand::rngs::ChaCha8Rng;
use raypath_float::{Format, decode, encode};
use raypath_verify_arithmetic::units::bench::{PortFormat, UnitResults};
use raypath_verify_arithmetic::units::operands::{
    self, CASES, RECODED_CASES, canonical, edges, generator, host_results,
};
use std::cmp::Ordering;
use std::collections::BTreeMap;

#[test]
fn operands_that_make_sums_hard() {
    expect(&check(1, operands::for_sums), "sum", &KINDS, 10_000);
}

#[test]
fn operands_that_make_products_hard() {
    expect(&check(2, operands::for_products), "product", &KINDS, 10_000);
}

#[test]
fn operands_that_make_comparisons_hard() {
    expect(&check(3, operands::for_comparisons), "relation", &["less", "equal", "greater", "unordered"], 100);
}

/// Words with the same meaning as canonical ones: zeros and infinities with any bits below the class, NaNs with any
/// sign and payload.
#[test]
fn recoded_words_that_are_not_canonical() {
    let format = Format::BINARY32;
    let mut bench = bench(format, PortFormat::Recoded);
    let mut decoder = converter(decode(format));
    let mut random = generator(5);
    let mut seen = [[0; 4]; 4];
    for _ in 0..cases(RECODED_CASES) {
        let [(a, x), (b, y)] = [(); 2].map(|_| {
            let (word, number) = operands::recoded(&mut random);
            assert_eq!(format.decode(word), canonical(number), "decoding {word:#011x}");
            assert_eq!(decoder.run([word]), [canonical(number)], "decoding {word:#011x} in hardware");
            (word, f32::from_bits(format.decode(word) as u32))
        });
        let kind = |number: f32| match number {
            number if number.is_nan() => 0,
            number if number.is_infinite() => 1,
            0.0 => 2,
            _ => 3,
        };
        seen[kind(x)][kind(y)] += 1;
        let expected = host_results(x, y);
        let [sum, difference, product] =
            [expected.sum, expected.difference, expected.product].map(|code| format.encode(code));
        let expected = UnitResults { sum, difference, product, ..expected };
        assert_eq!(bench.run(a, b), expected, "{a:#011x} ({x:e}), {b:#011x} ({y:e})");
    }
    assert!(seen.as_flattened().iter().all(|&count| count >= cases(RECODED_CASES) / 100), "{seen:?}");
}

#[test]
fn every_pair_of_edges() {
    let numbers = edges();
    let mut bench = bench(Format::BINARY32, PortFormat::Ieee);
    for &a in &numbers {
        for &b in &numbers {
            let (x, y) = (f32::from_bits(a), f32::from_bits(b));
            assert_eq!(bench.run(a.into(), b.into()), host_results(x, y), "{a:#010x} ({x:e}), {b:#010x} ({y:e})");
        }
    }
}

/// Hardware and software recode alike. `raypath verify conversions` checks that they are right for every number.
#[test]
fn conversions() {
    let format = Format::BINARY32;
    let mut encoder = converter(encode(format));
    let mut decoder = converter(decode(format));
    let mut check = |code: u32| {
        let [recoded] = encoder.run([code.into()]);
        assert_eq!(recoded, format.encode(code.into()), "encoding {code:#010x}");
        assert_eq!(decoder.run([recoded]), [canonical(f32::from_bits(code))], "decoding {code:#010x}");
    };
    operands::edges_of_conversions().for_each(&mut check);
    let mut random = generator(4);
    for _ in 0..cases(CASES) {
        check(operands::for_conversions(&mut random));
    }
}

/// The number of cases to run: a twentieth in an unoptimised build.
pub fn cases(optimised: u64) -> u64 {
    if cfg!(debug_assertions) { optimised / 20 } else { optimised }
}

/// The number of cases by operation and kind of result.
type Census = BTreeMap<(&'static str, &'static str), u64>;

/// The kinds of sums and products.
const KINDS: [&str; 6] = ["zero", "subnormal", "overflow", "nan", "tie up", "tie down"];

/// Runs the cases and counts the results by kind.
fn check(seed: u64, mut operands: impl FnMut(&mut ChaCha8Rng) -> (u32, u32)) -> Census {
    let mut bench = bench(Format::BINARY32, PortFormat::Ieee);
    let mut random = generator(seed);
    let mut census = Census::new();
    for _ in 0..cases(CASES) {
        let (a, b) = operands(&mut random);
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        assert_eq!(bench.run(a.into(), b.into()), host_results(x, y), "{a:#010x} ({x:e}), {b:#010x} ({y:e})");
        let relation = match x.partial_cmp(&y) {
            Some(Ordering::Less) => "less",
            Some(Ordering::Equal) => "equal",
            Some(Ordering::Greater) => "greater",
            None => "unordered",
        };
        *census.entry(("relation", relation)).or_default() += 1;
        let (wide_x, wide_y) = (f64::from(x), f64::from(y));
        for (operation, result, exact) in [("sum", x + y, wide_x + wide_y), ("product", x * y, wide_x * wide_y)] {
            for (kind, is_it) in KINDS.into_iter().zip(kinds(x, y, result, exact)) {
                *census.entry((operation, kind)).or_default() += u64::from(is_it);
            }
        }
    }
    census
}

/// Which of [`KINDS`] a result is.
fn kinds(x: f32, y: f32, result: f32, exact: f64) -> [bool; KINDS.len()] {
    let (below, above) = (f64::from(result.next_down()), f64::from(result.next_up()));
    let half = |neighbour: f64| exact != f64::from(result) && exact == (f64::from(result) + neighbour) / 2.0;
    let (towards_zero, away) = if result > 0.0 { (below, above) } else { (above, below) };
    [
        result == 0.0,
        result.is_subnormal(),
        result.is_infinite() && x.is_finite() && y.is_finite(),
        result.is_nan() && !x.is_nan() && !y.is_nan(),
        half(towards_zero),
        half(away),
    ]
}

/// Checks that at least one of `interval` cases is of each kind.
fn expect(census: &Census, operation: &'static str, kinds: &[&'static str], interval: u64) {
    let enough =
        |kind: &&'static str| census.get(&(operation, *kind)).is_some_and(|count| *count >= cases(CASES) / interval);
    assert!(kinds.iter().all(enough), "{census:?}");
}
