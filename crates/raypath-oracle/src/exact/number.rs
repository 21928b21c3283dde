//! Numbers of a format, and arithmetic that is exact before one rounding (`docs/reference/semantics.md`, "Numbers",
//! "Sums that round once", "Boxes in fewer bits" and "Exception flags"; `docs/reference/formats.md`).

use super::mistake::Mistake;
use raypath_float::Format;
use std::cell::Cell;
use std::cmp::Ordering;

/// A value of IEEE 754. A NaN has neither sign nor payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Number {
    #[default]
    Nan,
    /// Whether the sign is minus, and the magnitude.
    Signed(bool, Magnitude),
}

/// A magnitude. The order of the variants and fields is that of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Magnitude {
    Zero,
    /// `digits` · 2^(`exponent` − 63), where bit 63 of the digits is set, and the lowest 11 are not.
    Finite {
        exponent: i32,
        digits: u64,
    },
    Infinite,
}

use Magnitude::{Finite, Infinite, Zero};
use Number::{Nan, Signed};

impl Magnitude {
    /// `units` · 2^`place`, which has at most 53 bits.
    fn of(units: u128, place: i32) -> Self {
        match units.checked_ilog2() {
            None => Zero,
            Some(top) => Finite { exponent: place + top as i32, digits: (units << (127 - top) >> 64) as u64 },
        }
    }

    /// The finite magnitude as an integer of 53 bits and the exponent of its last place.
    fn units(self) -> (i128, i32) {
        match self {
            Finite { exponent, digits } => (i128::from(digits >> 11), exponent - 52),
            Zero | Infinite => (0, 0),
        }
    }
}

impl Number {
    pub const ZERO: Self = Signed(false, Zero);
    pub const INFINITY: Self = Signed(false, Infinite);

    pub fn is_nan(self) -> bool {
        self == Nan
    }

    /// Whether the sign is minus, also of −0.
    pub fn is_negative(self) -> bool {
        matches!(self, Signed(true, _))
    }

    pub fn negated(self) -> Self {
        match self {
            Nan => Nan,
            Signed(is_negative, magnitude) => Signed(!is_negative, magnitude),
        }
    }

    /// The order of two numbers: −0 equals +0; `None` if one is NaN.
    pub fn order(self, other: Self) -> Option<Ordering> {
        let (Signed(a, x), Signed(b, y)) = (self, other) else { return None };
        Some(match (a, b) {
            _ if x == Zero && y == Zero => Ordering::Equal,
            (false, false) => x.cmp(&y),
            (true, true) => y.cmp(&x),
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
        })
    }

    pub fn is_zero(self) -> bool {
        matches!(self, Signed(_, Zero))
    }

    /// Whether it is greater than zero; false for NaN.
    pub fn is_above_zero(self) -> bool {
        self.order(Self::ZERO).is_some_and(Ordering::is_gt)
    }

    /// Whether it is zero or greater; false for NaN.
    pub fn is_at_least_zero(self) -> bool {
        self.order(Self::ZERO).is_some_and(Ordering::is_ge)
    }

    /// Whether it is less than zero; false for NaN.
    pub fn is_below_zero(self) -> bool {
        self.order(Self::ZERO).is_some_and(Ordering::is_lt)
    }
}

/// The exceptions, as bits of the port `exception_flags_o`.
const INEXACT: u64 = 1;
const UNDERFLOW: u64 = 2;
const OVERFLOW: u64 = 4;
const INVALID: u64 = 8;

/// How a number is rounded to a multiple of a power of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    NearestEven,
    NearestTiesAway,
    TowardZero,
    AwayFromZero,
}

/// `units` without their last `dropped` bits, and whether nothing is lost.
fn rounded(units: u128, dropped: i32, way: Way) -> (u128, bool) {
    if dropped <= 0 {
        return (units << -dropped, true);
    }
    // Beyond 127 bits, all are lost, and less than a half.
    let dropped = dropped.min(127);
    let (kept, lost, half) = (units >> dropped, units & ((1 << dropped) - 1), 1 << (dropped - 1));
    let is_up = match way {
        Way::NearestEven => lost > half || lost == half && kept & 1 == 1,
        Way::NearestTiesAway => lost >= half,
        Way::TowardZero => false,
        Way::AwayFromZero => lost != 0,
    };
    (kept + u128::from(is_up), lost == 0)
}

/// The arithmetic of a format.
#[derive(Debug, Clone)]
pub struct Arithmetic {
    format: Format,
    /// The exponents of the least normal and the greatest number.
    exponents: (i32, i32),
    /// The significand's bits, hidden bit included.
    significand: i32,
    /// The exceptions of the operations so far.
    pub raised: Cell<u64>,
    /// The deliberate mistake of a negative control.
    pub mistake: Option<Mistake>,
}

impl Arithmetic {
    /// The arithmetic of this format, without a mistake.
    pub fn new(format: Format) -> Self {
        let bias = (1 << (format.exponent() - 1)) - 1;
        let significand = format.significand() as i32;
        Self { format, exponents: (1 - bias, bias), significand, raised: Cell::new(0), mistake: None }
    }

    /// Whether it makes this mistake.
    pub fn makes(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// The number with these bits in the layout of IEEE 754.
    pub fn number(&self, code: u64) -> Number {
        let fraction_bits = self.significand as u32 - 1;
        let (fraction, rest) = (code & ((1 << fraction_bits) - 1), code >> fraction_bits);
        let all_ones = (1 << self.format.exponent()) - 1;
        let (field, is_negative) = (rest & all_ones, rest >> self.format.exponent() & 1 == 1);
        let units = if field == 0 { fraction } else { fraction | 1 << fraction_bits };
        match field {
            _ if field == all_ones && fraction != 0 => Nan,
            _ if field == all_ones => Signed(is_negative, Infinite),
            _ => {
                let place = self.last_place_of_subnormals() + field.max(1) as i32 - 1;
                Signed(is_negative, Magnitude::of(units.into(), place))
            }
        }
    }

    /// The bits of a number of the format. NaN is canonical.
    pub fn code(&self, number: Number) -> u64 {
        let fraction_bits = self.significand as u32 - 1;
        let infinity = ((1 << self.format.exponent()) - 1) << fraction_bits;
        let magnitude = match number {
            Nan => infinity | 1 << (fraction_bits - 1),
            Signed(_, Zero) => 0,
            Signed(_, Infinite) => infinity,
            Signed(_, Finite { exponent, digits }) => {
                let place = self.last_place(exponent, self.significand);
                // The hidden bit adds one to the exponent field, which is 0 for subnormal numbers.
                let field = (place - self.last_place_of_subnormals()) as u64;
                (field << fraction_bits) + (digits >> (63 - (exponent - place)))
            }
        };
        magnitude | u64::from(number.is_negative()) << (self.format.ieee_width() - 1)
    }

    /// The last place of numbers of this exponent with a significand of `bits` bits. Subnormal numbers have that of the
    /// least normal number.
    fn last_place(&self, exponent: i32, bits: i32) -> i32 {
        exponent.max(self.exponents.0) - bits + 1
    }

    fn last_place_of_subnormals(&self) -> i32 {
        self.last_place(self.exponents.0, self.significand)
    }

    /// The number of the format nearest to `units` · 2^`place`, ties to even. A zero is +0.
    fn nearest(&self, units: i128, place: i32) -> Number {
        let (is_negative, units) = (units < 0, units.unsigned_abs());
        let Finite { exponent, .. } = Magnitude::of(units, place) else { return Number::ZERO };
        let last = self.last_place(exponent, self.significand) + i32::from(self.makes(Mistake::ShortSignificand));
        let way = if self.makes(Mistake::TiesAway) { Way::NearestTiesAway } else { Way::NearestEven };
        let is_tiny = exponent < self.exponents.0;
        let (kept, is_exact) = rounded(units, last - place, way);
        if !is_exact {
            self.raise(if is_tiny { INEXACT | UNDERFLOW } else { INEXACT });
        }
        match Magnitude::of(kept, last) {
            _ if is_tiny && self.makes(Mistake::FlushedSubnormals) => Signed(is_negative, Zero),
            Finite { exponent, .. } if exponent > self.exponents.1 => {
                self.raise(OVERFLOW | INEXACT);
                Signed(is_negative, Infinite)
            }
            magnitude => Signed(is_negative, magnitude),
        }
    }

    fn raise(&self, exceptions: u64) {
        let is_dropped = self.makes(Mistake::NoUnderflow) && exceptions & UNDERFLOW != 0;
        self.raised.set(self.raised.get() | if is_dropped { exceptions & !UNDERFLOW } else { exceptions });
    }

    fn invalid(&self) -> Number {
        self.raise(INVALID);
        Nan
    }

    /// The sum, rounded.
    pub fn add(&self, a: Number, b: Number) -> Number {
        /// More places than decide a rounding: a term below them counts as one unit.
        const FAR: i32 = 60;
        let (Signed(minus_a, x), Signed(minus_b, y)) = (a, b) else { return Nan };
        match (x, y) {
            (Infinite, Infinite) if minus_a != minus_b => self.invalid(),
            (Infinite, _) => a,
            (_, Infinite) => b,
            (Zero, Zero) => Signed(minus_a && minus_b, Zero),
            (Zero, _) => b,
            (_, Zero) => a,
            _ if x < y => self.add(b, a),
            _ => {
                let ((greater, place), (less, last)) = (x.units(), y.units());
                let (greater, less, last) = match place - last {
                    gap @ ..=FAR => (greater << gap, less, last),
                    _ => (greater << FAR, 1, place - FAR),
                };
                let less = if minus_a == minus_b { less } else { -less };
                self.nearest(if minus_a { -(greater + less) } else { greater + less }, last)
            }
        }
    }

    /// The difference, rounded.
    pub fn sub(&self, a: Number, b: Number) -> Number {
        self.add(a, b.negated())
    }

    /// The product, rounded.
    pub fn mul(&self, a: Number, b: Number) -> Number {
        let (Signed(minus_a, x), Signed(minus_b, y)) = (a, b) else { return Nan };
        let is_negative = minus_a != minus_b;
        match (x, y) {
            (Infinite, Zero) | (Zero, Infinite) => self.invalid(),
            (Infinite, _) | (_, Infinite) => Signed(is_negative, Infinite),
            (Zero, _) | (_, Zero) => Signed(is_negative, Zero),
            _ => {
                let ((x, place), (y, other)) = (x.units(), y.units());
                self.nearest(if is_negative { -(x * y) } else { x * y }, place + other)
            }
        }
    }

    /// The sum of the products of coordinates, from left to right.
    pub fn dot(&self, a: [Number; 3], b: [Number; 3]) -> Number {
        let [x, y, z] = std::array::from_fn(|axis| self.mul(a[axis], b[axis]));
        self.add(self.add(x, y), z)
    }

    /// a · b − c · d.
    pub fn cross(&self, [a, b]: [Number; 2], [c, d]: [Number; 2]) -> Number {
        self.sub(self.mul(a, b), self.mul(c, d))
    }

    /// A small integer, converted without exceptions.
    pub fn integer(&self, value: u64) -> Number {
        let before = self.raised.get();
        let number = self.nearest(value.into(), 0);
        self.raised.set(before);
        number
    }

    /// Whether a product is not 0, and its magnitude is below the normal range before rounding.
    pub fn is_product_tiny(&self, [a, b]: [Number; 2]) -> bool {
        let (Signed(_, Finite { exponent: a, digits: p }), Signed(_, Finite { exponent: b, digits: q })) = (a, b)
        else {
            return false;
        };
        let carries = u128::from(p) * u128::from(q) >= 1 << 127;
        a + b + i32::from(carries) < self.exponents.0
    }

    /// The order of two exact products of finite numbers.
    pub fn order_of_products(products: [[Number; 2]; 2]) -> Ordering {
        // The sign as an order to zero, the exponent of the highest bit, and the digits from it on.
        let [a, b] = products.map(|factors| match factors {
            [Signed(a, Finite { exponent: e, digits: p }), Signed(b, Finite { exponent: f, digits: q })] => {
                let digits = u128::from(p) * u128::from(q);
                let up = digits.leading_zeros();
                let sign = if a == b { Ordering::Greater } else { Ordering::Less };
                (sign, (e + f - up as i32, digits << up))
            }
            _ => (Ordering::Equal, (0, 0)),
        });
        let magnitudes = if a.0 == Ordering::Less { b.1.cmp(&a.1) } else { a.1.cmp(&b.1) };
        a.0.cmp(&b.0).then(magnitudes)
    }

    /// This many units in the last place of 1.
    pub fn ulps(&self, ulps: u64) -> Number {
        Signed(false, Magnitude::of(ulps.into(), 1 - self.significand))
    }

    /// The sum of the terms, truncated to a window and rounded once.
    pub fn sum(&self, terms: &[Number]) -> Number {
        match terms {
            [] => return Number::ZERO,
            [term] => return *term,
            [a, b] => return self.add(*a, *b),
            _ => {}
        }
        let infinite = |is_negative: bool| terms.contains(&Signed(is_negative, Infinite));
        let greatest = terms.iter().filter_map(|term| match term {
            Signed(_, Finite { exponent, .. }) => Some(*exponent),
            _ => None,
        });
        match (infinite(false), infinite(true), greatest.max()) {
            _ if terms.contains(&Nan) => Nan,
            (true, true, _) => Nan,
            (false, false, Some(greatest)) => {
                let log = terms.len().next_power_of_two().ilog2() as i32;
                let window = self.significand + if self.makes(Mistake::ShortWindow) { 0 } else { log };
                let last = greatest - window + 1;
                let truncated = |term: &Number| {
                    let Signed(is_negative, magnitude) = term else { return 0 };
                    let (units, place) = magnitude.units();
                    let kept = rounded(units.unsigned_abs(), last - place, Way::TowardZero).0 as i128;
                    if *is_negative { -kept } else { kept }
                };
                self.nearest(terms.iter().map(truncated).sum(), last)
            }
            (false, false, None) => Signed(terms.iter().all(|term| term.is_negative()), Zero),
            (_, is_negative, _) => Signed(is_negative, Infinite),
        }
    }

    /// The number rounded to `bits` bits, after its magnitude is moved by `margin` numbers of the format the same way.
    pub fn narrow(&self, number: Number, bits: u32, way: Way, margin: u64) -> Number {
        let Signed(is_negative, Finite { .. }) = number else { return number };
        // Neighbours have neighbouring codes.
        let code = self.code(if is_negative { number.negated() } else { number });
        let margin = if self.makes(Mistake::NoMargin) { 0 } else { margin };
        let moved = if way == Way::TowardZero { code.saturating_sub(margin) } else { code + margin };
        let moved = self.number(moved.min(self.code(Number::INFINITY)));
        let Signed(_, magnitude @ Finite { exponent, .. }) = moved else {
            return if is_negative { moved.negated() } else { moved };
        };
        let ((units, place), last) = (magnitude.units(), self.last_place(exponent, bits as i32));
        let (least, greatest) = self.exponents;
        Signed(
            is_negative,
            match Magnitude::of(rounded(units.unsigned_abs(), last - place, way).0, last) {
                Finite { exponent, .. } if exponent <= least => Zero,
                Finite { exponent, .. } if exponent > greatest => Infinite,
                magnitude => magnitude,
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{Arithmetic, INEXACT, INVALID, Number, OVERFLOW, Way};
    use num_rational::BigRational;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    use raypath_float::Format;

    /// The value of a code, infinities as the number after the greatest.
    fn value(format: Format, code: u64) -> BigRational {
        let fraction_bits = format.fraction_width();
        let (magnitude, sign) = (code & !(1 << (format.ieee_width() - 1)), code >> (format.ieee_width() - 1));
        let (field, fraction) = ((magnitude >> fraction_bits) as i32, magnitude & ((1 << fraction_bits) - 1));
        let units = fraction | if field == 0 { 0 } else { 1 << fraction_bits };
        let place = field.max(1) - ((1 << (format.exponent() - 1)) - 1) - fraction_bits as i32;
        let power = BigRational::from_integer(2.into()).pow(place);
        BigRational::from_integer((units as i64 * if sign == 1 { -1 } else { 1 }).into()) * power
    }

    /// Sums and products are the nearest numbers, ties to even, by the rational numbers of another crate.
    #[test]
    fn results_are_the_nearest_numbers() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for name in ["e3s3", "fp16", "bf16", "fp32", "e11s24"] {
            let format: Format = name.parse().expect("a format");
            let (arithmetic, sign) = (Arithmetic::new(format), 1 << (format.ieee_width() - 1));
            for round in 0..4000 {
                let mut draw = || loop {
                    let near = rng.random_range(0..1_u64 << format.ieee_width());
                    let code = if round % 2 == 0 { near } else { near % (4 << format.fraction_width()) };
                    if code & !sign < format.infinity() {
                        return code;
                    }
                };
                let (a, b) = (draw(), draw());
                let (x, y) = (arithmetic.number(a), arithmetic.number(b));
                assert_eq!([x, y].map(|number| arithmetic.code(number)), [a, b]);
                let exact = [value(format, a) + value(format, b), value(format, a) * value(format, b)];
                for (is_product, exact) in exact.into_iter().enumerate() {
                    arithmetic.raised.set(0);
                    let found = if is_product == 1 { arithmetic.mul(x, y) } else { arithmetic.add(x, y) };
                    let code = arithmetic.code(found);
                    let distance = |code| {
                        let off = value(format, code) - &exact;
                        off.clone().max(-off)
                    };
                    let (magnitude, minus) = (code & !sign, code & sign);
                    let is_exact = distance(code) == BigRational::default() && magnitude != format.infinity();
                    assert_eq!(is_exact, arithmetic.raised.get() == 0, "{name}: {a:x} {b:x}");
                    for other in [magnitude + 1, magnitude.saturating_sub(1)].map(|other| other | minus) {
                        let is_nearer = distance(code) < distance(other);
                        let is_even = distance(code) == distance(other) && code % 2 == 0;
                        let is_beyond = magnitude == format.infinity() && other > code;
                        assert!(is_nearer || is_even || is_beyond || magnitude == 0, "{name}: {a:x} {b:x} {code:x}");
                    }
                    let is_zero = exact == BigRational::default();
                    assert!(is_zero || (exact < BigRational::default()) == (minus != 0), "{name}: {a:x} {b:x}");
                }
            }
        }
    }

    #[test]
    fn sums_and_narrowing_by_hand() {
        let arithmetic = Arithmetic::new(Format::BINARY32);
        let of = |number: f32| arithmetic.number(number.to_bits().into());
        let back = |number| f32::from_bits(arithmetic.code(number) as u32);
        // Alone, each small term is half a unit, and is lost.
        assert_eq!(back(arithmetic.sum(&[16_777_216.0, 1.0, 1.0].map(of))), 16_777_218.0);
        // A term below the window of 24 + 2 bits is lost.
        assert_eq!(back(arithmetic.sum(&[16_777_216.0, 1.0, 0.125].map(of))), 16_777_216.0);
        assert_eq!(back(arithmetic.sum(&[f32::INFINITY, 1.0, f32::MAX].map(of))), f32::INFINITY);
        assert!(arithmetic.sum(&[f32::INFINITY, 1.0, f32::NEG_INFINITY].map(of)).is_nan());
        assert_eq!(back(arithmetic.narrow(of(-1.01), 8, Way::AwayFromZero, 0)), -1.015_625);
        assert_eq!(back(arithmetic.narrow(of(1.01), 8, Way::TowardZero, 0)), 1.007_812_5);
        assert_eq!(back(arithmetic.narrow(of(1.0), 24, Way::AwayFromZero, 4)), 1.000_000_5);
        assert_eq!(back(arithmetic.narrow(of(f32::MAX), 8, Way::AwayFromZero, 0)), f32::INFINITY);
        arithmetic.raised.set(0);
        assert_eq!(arithmetic.mul(of(f32::MAX), of(2.0)), Number::INFINITY);
        assert_eq!(arithmetic.raised.get(), OVERFLOW | INEXACT);
        assert!(arithmetic.mul(of(0.0), Number::INFINITY).is_nan());
        assert_eq!(arithmetic.raised.get(), OVERFLOW | INEXACT | INVALID);
    }
}
