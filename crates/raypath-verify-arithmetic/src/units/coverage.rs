//! Coverage of the operands of binary32 units, by the models of IBM's "Floating-Point Test-Suite for IEEE" (IBM Labs in
//! Haifa, FPgen team; the repository `cover-float` lists them) that concern addition, multiplication and comparison
//! with rounding to nearest.
//!
//! Left out are the models of other operations (fused products, division, roots, conversions: B14 to B18, B20 to B29),
//! and B2, B11 and B13, whose operands are near to those of B1, B9 and B5.

use raypath_verify::dyadic::{Dyadic, Rounding};
use std::collections::{BTreeMap, BTreeSet};

/// An operation of the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operation {
    /// `a + b`.
    Addition,
    /// `a - b`.
    Subtraction,
    /// `a * b`.
    Multiplication,
    /// The order of `a` and `b`.
    Comparison,
}

use Operation::{Addition, Comparison, Multiplication, Subtraction};

/// All operations.
pub const OPERATIONS: [Operation; 4] = [Addition, Subtraction, Multiplication, Comparison];

/// The models that are counted, each with its operations.
const MODELS: [(&str, &[Operation]); 11] = [
    ("B1", &OPERATIONS),
    ("B3", &[Addition, Subtraction, Multiplication]),
    ("B4", &[Addition, Subtraction, Multiplication]),
    ("B5", &[Addition, Subtraction, Multiplication]),
    ("B6", &[Multiplication]),
    ("B7", &[Multiplication]),
    ("B8", &[Addition, Subtraction, Multiplication]),
    ("B9", &[Multiplication]),
    ("B10", &[Addition, Subtraction]),
    ("B12", &[Addition, Subtraction]),
    ("B19", &[Comparison]),
];

/// A coverage point: the position of the model in the list above, the operation, and the case in the model.
type Point = (usize, Operation, u32);

/// The points that cases have hit.
#[derive(Debug, Default)]
pub struct Covered {
    points: BTreeSet<(usize, usize, u32)>,
}

const SIGNIFICAND: i32 = 24;
const LEAST_EXPONENT: i32 = -126;
const GREATEST_EXPONENT: i32 = 127;
/// The codes of the least normal number, the largest number, and 1.
const LEAST_NORMAL: u32 = 0x0080_0000;
const LARGEST: u32 = 0x7f7f_ffff;
const ONE: u32 = 0x3f80_0000;

impl Covered {
    /// Counts a pair of operands for all operations.
    pub fn add(&mut self, a: u32, b: u32) {
        for (index, operation) in OPERATIONS.into_iter().enumerate() {
            for (model, case) in cases(operation, a, b) {
                self.points.insert((model, index, case));
            }
        }
    }

    /// The number of points that can be hit, and a line for each model with points that are not.
    pub fn missing(&self) -> (usize, Vec<String>) {
        let mut missing: BTreeMap<(&str, Operation), Vec<u32>> = BTreeMap::new();
        let all = reachable();
        for &(model, operation, case) in &all {
            let index = OPERATIONS.iter().position(|known| *known == operation).unwrap_or_default();
            if !self.points.contains(&(model, index, case)) {
                missing.entry((MODELS[model].0, operation)).or_default().push(case);
            }
        }
        let line = |((model, operation), cases): (&(&str, Operation), &Vec<u32>)| {
            let shown: Vec<String> = cases.iter().take(8).map(u32::to_string).collect();
            format!("{model}, {operation:?}: {} cases without operands: {} …", cases.len(), shown.join(", "))
        };
        (all.len(), missing.iter().map(line).collect())
    }
}

/// The number of basic types of an operand, with sign.
const TYPES: u32 = 24;

/// The basic type of a word: zero, least subnormal, subnormal, largest subnormal, least normal, normal, largest, one,
/// infinity, canonical NaN, other quiet NaN, signalling NaN; 12 more with a minus sign.
fn basic_type(word: u32) -> u32 {
    let magnitude = word & 0x7fff_ffff;
    let kind = match magnitude {
        0 => 0,
        1 => 1,
        LEAST_NORMAL => 4,
        ONE => 7,
        LARGEST => 6,
        0x7f80_0000 => 8,
        0x7fc0_0000 => 9,
        _ if magnitude == LEAST_NORMAL - 1 => 3,
        _ if magnitude < LEAST_NORMAL => 2,
        _ if magnitude < LARGEST => 5,
        _ if magnitude > 0x7fc0_0000 => 10,
        _ => 11,
    };
    kind + 12 * (word >> 31)
}

fn value(word: u32) -> Option<Dyadic> {
    let number = f32::from_bits(word);
    (number.is_finite() && number != 0.0).then(|| Dyadic::from(number))
}

/// The cases that a pair of operands hits, each with the position of its model.
fn cases(operation: Operation, a: u32, b: u32) -> Vec<(usize, u32)> {
    let mut cases = Vec::new();
    let mut hit = |model: &str, case: u32| {
        let known = MODELS.iter().position(|(name, operations)| *name == model && operations.contains(&operation));
        cases.extend(known.map(|index| (index, case)));
    };
    hit("B1", TYPES * basic_type(a) + basic_type(b));
    if operation == Comparison {
        let part = |word: u32| [(word >> 23) & 0xff, word & 0x007f_ffff];
        let relation = |i: usize| part(a)[i].cmp(&part(b)[i]) as i32 + 1;
        let signs = 2 * (a >> 31) + (b >> 31);
        hit("B19", 9 * signs + 3 * relation(0) as u32 + relation(1) as u32);
        return cases;
    }
    let (Some(x), Some(y)) = (value(a), value(b)) else { return cases };
    let y = if operation == Subtraction { -y } else { y };
    let exact = if operation == Multiplication { &x * &y } else { &x + &y };
    if operation == Multiplication {
        significands(a).into_iter().for_each(|case| hit("B9", case));
        significands(b).into_iter().for_each(|case| hit("B9", NAMED_SIGNIFICANDS + case));
    } else {
        let difference = (x.exponent() - y.exponent()).clamp(-SIGNIFICAND - 4, SIGNIFICAND + 4);
        hit("B10", (difference + SIGNIFICAND + 4) as u32);
        let cancelled = match exact.sign().is_eq() {
            true => 99,
            false => (x.exponent().max(y.exponent()) + 1 - exact.exponent()) as u32,
        };
        hit("B12", cancelled);
    }
    if !exact.sign().is_eq() {
        results(&exact, hit);
    }
    cases
}

/// The cases of an exact result other than zero.
fn results(exact: &Dyadic, mut hit: impl FnMut(&str, u32)) {
    let sign = u32::from(exact.sign().is_lt());
    let exponent = exact.exponent();
    // The last place of the result, and that of a result with any exponent.
    let place = exponent.max(LEAST_EXPONENT) - SIGNIFICAND + 1;
    let any_place = exponent - SIGNIFICAND + 1;
    let truncated = exact.abs().rounded_to(place, Rounding::TowardZero);
    let rest = &exact.abs() - &truncated;
    let half = Dyadic::power_of_two(place - 1);
    let units = truncated.multiples_of(place);
    if exponent >= LEAST_EXPONENT {
        let (is_half_or_more, is_more) = (rest >= half, rest != half && !rest.sign().is_eq());
        hit("B3", 8 * sign + 4 * (units & 1) as u32 + 2 * u32::from(is_half_or_more) + u32::from(is_more));
        // The lost bits: none, the last possible alone, near half from both sides, half, and all but the last.
        let last = Dyadic::power_of_two(place - SIGNIFICAND + 1);
        let whole = Dyadic::power_of_two(place);
        let near = [Dyadic::default(), last.clone(), &half - &last, half.clone(), &half + &last, &whole - &last];
        near.iter().position(|lost| *lost == rest).into_iter().for_each(|case| hit("B8", case as u32));
        let below_half = if rest >= half { &rest - &half } else { rest.clone() };
        let is_one_bit = below_half == Dyadic::power_of_two(below_half.exponent().max(-2000));
        if is_one_bit && !below_half.sign().is_eq() {
            hit("B7", (place - 1 - below_half.exponent()) as u32);
        }
    } else if exponent < LEAST_EXPONENT - SIGNIFICAND + 1 {
        // Below the least subnormal number: more than half of it, half, or less.
        let half = Dyadic::power_of_two(LEAST_EXPONENT - SIGNIFICAND);
        hit("B6", 3 * sign + (exact.abs().cmp(&half) as i32 + 1) as u32);
    }
    let rounded = exact.abs().rounded_to(any_place, Rounding::NearestEven);
    let units = |of: &Dyadic, place| of.multiples_of(place) as i64;
    if (GREATEST_EXPONENT..=GREATEST_EXPONENT + 1).contains(&rounded.exponent()) {
        // From 3 units below the largest number to 3 above, in its units.
        let largest = (1 << SIGNIFICAND) - 1;
        let distance = units(&rounded, GREATEST_EXPONENT - SIGNIFICAND + 1) - largest;
        if (-3..=3).contains(&distance) {
            hit("B4", 8 * sign + (distance + 3) as u32);
        }
    }
    if rounded.exponent() > GREATEST_EXPONENT + 1 {
        hit("B4", 8 * sign + 7);
    }
    let subnormal = exact.abs().rounded_to(LEAST_EXPONENT - SIGNIFICAND + 1, Rounding::NearestEven);
    if exponent <= LEAST_EXPONENT {
        // From zero to 3 units, and around the least normal number.
        let code = units(&subnormal, LEAST_EXPONENT - SIGNIFICAND + 1);
        let distance = code - i64::from(LEAST_NORMAL);
        if code <= 3 {
            hit("B5", 16 * sign + code as u32);
        } else if distance.abs() <= 3 {
            hit("B5", 16 * sign + (distance + 8) as u32);
        }
    }
}

/// The number of cases of [`significands`].
const NAMED_SIGNIFICANDS: u32 = 4 * 23 + 2;

/// The named significands that a number has: fractions with this many leading or trailing zeros or ones, and
/// alternating bits.
fn significands(word: u32) -> Vec<u32> {
    let fraction = word & 0x007f_ffff;
    let runs = [
        (fraction << 9).leading_zeros(),
        (fraction << 9).leading_ones(),
        fraction.trailing_zeros(),
        fraction.trailing_ones(),
    ];
    let named = (0..4).zip(runs).filter(|(_, length)| *length < 23).map(|(kind, length)| 23 * kind + length);
    let alternating = [0x0055_5555, 0x002a_aaaa].into_iter().position(|bits| bits == fraction);
    named.chain(alternating.map(|index| 4 * 23 + index as u32)).collect()
}

/// All points that a pair of operands can hit.
fn reachable() -> Vec<Point> {
    let mut points = Vec::new();
    for (model, (name, operations)) in MODELS.into_iter().enumerate() {
        for &operation in operations {
            let is_product = operation == Multiplication;
            let cases: Vec<u32> = match name {
                "B1" => (0..TYPES * TYPES).collect(),
                "B3" => (0..16).collect(),
                // Above the largest number, every second of its units is a number.
                "B4" => (0..16).filter(|case| case % 8 != 5 && (case % 8 != 7 || is_product)).collect(),
                // A sum in the subnormal range that is not zero has at least one unit.
                "B5" => (0..32).filter(|case| is_b5(case % 16) && (is_product || case % 16 != 0)).collect(),
                "B6" => (0..6).collect(),
                "B7" => (1..SIGNIFICAND as u32).collect(),
                "B8" => (0..6).collect(),
                "B9" => (0..2 * NAMED_SIGNIFICANDS).collect(),
                "B10" => (0..=2 * (SIGNIFICAND as u32 + 4)).collect(),
                "B12" => (0..=SIGNIFICAND as u32 + 1).chain([99]).collect(),
                _ => (0..36).collect(),
            };
            points.extend(cases.into_iter().map(|case| (model, operation, case)));
        }
    }
    points
}

/// Whether B5 has this case: 0 to 3 units, or −3 to 3 units from the least normal number.
fn is_b5(case: u32) -> bool {
    case <= 3 || (5..=11).contains(&case)
}

#[cfg(test)]
mod tests {
    use super::{Addition, Comparison, Covered, MODELS, Multiplication, Subtraction, cases};

    fn of(operation: super::Operation, a: f32, b: f32) -> Vec<(&'static str, u32)> {
        cases(operation, a.to_bits(), b.to_bits()).into_iter().map(|(model, case)| (MODELS[model].0, case)).collect()
    }

    #[test]
    fn cases_by_hand() {
        let tie = of(Addition, 1.0, 2_f32.powi(-24));
        for expected in [("B3", 2), ("B8", 3), ("B10", 52), ("B12", 1)] {
            assert!(tie.contains(&expected), "{tie:?}");
        }
        let cancelled = of(Subtraction, 1.0, f32::from_bits(0x3f7f_ffff));
        assert!(cancelled.contains(&("B12", 25)) && cancelled.contains(&("B10", 29)), "{cancelled:?}");
        assert!(of(Subtraction, 1.0, 1.0).contains(&("B12", 99)));
        assert!(of(Multiplication, f32::MAX, -1.0).contains(&("B4", 11)));
        assert!(of(Multiplication, f32::MAX, 4.0).contains(&("B4", 7)));
        assert!(of(Multiplication, 2_f32.powi(-100), 2_f32.powi(-50)).contains(&("B6", 1)));
        assert!(of(Addition, f32::from_bits(1), f32::from_bits(2)).contains(&("B5", 3)));
        assert!(of(Addition, f32::MIN_POSITIVE, -f32::from_bits(1)).contains(&("B5", 7)));
        assert!(of(Multiplication, 1.0 + 2_f32.powi(-23), 1.0 + 2_f32.powi(-22)).contains(&("B7", 21)));
        assert!(of(Multiplication, 1.5, 1.0).contains(&("B9", 2 * 23 + 22)));
        assert!(of(Comparison, -1.0, 2.0).contains(&("B19", 9 * 2 + 1)));
    }

    /// Operands of one shape leave points without a hit, in each model.
    #[test]
    fn operands_of_one_shape_show() {
        let mut covered = Covered::default();
        (0..1000).for_each(|index| covered.add(0x3f80_0000 + index, 0x4000_0000));
        let (total, missing) = covered.missing();
        assert!(total > 2000, "{total}");
        let is_missing = |(model, _): &(&str, _)| missing.iter().any(|line| line.starts_with(&format!("{model},")));
        assert!(MODELS.iter().all(is_missing), "{missing:?}");
    }
}
