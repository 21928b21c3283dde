//! binary32 against the host's `f32`.

use crate::format::operands::{Operands, cases};
use raypath_float::Format;
use std::collections::BTreeMap;

const FORMAT: Format = Format::BINARY32;
const CASES: u32 = 10_000_000;

#[test]
fn random_pairs() {
    let mut operands = Operands::new(FORMAT, 1);
    let mut seen = BTreeMap::new();
    for _ in 0..cases(CASES) {
        let (a, b) = operands.pair();
        check(a, b);
        let (x, y) = (f32::from_bits(a as u32), f32::from_bits(b as u32));
        count(&mut seen, "sum", x + y, f64::from(x) + f64::from(y));
        count(&mut seen, "product", x * y, f64::from(x) * f64::from(y));
        count(&mut seen, "quotient", x / y, f64::from(x) / f64::from(y));
        if x == y || x.partial_cmp(&y).is_none() {
            *seen.entry(("order", if x == y { "equal" } else { "unordered" })).or_default() += 1;
        }
    }
    // The generator must produce every kind.
    assert!(seen.len() == 17 && seen.values().all(|&count| count >= cases(CASES) / 5_000), "{seen:?}");
}

#[test]
fn every_pair_of_edges() {
    let fraction = 0x007f_ffff;
    let exponents = [0, 1, 2, 23, 24, 25, 126, 127, 128, 150, 151, 152, 230, 253, 254, 255];
    let fractions = [0, 1, 2, fraction / 2, fraction / 2 + 1, fraction / 2 + 2, fraction - 1, fraction];
    let numbers: Vec<u64> = [0, 1 << 31]
        .into_iter()
        .flat_map(|sign| exponents.map(|exponent| sign | exponent << 23))
        .flat_map(|upper| fractions.map(|fraction| upper | fraction))
        .collect();
    for &a in &numbers {
        numbers.iter().for_each(|&b| check(a, b));
    }
}

/// Bits above the width of the format are ignored in arguments and zero in results.
#[test]
fn bits_above_the_format() {
    let mut operands = Operands::new(FORMAT, 2);
    for _ in 0..cases(100_000) {
        let (a, b) = operands.pair();
        let (c, d) = (a | 0xdead_beef << 32, b | 0x1234_5678 << 32);
        assert_eq!((FORMAT.add(c, d), FORMAT.sub(c, d)), (FORMAT.add(a, b), FORMAT.sub(a, b)));
        assert_eq!((FORMAT.mul(c, d), FORMAT.neg(c)), (FORMAT.mul(a, b), FORMAT.neg(a)));
        assert_eq!((FORMAT.div(c, d), FORMAT.sqrt(c)), (FORMAT.div(a, b), FORMAT.sqrt(a)));
        assert_eq!((FORMAT.compare(c, d), FORMAT.canonical(c)), (FORMAT.compare(a, b), FORMAT.canonical(a)));
    }
}

/// Counts the kind of a result.
fn count(seen: &mut BTreeMap<(&str, &str), u32>, operation: &'static str, result: f32, exact: f64) {
    let magnitude = result.abs();
    let half_way_to = |neighbour: f32| exact.abs() == (f64::from(magnitude) + f64::from(neighbour)) / 2.0;
    let inexact = result.is_finite() && f64::from(result) != exact;
    let kinds = [
        ("zero", result == 0.0),
        ("subnormal", result.is_subnormal()),
        ("overflow", result.is_infinite() && exact.is_finite()),
        ("tie down", inexact && half_way_to(magnitude.next_up())),
        ("tie up", inexact && half_way_to(magnitude.next_down())),
    ];
    for (kind, _) in kinds.into_iter().filter(|(_, is_kind)| *is_kind) {
        *seen.entry((operation, kind)).or_default() += 1;
    }
}

fn check(a: u64, b: u64) {
    let (x, y) = (f32::from_bits(a as u32), f32::from_bits(b as u32));
    let operands = || format!("{a:08x} ({x:e}), {b:08x} ({y:e})");
    assert_eq!(FORMAT.add(a, b), code(x + y), "sum of {}", operands());
    assert_eq!(FORMAT.sub(a, b), code(x - y), "difference of {}", operands());
    assert_eq!(FORMAT.mul(a, b), code(x * y), "product of {}", operands());
    assert_eq!(FORMAT.div(a, b), code(x / y), "quotient of {}", operands());
    assert_eq!(FORMAT.sqrt(a), code(x.sqrt()), "square root: {a:08x} ({x:e})");
    assert_eq!(FORMAT.compare(a, b), x.partial_cmp(&y), "order of {}", operands());
    assert_eq!(FORMAT.neg(a), code(-x), "negated: {a:08x}");
    assert_eq!((FORMAT.is_nan(a), FORMAT.is_zero(a)), (x.is_nan(), x == 0.0), "class of {a:08x}");
    assert_eq!(FORMAT.is_sign_negative(a), x.is_sign_negative(), "sign of {a:08x}");
    assert_eq!((FORMAT.canonical(a), FORMAT.from_f32(x), FORMAT.from_f64(x.into())), (code(x), code(x), code(x)));
    assert!(FORMAT.to_f64(a).to_bits() == f64::from(x).to_bits() || x.is_nan() && FORMAT.to_f64(a).is_nan());
}

/// The bits of a number; every NaN becomes the canonical NaN.
fn code(number: f32) -> u64 {
    if number.is_nan() { 0x7fc0_0000 } else { number.to_bits().into() }
}
