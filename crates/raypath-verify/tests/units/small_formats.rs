//! All operands of small formats, and all recoded words.

use crate::exact::{Exact, sum};
use crate::{bench, converter};
use raypath_float::{decode, encode};
use raypath_verify::units::bench::{PortFormat, UnitResults};

/// Among them: the significand at its bound for the exponent (3, 5), subnormal ranges as wide as the normal one (3, 4),
/// and widths of shifters at, above and below powers of two.
const FORMATS: [(u32, u32); 8] = [(3, 3), (3, 4), (3, 5), (4, 3), (4, 4), (4, 5), (5, 3), (5, 4)];

#[test]
fn operands_in_ieee_layout() {
    for (e, s) in FORMATS {
        let exact = Exact::new(e, s);
        let mut bench = bench(exact.format, PortFormat::Ieee);
        for a in exact.ieee_codes() {
            for b in exact.ieee_codes() {
                let (x, y) = (exact.ieee_value(a), exact.ieee_value(b));
                let expected = results(x, y, |number| exact.ieee_code(number));
                assert_eq!(bench.run(a, b), expected, "{}: {a:#x} ({x}), {b:#x} ({y})", exact.format);
            }
        }
    }
}

#[test]
fn recoded_operands_canonical_or_not() {
    for (e, s) in FORMATS {
        let exact = Exact::new(e, s);
        let words = exact.recoded_words();
        let mut bench = bench(exact.format, PortFormat::Recoded);
        for &(a, x) in &words {
            for &(b, y) in &words {
                let expected = results(x, y, |number| exact.recoded_word(exact.ieee_value(exact.ieee_code(number))));
                assert_eq!(bench.run(a, b), expected, "{}: {a:#x} ({x}), {b:#x} ({y})", exact.format);
            }
        }
    }
}

#[test]
fn conversions() {
    for (e, s) in FORMATS.into_iter().chain([(4, 7), (5, 11), (6, 4), (6, 14), (8, 8), (10, 5)]) {
        let exact = Exact::new(e, s);
        let format = exact.format;
        let mut encoder = converter(encode(format));
        for code in exact.ieee_codes() {
            let number = exact.ieee_value(code);
            let expected = exact.recoded_word(number);
            assert_eq!(encoder.run([code]), [expected], "{format}: encoding {code:#x} ({number})");
            assert_eq!(format.encode(code), expected, "{format}: encoding {code:#x} ({number}) in software");
        }
        let mut decoder = converter(decode(format));
        for (word, number) in exact.recoded_words() {
            let expected = exact.ieee_code(number);
            assert_eq!(decoder.run([word]), [expected], "{format}: decoding {word:#x} ({number})");
            assert_eq!(format.decode(word), expected, "{format}: decoding {word:#x} ({number}) in software");
        }
    }
}

/// The expected results for two numbers; `code` rounds a number to a word.
pub fn results(x: f64, y: f64, code: impl Fn(f64) -> u64) -> UnitResults {
    UnitResults {
        sum: code(sum(x, y)),
        difference: code(sum(x, -y)),
        product: code(x * y),
        less: x < y,
        equal: x == y,
        unordered: x.is_nan() || y.is_nan(),
        parts_differ: 0,
    }
}
