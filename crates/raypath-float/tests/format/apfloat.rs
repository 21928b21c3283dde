//! All sizes of formats, compared with LLVM's soft float (the crate `rustc_apfloat`).

use crate::format::operands::{Operands, cases};
use rand::RngExt;
use raypath_float::Format;
use rustc_apfloat::ieee::{BFloatS, Double, HalfS, IeeeFloat, Semantics, Single, SingleS};
use rustc_apfloat::{Float, FloatConvert};

/// A format of `E` exponent and `S` significand bits, in the form that `rustc_apfloat` needs.
struct Widths<const E: usize, const S: usize>;

impl<const E: usize, const S: usize> Semantics for Widths<E, S> {
    const BITS: usize = E + S;
    const EXP_BITS: usize = E;
}

#[test]
fn binary16() {
    agrees::<HalfS>(Format::BINARY16);
}

#[test]
fn bfloat16() {
    agrees::<BFloatS>(Format::BFLOAT16);
}

#[test]
fn tensor_float_32() {
    agrees::<Widths<8, 11>>(Format::TF32);
}

#[test]
fn binary32() {
    agrees::<SingleS>(Format::BINARY32);
}

#[test]
fn widest() {
    agrees::<Widths<11, 24>>(format(11, 24));
    agrees::<Widths<7, 24>>(format(7, 24));
}

#[test]
fn wide_exponent_and_narrow_significand() {
    agrees::<Widths<11, 3>>(format(11, 3));
    agrees::<Widths<10, 6>>(format(10, 6));
}

#[test]
fn significand_at_its_bound() {
    agrees::<Widths<6, 19>>(format(6, 19));
    agrees::<Widths<4, 7>>(format(4, 7));
}

fn format(e: u32, s: u32) -> Format {
    Format::new(e, s).expect("a format of the test's choosing")
}

fn agrees<S: Semantics>(format: Format) {
    let mut operands = Operands::new(format, u64::from(format.exponent() * 100 + format.significand()));
    for _ in 0..cases(1_000_000) {
        let (a, b) = operands.pair();
        let (x, y) = (IeeeFloat::<S>::from_bits(a.into()), IeeeFloat::<S>::from_bits(b.into()));
        assert_eq!(format.add(a, b), code(format, (x + y).value), "{format}: sum of {a:#x}, {b:#x}");
        assert_eq!(format.sub(a, b), code(format, (x - y).value), "{format}: difference of {a:#x}, {b:#x}");
        assert_eq!(format.mul(a, b), code(format, (x * y).value), "{format}: product of {a:#x}, {b:#x}");
        assert_eq!(format.div(a, b), code(format, (x / y).value), "{format}: quotient of {a:#x}, {b:#x}");
        assert_eq!(format.compare(a, b), x.partial_cmp(&y), "{format}: order of {a:#x}, {b:#x}");
        assert_eq!(format.neg(a), code(format, -x), "{format}: {a:#x} negated");

        let wide = double(x);
        // The host's root has 53 bits. A root of at most 24 bits that is not a midpoint differs from all midpoints in
        // the first 50, so a second rounding changes nothing.
        let root: IeeeFloat<S> = Double::from_bits(wide.sqrt().to_bits().into()).convert(&mut false).value;
        assert_eq!(format.sqrt(a), code(format, root), "{format}: square root of {a:#x}");
        let given = format.to_f64(a);
        assert!(given.to_bits() == wide.to_bits() || given.is_nan() && wide.is_nan(), "{format}: {a:#x} is {wide:e}");

        // Between two numbers, in most cases halfway.
        let next = double(x.next_up().value);
        let between = match operands.rng.random_range(0..4) {
            0 | 1 => wide / 2.0 + next / 2.0,
            2 => (wide / 2.0 + next / 2.0).next_up(),
            _ => wide + (next - wide) * operands.rng.random_range(0.0..1.0),
        };
        for number in [between, f64::from_bits(operands.rng.random())] {
            let expected: IeeeFloat<S> = Double::from_bits(number.to_bits().into()).convert(&mut false).value;
            assert_eq!(format.from_f64(number), code(format, expected), "{format}: {number:e}");
            let single = number as f32;
            let expected: IeeeFloat<S> = Single::from_bits(single.to_bits().into()).convert(&mut false).value;
            assert_eq!(format.from_f32(single), code(format, expected), "{format}: {single:e}");
        }
    }
}

fn double<S: Semantics>(number: IeeeFloat<S>) -> f64 {
    let double: Double = number.convert(&mut false).value;
    f64::from_bits(double.to_bits() as u64)
}

/// The bits of a number; every NaN becomes the quiet NaN without payload.
fn code<S: Semantics>(format: Format, number: IeeeFloat<S>) -> u64 {
    if !number.is_nan() {
        return number.to_bits() as u64;
    }
    let exponent = (1 << format.exponent()) - 1;
    exponent << (format.significand() - 1) | 1 << (format.significand() - 2)
}
