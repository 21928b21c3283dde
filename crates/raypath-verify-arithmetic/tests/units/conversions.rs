//! Conversions: numbers to recoded words, by the table of `docs/reference/formats.md`; words to numbers.

use crate::units::converter;
use raypath_float::{Format, encode, number};
use raypath_verify_arithmetic::units::operands::{edges_of_conversions, for_conversions, generator};

/// `unit-proofs` shows that the decoder inverts the encoder for all numbers of binary32, and that words are canonical.
#[test]
fn binary32() {
    let (format, mut random) = (Format::BINARY32, generator(4));
    let mut encoder = converter(encode(format));
    for code in edges_of_conversions().chain((0..200_000).map(|_| for_conversions(&mut random))) {
        let word = encoder.evaluate([code.into()])[0];
        assert_eq!(word, by_the_table(code), "encoding {code:#010x}");
        assert_eq!(format.encode(code.into()), word, "encoding {code:#010x} in software");
    }
}

/// A number's recoded word. Its exponent and fraction are those of the number in binary64, in which no number of
/// binary32 is subnormal; the host converts it.
fn by_the_table(code: u32) -> u64 {
    let number = f32::from_bits(code);
    let sign = u64::from(number.is_sign_negative()) << 32;
    let double = f64::from(number.abs()).to_bits();
    let (exponent, fraction) = ((double >> 52) as i64 - 1023, double >> 29 & 0x7f_ffff);
    match number.classify() {
        std::num::FpCategory::Nan => 0x1c0 << 23 | 1 << 22,
        std::num::FpCategory::Infinite => sign | 0x180 << 23,
        std::num::FpCategory::Zero => sign,
        _ => sign | ((exponent + 256) as u64) << 23 | fraction,
    }
}

#[test]
fn every_word() {
    for (e, s) in [(3, 3), (3, 4), (4, 5), (4, 7), (5, 3), (5, 11), (6, 4), (8, 8), (8, 11), (8, 24), (11, 20)] {
        let format = Format::new(e, s).expect("a format");
        for width in 1..=s.min(1 << (e - 1)).min(16) {
            let mut unit = converter(number(format, width));
            for word in 0..1_u64 << width {
                let code = format.from_f64(word as f64);
                assert_eq!(format.to_f64(code), word as f64, "{format} has {word}");
                assert_eq!(unit.evaluate([word]), [format.encode(code)], "{format}, {width} bits: {word}");
            }
        }
    }
}

#[test]
fn words_that_a_format_does_not_have_are_refused() {
    for (e, s, width) in [(8, 24, 0), (8, 24, 17), (8, 8, 9), (3, 5, 5), (5, 3, 8)] {
        let error = number(Format::new(e, s).expect("a format"), width).expect_err("too wide");
        let said = error.to_string();
        assert!(said.contains("word_i") && said.contains(&format!("has {width} bits")), "{said}");
    }
}
