//! Rounding to shorter significands: the software of the models, against the units, which `unit-proofs` proves.

use crate::units::converter;
use raypath_float::{Format, Narrow, mul_narrow_parts, narrow};

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
                    let [word] = unit.run([format.encode(code)]);
                    assert_eq!(found, format.decode(word << (s - bits)), "{format}, {to}: {code:#x}");
                }
            }
        }
    }
}

#[test]
fn significands_that_a_format_does_not_have_are_refused() {
    let format = Format::BINARY16;
    for bits in [2, 12] {
        let to = Narrow { bits, away: true, margin: 0 };
        for error in [narrow(format, to).err(), mul_narrow_parts(format, 11, to, 1).err()] {
            let said = error.expect("refused").to_string();
            assert!(said.contains(&format!("{bits} bits, expected 3 to 11")), "{said}");
        }
    }
}
