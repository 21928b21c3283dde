//! Results for all operands of small formats, and for hard and random ones of larger formats.

use crate::division::driver::{ALWAYS, Job, Unit};
use crate::format::operands::Operands;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_float::{DivSqrt, Format};
use raypath_hdl::Simulator;

const FUNCTIONS: [DivSqrt; 4] = [DivSqrt::Quotient, DivSqrt::Reciprocal, DivSqrt::Root, DivSqrt::QuotientOrRoot];

fn format(e: u32, s: u32) -> Format {
    Format::new(e, s).expect("a format of the test's choosing")
}

/// Each form of each function in turn, so that all forms see all operands of some format.
#[test]
fn every_operand_of_small_formats() {
    for (e, s) in [(3, 3), (3, 4), (3, 5), (4, 3), (4, 4), (5, 3)] {
        let format = format(e, s);
        let codes = 1_u64 << format.ieee_width();
        let both = |a| (0..codes).flat_map(move |b| [false, true].map(|is_root| Job { a, b, is_root }));
        let all: Vec<Job> = (0..codes).flat_map(both).collect();
        let one = |code| Job { a: code, b: code, is_root: false };
        let single: Vec<Job> = (0..codes).map(one).collect();
        for function in FUNCTIONS {
            let jobs = match function {
                DivSqrt::Reciprocal | DivSqrt::Root => &single,
                DivSqrt::Quotient | DivSqrt::QuotientOrRoot => &all,
            };
            for latency in 1..=s + 3 {
                Unit::pipelined(function, format, latency).check(jobs, |code| format.encode(code), ALWAYS);
            }
            for digits in 1..=s + 2 {
                Unit::iterative(function, format, digits).check(jobs, |code| format.encode(code), ALWAYS);
            }
        }
    }
}

/// Random bits where a class ignores them; results are canonical all the same.
#[test]
fn operands_that_are_not_canonical() {
    for (e, s) in [(3, 5), (5, 11), (8, 24)] {
        let format = format(e, s);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let specials = [0, format.infinity(), format.nan(), format.from_f64(1.0), format.from_f64(3.0)];
        let sign = 1 << (format.ieee_width() - 1);
        let mut number = || specials[random.random_range(0..specials.len())] | if random.random() { sign } else { 0 };
        let jobs: Vec<Job> = (0..20_000).map(|n| Job { a: number(), b: number(), is_root: n % 3 == 0 }).collect();
        let word = |code| {
            let word = format.encode(code);
            let fraction = format.fraction_width();
            let free = match word >> (fraction + e - 2) & 0b111 {
                0b000 | 0b110 => (1 << (fraction + e - 2)) - 1,
                0b111 => ((1 << (fraction + e - 2)) - 1) | 1 << (format.recoded_width() - 1),
                _ => 0,
            };
            word & !free | random.next_u64() & free
        };
        Unit::iterative(DivSqrt::QuotientOrRoot, format, 2).check(&jobs, word, ALWAYS);
    }
}

/// Formats of all sizes; in each, every form of every function for a share of the operands.
#[test]
fn hard_operands_of_larger_formats() {
    let formats = [(5, 11), (8, 8), (8, 11), (4, 7), (6, 19), (10, 6), (11, 3), (7, 24), (11, 24), (8, 24)];
    for (number, (e, s)) in (0..).zip(formats) {
        let format = format(e, s);
        let mut operands = Operands::new(format, number);
        for function in FUNCTIONS {
            let jobs: Vec<Job> = (0..20_000).map(|_| hard(format, &mut operands)).collect();
            let word = |code| format.encode(code);
            for latency in [1, 2, s / 2, s + 3] {
                Unit::pipelined(function, format, latency).check(&jobs, word, ALWAYS);
            }
            for digits in [1, 2, 3, s + 2] {
                Unit::iterative(function, format, digits).check(&jobs[..4_000], word, ALWAYS);
            }
        }
    }
}

/// Quotients of every class and rounding, and radicands that are near squares.
fn hard(format: Format, operands: &mut Operands) -> Job {
    let (a, b) = operands.pair();
    let root = format.to_f64(b);
    let a = if operands.rng.random_range(0..8) == 0 { format.from_f64(root * root) } else { a };
    Job { a, b, is_root: operands.rng.random() }
}

/// The combinational units, and the sign of the root of -0.
#[test]
fn combinational_units() -> Result<(), raypath_hdl::Error> {
    let format = Format::BINARY32;
    let code = |number: f32| format.encode(number.to_bits().into());
    let mut simulator = Simulator::new(&raypath_float::div(format)?)?;
    for (x, y) in [(1.0_f32, 3.0_f32), (-7.0, 2.0), (1e-40, 3.0), (f32::MAX, 0.5), (0.0, -5.0), (1.0, -0.0), (0.0, 0.0)]
    {
        assert_eq!(simulator.evaluate([x, y].map(code)), [code(x / y)], "{x:e} / {y:e}");
    }
    let mut simulator = Simulator::new(&raypath_float::sqrt(format)?)?;
    for x in [2.0_f32, 1e-40, f32::MAX, 0.0, -0.0, -1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        assert_eq!(simulator.evaluate([code(x)]), [code(x.sqrt())], "root of {x:e}");
    }
    Ok(())
}
