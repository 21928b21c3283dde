//! Small formats: every pair of operands. The oracle lists all numbers of a format by IEEE 754's definition, computes
//! in `f64`, which is exact for sums and products and too fine to move a quotient or root to a midpoint, and rounds by
//! searching the interval between midpoints that contains the result.

use raypath_float::Format;

#[test]
fn every_pair() {
    for (e, s) in [(3, 3), (3, 4), (3, 5), (4, 4), (5, 3)] {
        let numbers = Numbers::of(e, s);
        let format = numbers.format;
        for a in numbers.codes() {
            for b in numbers.codes() {
                let (x, y) = (numbers.number(a), numbers.number(b));
                let operands = || format!("{format}: {a:#x} ({x}), {b:#x} ({y})");
                assert_eq!(format.add(a, b), numbers.nearest(x + y), "sum of {}", operands());
                assert_eq!(format.sub(a, b), numbers.nearest(x - y), "difference of {}", operands());
                assert_eq!(format.mul(a, b), numbers.nearest(x * y), "product of {}", operands());
                assert_eq!(format.div(a, b), numbers.nearest(x / y), "quotient of {}", operands());
                assert_eq!(format.compare(a, b), x.partial_cmp(&y), "order of {}", operands());
            }
        }
    }
}

#[test]
fn every_number() {
    for (e, s) in [(3, 3), (3, 5), (4, 7), (5, 3), (5, 11), (8, 8)] {
        let numbers = Numbers::of(e, s);
        let format = numbers.format;
        for code in numbers.codes() {
            let x = numbers.number(code);
            let canonical = numbers.nearest(x);
            assert!(format.to_f64(code).to_bits() == x.to_bits() || x.is_nan() && format.to_f64(code).is_nan());
            assert_eq!((format.canonical(code), format.from_f64(x)), (canonical, canonical), "{format}: {code:#x}");
            assert_eq!(format.neg(code), numbers.nearest(-x), "{format}: {code:#x}");
            assert_eq!(format.sqrt(code), numbers.nearest(x.sqrt()), "{format}: square root of {code:#x}");
            assert_eq!((format.is_nan(code), format.is_zero(code)), (x.is_nan(), x == 0.0), "{format}: {code:#x}");
        }
    }
}

/// Numbers at, just below and just above every midpoint, and far beyond both ends.
#[test]
fn conversions_round_to_the_nearest() {
    for (e, s) in [(3, 3), (3, 5), (4, 7), (5, 3), (5, 11), (8, 8)] {
        let numbers = Numbers::of(e, s);
        let far = [f64::MIN_POSITIVE, f64::from_bits(1), 1e-300, 1e300, f64::MAX];
        let about = |x: &f64| [x.next_down(), *x, x.next_up()];
        for number in numbers.midpoints.iter().flat_map(about).chain(far).flat_map(|x| [x, -x]) {
            assert_eq!(numbers.format.from_f64(number), numbers.nearest(number), "{}: {number:e}", numbers.format);
            let single = number as f32;
            assert_eq!(
                numbers.format.from_f32(single),
                numbers.nearest(single.into()),
                "{}: {single:e}",
                numbers.format
            );
        }
    }
}

/// The ulp between any two neighbours, and beyond the largest number as if it had a neighbour.
#[test]
fn an_ulp_is_the_distance_between_neighbours() {
    for (e, s) in [(3, 3), (3, 5), (4, 7), (5, 3), (5, 11), (8, 8)] {
        let numbers = Numbers::of(e, s);
        for (i, (x, midpoint)) in numbers.magnitudes.iter().zip(&numbers.midpoints).enumerate() {
            let distance = 2.0 * (midpoint - x);
            for number in [*x, *midpoint, (x + distance).next_down()].into_iter().flat_map(|x| [x, -x]) {
                assert_eq!(numbers.format.ulp(number), distance, "{}: {number:e} after code {i}", numbers.format);
            }
        }
    }
    let widest = Format::new(11, 24).expect("a format");
    assert_eq!((widest.ulp(0.0), widest.ulp(f64::from_bits(1))), (widest.to_f64(1), widest.to_f64(1)));
    assert_eq!((widest.ulp(1.0), Format::BINARY16.ulp(1e300)), (2.0_f64.powi(-23), 2.0_f64.powi(996 - 10)));
}

/// All magnitudes of a format, and the midpoints between them.
struct Numbers {
    format: Format,
    /// In order; the index of a magnitude is its code.
    magnitudes: Vec<f64>,
    /// The i-th is between the i-th and the next magnitude; the last is between the largest number and the next number
    /// of a format without a largest number.
    midpoints: Vec<f64>,
}

impl Numbers {
    fn of(e: i32, s: i32) -> Self {
        let format = Format::new(e as u32, s as u32).expect("a format of the test's choosing");
        let bias = 2_i32.pow(e as u32 - 1) - 1;
        let fractions = 2_i32.pow(s as u32 - 1);
        let fraction = |f: i32| f64::from(f) / f64::from(fractions);
        let subnormals = (0..fractions).map(|f| fraction(f) * 2_f64.powi(1 - bias));
        let normals = (1 - bias..=bias).flat_map(|x| (0..fractions).map(move |f| (1.0 + fraction(f)) * 2_f64.powi(x)));
        let magnitudes: Vec<f64> = subnormals.chain(normals).collect();
        let beyond = 2_f64.powi(bias + 1);
        let next = magnitudes[1..].iter().chain([&beyond]);
        let midpoints = magnitudes.iter().zip(next).map(|(x, y)| (x + y) / 2.0).collect();
        Self { format, magnitudes, midpoints }
    }

    fn codes(&self) -> std::ops::Range<u64> {
        0..1 << self.format.ieee_width()
    }

    /// The number of a code.
    fn number(&self, code: u64) -> f64 {
        let sign_bit = 1 << (self.format.ieee_width() - 1);
        let magnitude = match (code & (sign_bit - 1)) as usize {
            finite if finite < self.magnitudes.len() => self.magnitudes[finite],
            infinity if infinity == self.magnitudes.len() => f64::INFINITY,
            _ => return f64::NAN,
        };
        if code & sign_bit == 0 { magnitude } else { -magnitude }
    }

    /// The code nearest to a number; the even one of two equally near codes.
    fn nearest(&self, number: f64) -> u64 {
        let infinity = self.magnitudes.len();
        if number.is_nan() {
            return infinity as u64 + (1 << (self.format.significand() - 2));
        }
        let below = self.midpoints.partition_point(|&midpoint| midpoint < number.abs());
        let tie = self.midpoints.get(below) == Some(&number.abs());
        let code = if tie && below % 2 == 1 { below + 1 } else { below };
        code as u64 | u64::from(number.is_sign_negative()) << (self.format.ieee_width() - 1)
    }
}
