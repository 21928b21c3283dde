//! All operands of small formats, and all recoded words.

use crate::units::exact::Exact;
use crate::units::{bench, converter};
use raypath_float::{decode, encode};
use raypath_verify_arithmetic::units::bench::{PortFormat, UnitResults};
use raypath_verify_arithmetic::units::oracle;

type Oracle = fn(u64, u64) -> UnitResults;

/// Formats with LLVM's soft float as the oracle. Among them: the significand at its bound for the exponent (3, 5),
/// subnormal ranges as wide as the normal one (3, 4), and widths of shifters at, above and below powers of two.
const FORMATS: [(u32, u32, Oracle); 8] = [
    (3, 3, oracle::<3, 3>),
    (3, 4, oracle::<3, 4>),
    (3, 5, oracle::<3, 5>),
    (4, 3, oracle::<4, 3>),
    (4, 4, oracle::<4, 4>),
    (4, 5, oracle::<4, 5>),
    (5, 3, oracle::<5, 3>),
    (5, 4, oracle::<5, 4>),
];

#[test]
fn all_operands_canonical_or_not() {
    for (e, s, oracle) in FORMATS {
        let exact = Exact::new(e, s);
        for ports in [PortFormat::Ieee, PortFormat::Recoded] {
            let mut bench = bench(exact.format, ports);
            for (a, b, expected) in cases(&exact, oracle, ports) {
                assert_eq!(bench.run(a, b), expected, "{}, {ports:?}: {a:#x}, {b:#x}", exact.format);
            }
        }
    }
}

#[test]
fn conversions() {
    for (e, s) in FORMATS.map(|(e, s, _)| (e, s)).into_iter().chain([(4, 7), (5, 11), (6, 4), (6, 14), (8, 8), (10, 5)])
    {
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

/// All pairs of words of a format, with the expected results.
pub fn cases(exact: &Exact, oracle: Oracle, ports: PortFormat) -> impl Iterator<Item = (u64, u64, UnitResults)> {
    let operands: Vec<(u64, u64)> = match ports {
        PortFormat::Ieee => exact.ieee_codes().map(|code| (code, code)).collect(),
        PortFormat::Recoded => {
            exact.recoded_words().into_iter().map(|(word, number)| (word, exact.ieee_code(number))).collect()
        }
    };
    let word = move |code: u64| match ports {
        PortFormat::Ieee => code,
        PortFormat::Recoded => exact.recoded_word(exact.ieee_value(code)),
    };
    let seconds = operands.clone();
    operands.into_iter().flat_map(move |(a, x)| {
        let result = move |&(b, y): &(u64, u64)| {
            let UnitResults { sum, difference, product, .. } = oracle(x, y);
            let [sum, difference, product] = [sum, difference, product].map(word);
            (a, b, UnitResults { sum, difference, product, ..oracle(x, y) })
        };
        seconds.iter().map(result).collect::<Vec<_>>()
    })
}
