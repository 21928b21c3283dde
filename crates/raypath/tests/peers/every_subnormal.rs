//! Conversion of all binary32 subnormals to the recoded format and back, compared with a normalisation in binary64.
//!
//! Known bug: SoftFloat in Hercules shifted by a count of leading zeros that could be negative (issue 29). Its effect
//! here would be a subnormal coordinate with a wrong power of two.
//!
//! Mutation: in `raypath-float/src/units/encode.rs`, any two leading-zero counts exchanged, or one too many.

use raypath::float::Format;
use raypath::float::{decode, encode};
use raypath::hdl::Simulator;

/// Subnormal numbers are normal ones in binary64, where the host's conversion normalises them. The recoded exponent of
/// a normal binary32 number is that of IEEE 754 plus 2⁷ + 1 (`docs/reference/formats.md`); it continues below the
/// normal range.
fn recoded(code: u32) -> u64 {
    let wide = f64::from(f32::from_bits(code)).to_bits();
    let exponent = (wide >> 52 & 0x7ff) as i64 - 1023 + 127;
    let fraction = wide >> 29 & 0x7f_ffff;
    (wide >> 63) << 32 | ((exponent + 129) as u64) << 23 | fraction
}

#[test]
fn every_subnormal_is_recoded_and_converted_back() {
    let format = Format::BINARY32;
    let mut encoder = Simulator::new(&encode(format).expect("an encoder")).expect("it runs");
    let mut decoder = Simulator::new(&decode(format).expect("a decoder")).expect("it runs");
    for sign in [0, 1 << 31] {
        for fraction in 1..1 << 23 {
            let code: u32 = sign | fraction;
            let word = recoded(code);
            assert_eq!(encoder.evaluate([code.into()]), [word], "{code:#010x}");
            assert_eq!(decoder.evaluate([word]), [u64::from(code)], "{code:#010x} as {word:#x}");
        }
    }
}
