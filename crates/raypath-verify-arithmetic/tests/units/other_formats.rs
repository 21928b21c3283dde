//! Random operands in formats between the exhaustible ones and the largest, against LLVM's soft float.

use crate::units::bench;
use crate::units::binary32::cases;
use rand::Rng;
use raypath_float::Format;
use raypath_verify_arithmetic::units::bench::{PortFormat, UnitResults};
use raypath_verify_arithmetic::units::operands::generator;
use raypath_verify_arithmetic::units::oracle;

#[test]
fn binary16() {
    by_soft_float::<5, 11>();
}

#[test]
fn bfloat16() {
    by_soft_float::<8, 8>();
}

#[test]
fn tensor_float_32() {
    by_soft_float::<8, 11>();
}

#[test]
fn significand_at_its_bound() {
    by_soft_float::<4, 7>();
    by_soft_float::<6, 14>();
    by_soft_float::<6, 19>();
}

#[test]
fn wide_exponent() {
    by_soft_float::<10, 6>();
    by_soft_float::<11, 3>();
}

#[test]
fn widest() {
    by_soft_float::<7, 24>();
    by_soft_float::<8, 24>();
    by_soft_float::<11, 24>();
}

fn by_soft_float<const E: usize, const S: usize>() {
    let format = Format::new(E as u32, S as u32).expect("a format of the test's choosing");
    random_operands(format, oracle::<E, S>);
}

/// Of each eight pairs, four are random, three have near exponents, and one of exponents whose product is near the
/// subnormal range.
fn random_operands(format: Format, expected: impl Fn(u64, u64) -> UnitResults) {
    let mut bench = bench(format, PortFormat::Ieee);
    let mut random = generator(u64::from(format.exponent()) << 8 | u64::from(format.significand()));
    let (mask, fraction_width) = ((1 << format.ieee_width()) - 1, format.significand() - 1);
    let exponents = (1 << format.exponent()) - 1;
    for _ in 0..cases(1_000_000) {
        let draw = random.next_u64();
        let a = random.next_u64() & mask;
        let any = random.next_u64() & mask;
        let near = |centre: u64| {
            let offset = draw >> 8 & 0x3f;
            let exponent = (centre + offset).saturating_sub(32).min(exponents);
            any & !(exponents << fraction_width) | exponent << fraction_width
        };
        let exponent = a >> fraction_width & exponents;
        let b = match draw & 7 {
            0..4 => any,
            4..7 => near(exponent),
            _ => near((exponents / 2).saturating_sub(exponent)),
        };
        assert_eq!(bench.run(a, b), expected(a, b), "{format}: {a:#x}, {b:#x}");
    }
}
