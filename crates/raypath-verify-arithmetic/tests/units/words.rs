//! Conversion of words to numbers: every word of every width that a format supports.

use crate::units::converter;
use raypath_float::{Format, number};

#[test]
fn every_word() {
    for (e, s) in [(3, 3), (3, 4), (4, 5), (4, 7), (5, 3), (5, 11), (6, 4), (8, 8), (8, 11), (8, 24), (11, 20)] {
        let format = Format::new(e, s).expect("a format");
        for width in 1..=s.min(1 << (e - 1)).min(16) {
            let mut unit = converter(number(format, width));
            for word in 0..1_u64 << width {
                let code = format.from_f64(word as f64);
                assert_eq!(format.to_f64(code), word as f64, "{format} has {word}");
                assert_eq!(unit.run([word]), [format.encode(code)], "{format}, {width} bits: {word}");
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
