//! Sums that round once: the units whole and in parts, and the software of the models, against exact arithmetic.

use crate::units::converter;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use raypath_float::{Format, sum};
use raypath_hdl::{Simulator, Technology, divide};
use raypath_model::{Soft, SoftNumber};
use raypath_ops::{Binary32, Circuit, Single};
use raypath_oracle::exact::Arithmetic;
use raypath_verify_arithmetic::units::bench::chain;

/// The code of a sum.
fn expected(format: Format, terms: &[u64]) -> u64 {
    let exact = Arithmetic::new(format);
    exact.code(exact.sum(&terms.iter().map(|&term| exact.number(term)).collect::<Vec<_>>()))
}

/// The unit whole, and joined from two and from three parts; and the software.
struct Sums {
    format: Format,
    units: [Simulator; 3],
}

impl Sums {
    fn new(format: Format, terms: u32) -> Self {
        let unit = |parts| {
            converter(sum(format, terms).and_then(|unit| chain(&divide(&unit, parts, Technology::Gates, 0.0)?)))
        };
        Self { format, units: [1, 2, 3].map(unit) }
    }

    fn check(&mut self, terms: &[u64]) {
        let wanted = self.format.encode(expected(self.format, terms));
        for (unit, parts) in self.units.iter_mut().zip(1..) {
            let found = unit.evaluate(terms.iter().map(|&term| self.format.encode(term)));
            assert_eq!(found, [wanted], "{} in {parts} parts: {terms:x?}", self.format);
        }
        let numbers: Vec<SoftNumber> = terms.iter().map(|&term| SoftNumber(term)).collect();
        let found = Soft { format: self.format }.sum(&numbers).0;
        assert_eq!(found, expected(self.format, terms), "{} in software: {terms:x?}", self.format);
    }
}

/// Terms of one magnitude, of all, with pairs that cancel, ties, and special ones.
fn draw(rng: &mut ChaCha8Rng, format: Format, count: usize) -> Vec<u64> {
    let fraction = format.significand() - 1;
    let fields = (1_u64 << format.exponent()) - 1;
    let special = [0, 1 << (format.ieee_width() - 1), format.infinity(), format.infinity() - 1, 1, format.nan()];
    let (base, spread) =
        (rng.random_range(0..fields), [0, 1, 3, u64::from(format.significand()), fields][rng.random_range(0..5)]);
    let [has_signs, has_special, has_pairs] = [(); 3].map(|()| rng.random_bool(0.4));
    let mut terms: Vec<u64> = (0..count)
        .map(|_| {
            if has_special && rng.random_bool(0.1) {
                let kinds = if rng.random_bool(0.2) { special.len() } else { 2 };
                return special[rng.random_range(0..kinds)];
            }
            let exponent = (base + rng.random_range(0..=spread)).min(fields - 1).saturating_sub(spread / 2);
            let mask = (1_u64 << fraction) - 1;
            let digits = [rng.random(), rng.random(), 0, mask, 1, 1 << (fraction - 1)][rng.random_range(0..6)] & mask;
            let sign = u64::from(has_signs && rng.random()) << (format.ieee_width() - 1);
            sign | exponent << fraction | digits
        })
        .collect();
    if has_pairs {
        for pair in terms.chunks_exact_mut(2) {
            let near = rng.random_range(0..3);
            let is_finite = pair[0] & !(1 << (format.ieee_width() - 1)) < format.infinity() - 3;
            if is_finite {
                pair[1] = (pair[0] ^ 1 << (format.ieee_width() - 1)) + near;
            }
        }
    }
    terms.shuffle(rng);
    terms
}

#[test]
fn many_terms() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for name in ["fp32", "fp16", "bf16", "e3s3", "e4s7", "e11s24"] {
        let format: Format = name.parse().expect("a format");
        for terms in [3, 4, 5, 7, 8, 16, 32, 33, 64] {
            let mut sums = Sums::new(format, terms);
            for _ in 0..3_000 {
                sums.check(&draw(&mut rng, format, terms as usize));
            }
        }
    }
}

/// What the window loses: of three terms, only what is below the last of the 26 places of binary32.
#[test]
fn the_window() {
    let sum = |terms: &[f32]| {
        let codes: Vec<u64> = terms.iter().map(|term| term.to_bits().into()).collect();
        Sums::new(Format::BINARY32, terms.len() as u32).check(&codes);
        Binary32.sum(&terms.iter().map(|&term| Single(term)).collect::<Vec<_>>()).0
    };
    let power = |exponent: i32| 2_f32.powi(exponent);
    // Half of the last place of 1, and the last place of the window, which decides the tie.
    assert_eq!(sum(&[1.0, power(-24), power(-25)]), 1.0 + power(-23));
    assert_eq!(sum(&[1.0, power(-24), power(-26)]), 1.0);
    // A tree of adders loses the small terms here, and the window does not.
    assert_eq!(sum(&[1.0, power(-24), power(-24)]), 1.0 + power(-23));
    assert_eq!(sum(&[power(30), -power(30), 1.0]), 0.0);
    assert_eq!(sum(&[power(25), -power(25), 1.0]), 1.0);
    // 31 terms at the last place of the window of 29 places are nearly a last place of 1; below it they vanish.
    let many = |small: f32| std::array::from_fn::<f32, 32, _>(|term| if term == 0 { 1.0 } else { small });
    assert_eq!(sum(&many(power(-28))), 1.0 + power(-23));
    assert_eq!(sum(&many(power(-27))), 1.0 + 2.0 * power(-23));
    assert_eq!(sum(&many(power(-29))), 1.0);
}
