//! Sum of two recoded numbers. A difference is a sum with one sign bit inverted.
//!
//! Hardware: the operands put in order of magnitude, the smaller one shifted right to the larger one's exponent with
//! guard, round and sticky bit, one adder that also subtracts, a normalising shift left, and one incrementer that
//! rounds fraction and exponent together. A sum below the normal range is exact, so that it needs nothing of its own.
//!
//! Tests in `tests/units`: `small_formats.rs` (all operands, exact sums), `binary32.rs` (the host's `f32`),
//! `other_formats.rs` (exact sums), `verilator.rs`.

use crate::Format;
use crate::align::shift_right_sticky;
use crate::normalise::normalise;
use crate::recoded::{Magnitude, Outcome};
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_fp_add_<format>`: `sum_o = a_i + b_i`. A sum that is exactly zero is +0, but for -0 + -0.
pub fn add(format: Format) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("raypath_fp_add_{format}"));
    m.doc("Sum of two recoded numbers, rounded to nearest even.");
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));

    m.section("Order by magnitude");
    let swap = a.word.less(b.word).named("swap");
    let larger = Magnitude::of(format, swap.mux(b.word, a.word).named("larger"));
    let smaller = Magnitude::of(format, swap.mux(a.word, b.word).named("smaller"));
    let larger_sign = swap.mux(b_i.top(), a_i.top()).named("larger_sign");
    let subtract = (a_i.top() ^ b_i.top()).named("subtract");

    m.section("Align; guard, round and sticky bit on the right");
    let distance = (larger.exponent() - smaller.exponent()).named("distance");
    let guards = m.constant(3, 0);
    let unaligned = m.concat(&[smaller.significand(), guards]).named("unaligned");
    let aligned = shift_right_sticky(unaligned, distance);

    m.section("Add or subtract; the lowest bit carries in");
    let augend = m.concat(&[m.constant(1, 0), larger.significand(), guards, m.constant(1, 1)]).named("augend");
    let addend =
        m.concat(&[aligned.extend(aligned.width() + 1), m.constant(1, 0)]) ^ subtract.replicate(augend.width());
    let total = (augend + addend).named("total");
    m.unused("unused_carry", &[total.bit(0)]);

    m.section("Normalise");
    let normalised = normalise(total.upper(total.width() - 1));
    let one = m.constant(larger.exponent().width(), 1);
    let exponent = (larger.exponent() + one - normalised.count.extend(one.width())).named("exponent");
    let cancelled = (!normalised.word.top()).named("cancelled");

    m.section("Round; the carry steps the exponent, at last to infinity");
    let below_hidden = normalised.word.lower(normalised.word.width() - 1);
    let fraction = below_hidden.upper(format.fraction_width()).named("fraction");
    let half = below_hidden.bit(3);
    let round_up = (half & (below_hidden.lower(3).any() | fraction.bit(0))).named("round_up");
    let truncated = m.concat(&[exponent, fraction]);
    let rounded = Magnitude::of(format, (truncated + round_up.extend(truncated.width())).named("rounded"));

    m.section("Result");
    let overflow = (rounded.exponent().upper(2).all() & !cancelled).named("overflow");
    let opposite_infinities = (a.is_infinite() & b.is_infinite() & subtract).named("opposite_infinities");
    let sum = Outcome {
        nan: (a.is_nan() | b.is_nan() | opposite_infinities).named("nan"),
        infinite: (a.is_infinite() | b.is_infinite() | overflow).named("infinite"),
        zero: cancelled,
        sign: cancelled.mux(a_i.top() & b_i.top(), larger_sign),
        exponent: rounded.exponent(),
        fraction: rounded.fraction(),
    };
    m.output("sum_o", sum.pack(&m));
    m.finish()
}
