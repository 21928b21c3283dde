//! Rounding to shorter significands: the software of the models, against the units, which `unit-proofs` proves.

use crate::units::converter;
use raypath_float::{Format, Narrow, mul_narrow, narrow};
use raypath_verify_arithmetic::units::operands::{for_products, generator};

#[test]
fn software_rounds_as_the_units_do() {
    for (e, s) in [(3, 3), (3, 5), (4, 5), (5, 4), (5, 8), (6, 9)] {
        let format = Format::new(e, s).expect("a format");
        for bits in 3..=s {
            for (margin, away) in [0, 1, 4].into_iter().flat_map(|margin| [(margin, false), (margin, true)]) {
                let to = Narrow { bits, away, margin };
                let mut unit = converter(narrow(format, to));
                for code in 0..1 << format.ieee_width() {
                    let found = match away {
                        true => format.narrow_away_from_zero(code, bits, margin),
                        false => format.narrow_toward_zero(code, bits, margin),
                    };
                    let word = unit.evaluate([format.encode(code)])[0];
                    assert_eq!(found, format.decode(word << (s - bits)), "{format}, {to}: {code:#x}");
                }
            }
        }
    }
}

/// In binary32, where `unit-proofs` has no proof: the product is rounded to nearest, and then in the direction.
#[test]
fn products_of_binary32() {
    let (format, mut random) = (Format::BINARY32, generator(1));
    for (bits, away) in [(8, true), (8, false), (13, true), (13, false), (24, true), (24, false)] {
        let to = Narrow { bits, away, margin: 0 };
        let mut unit = converter(mul_narrow(format, bits, to));
        for _ in 0..20_000 {
            let (a, b) = for_products(&mut random);
            let [a, b] = [a, b].map(|code| u64::from(code) >> (24 - bits) << (24 - bits));
            let product = format.mul(a, b);
            let wanted = match away {
                true => format.narrow_away_from_zero(product, bits, 0),
                false => format.narrow_toward_zero(product, bits, 0),
            };
            let word = unit.evaluate([a, b].map(|code| format.encode(code) >> (24 - bits)))[0];
            assert_eq!(format.decode(word << (24 - bits)), wanted, "{to}: {a:#x} times {b:#x}");
        }
    }
}

#[test]
fn significands_that_a_format_does_not_have_are_refused() {
    let format = Format::BINARY16;
    for bits in [2, 12] {
        let to = Narrow { bits, away: true, margin: 0 };
        for error in [narrow(format, to).err(), mul_narrow(format, 11, to).err()] {
            let said = error.expect("refused").to_string();
            assert!(said.contains(&format!("{bits} bits, expected 3 to 11")), "{said}");
        }
    }
}
