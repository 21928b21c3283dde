//! The sign of zero results by IEEE 754 (6.3): an exact cancellation is +0, a sum of zeros is −0 only if both are, and
//! the sign of a product follows from its factors.
//!
//! Known bugs: BlackParrot (pull request 1161) and RSD (issue 92) multiplied with a fused unit that adds +0, so that −0
//! products became +0; libm's `fma` (Rust, pull request 493) lost −0 in another way. t_num or an angular sum would have
//! a wrong sign here.
//!
//! Mutation: in `raypath-float/src/units/add.rs` the sign of an exact cancellation taken from an operand; in `mul.rs` a
//! sign that is 0 where the product is.

use raypath::float::{Format, add, mul};
use raypath::hdl::{Module, Simulator};
use std::sync::Arc;

/// The result of a unit with two inputs, with binary32 at inputs and output.
fn run(module: &Arc<Module>, cases: &[(f32, f32)]) -> Vec<u32> {
    let mut simulator = Simulator::new(module).expect("it runs");
    let format = Format::BINARY32;
    let mut answer = |&(a, b): &(f32, f32)| {
        let words = [a, b].map(|number| format.encode(number.to_bits().into()));
        format.decode(simulator.evaluate(words)[0]) as u32
    };
    cases.iter().map(&mut answer).collect()
}

const PLUS: u32 = 0;
const MINUS: u32 = 0x8000_0000;

#[test]
fn sums() {
    let add = add(Format::BINARY32).expect("an adder");
    assert_eq!(run(&add, &[(0.0, 0.0), (0.0, -0.0), (-0.0, 0.0), (-0.0, -0.0)]), [PLUS, PLUS, PLUS, MINUS]);
    // An exact cancellation is +0, for either order of the signs.
    let tiny = f32::from_bits(1);
    let numbers = [tiny, f32::from_bits(0x7f_ffff), f32::MIN_POSITIVE, 1.0, 1.0 + f32::EPSILON, 3e38, f32::MAX];
    for number in numbers {
        assert_eq!(run(&add, &[(number, -number), (-number, number)]), [PLUS, PLUS], "{number:e}");
        // Adding a zero of either sign does not change a number.
        let beside = [(number, 0.0), (number, -0.0), (0.0, number), (-0.0, number)];
        assert_eq!(run(&add, &beside), [number.to_bits(); 4], "{number:e}");
    }
}

#[test]
fn products() {
    let mul = mul(Format::BINARY32).expect("a multiplier");
    let tiny = f32::from_bits(1);
    for number in [0.0, tiny, f32::MIN_POSITIVE, 1.0, f32::MAX] {
        let cases = [(number, 0.0), (number, -0.0), (-number, 0.0), (-number, -0.0), (0.0, -number), (-0.0, number)];
        assert_eq!(run(&mul, &cases), [PLUS, MINUS, MINUS, PLUS, MINUS, MINUS], "{number:e}");
    }
    // Products that are rounded to zero keep their signs.
    let cases = [(tiny, 0.25), (-tiny, 0.25), (tiny, -tiny), (-tiny, -tiny), (tiny, -0.5)];
    assert_eq!(run(&mul, &cases), [PLUS, MINUS, MINUS, PLUS, MINUS]);
}
