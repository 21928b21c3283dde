//! Sum of two recoded numbers. A difference is a sum with one sign bit inverted.
//!
//! Hardware: the operands are ordered by exponent. The smaller one is shifted right to the exponent of the larger one,
//! with guard, round and sticky bits. One adder adds, subtracts and rounds, and a normalising shift left follows. A sum
//! below the normal range is exact and needs no special case.
//!
//! The adder computes its carries first. Together with the bits that a carry into the last place would reach, they give
//! both the sum and the sum plus one. The choice between the two (rounding up, or completing a complement) is made
//! late, once the leading bits are known. Nothing is rounded after the normalising shift, because a sum that it moves
//! by more than one place is exact.
//!
//! Checked by `verify unit-proofs` (symfpu, all operands, also of the unit in parts) and `testfloat` (SoftFloat).

use crate::Format;
use crate::units::align::shift_right_sticky;
use crate::units::constants::Constants;
use crate::units::flags;
use crate::units::lookahead;
use crate::units::normalise::Normalised;
use crate::units::recoded::Magnitude;
use raypath_hdl::{Error, Module, Technology};
use std::sync::Arc;

/// The module `raypath_fp_add_<format>`: `sum_o = a_i + b_i`. A sum that is exactly zero is +0, except that -0 + -0 is
/// -0. With `with_flags` it is `raypath_fp_add_flags_<format>`, and has a second output, `flags_o`: the exceptions of
/// [`flags`](crate::flags) that the sum raises.
pub fn add(format: Format, with_flags: bool) -> Result<Arc<Module>, Error> {
    unit(format, with_flags, None)
}

/// The adder of [`add`], to be [divided](raypath_hdl::divide()) for a technology. It completes the sum without a carry
/// into the last place before it rounds, which takes longer, but leaves fewer bits to pass on. In gates, carries do not
/// ripple, so that a cut can be inside an adder; in FPGAs they have chains of their own.
pub fn add_to_divide(format: Format, with_flags: bool, technology: Technology) -> Result<Arc<Module>, Error> {
    unit(format, with_flags, Some(technology))
}

fn unit(format: Format, with_flags: bool, divided_for: Option<Technology>) -> Result<Arc<Module>, Error> {
    let (completes, has_lookahead) = (divided_for.is_some(), divided_for == Some(Technology::Gates));
    let adder = flags::unit("add", "Sum of two recoded numbers", format, with_flags);
    let m = &adder;
    let (e, s) = (format.exponent(), format.significand());
    let a_i = m.input("a_i", format.recoded_width());
    let b_i = m.input("b_i", format.recoded_width());
    let (a, b) = (Magnitude::of(format, a_i), Magnitude::of(format, b_i));
    let subtract = (a_i.top() ^ b_i.top()).named("subtract");

    m.section("Order by exponent");
    let difference = match has_lookahead {
        true => {
            let sum = lookahead::add(a.exponent(), !b.exponent(), Some(m.constant(1, 1)), "difference");
            m.concat(&[!sum.carry, sum.word])
        }
        false => a.exponent().extend(e + 2) - b.exponent().extend(e + 2),
    };
    let difference = difference.named("difference");
    let swap = difference.top().named("swap");
    let exponent = swap.mux(b.exponent(), a.exponent()).named("larger_exponent");
    let fraction = swap.mux(b.fraction(), a.fraction()).named("larger_fraction");
    let sign = swap.mux(b_i.top(), a_i.top()).named("larger_sign");

    m.section("Zeros, infinities and NaN");
    let both_special = (a.exponent().upper(2).all() & b.exponent().upper(2).all()).named("both_special");
    let special = exponent.upper(2).all().named("special");
    let nan = (exponent.upper(3).all() | (both_special & subtract)).named("nan");
    let both_zero = (a.is_zero() & b.is_zero()).named("both_zero");
    let nan_or_zero = (nan | both_zero).named("nan_or_zero");

    let invalid = with_flags.then(|| (a.is_infinite() & b.is_infinite() & subtract).named("invalid"));

    m.section("Align; guard, round and sticky bit on the right");
    // The distance of swapped operands is the complement plus one. The wiring of `swapped` adds the one.
    let distance = (difference.lower(e + 1) ^ swap.replicate(e + 1)).named("distance");
    let hidden = m.constant(1, 1);
    let swapped = m.concat(&[m.constant(1, 0), hidden, a.fraction(), m.constant(2, 0)]);
    let unaligned = swap.mux(swapped, m.concat(&[hidden, b.fraction(), m.constant(3, 0)])).named("unaligned");
    let smaller =
        shift_right_sticky(unaligned, distance, (a.is_zero() | b.is_zero()).named("either_zero")).named("smaller");

    m.section("Add, for now without a carry into the last place");
    // A difference is the complement of the sum of the larger one's complement and the smaller one.
    let augend = (m.concat(&[m.constant(1, 1), fraction]) ^ subtract.replicate(s)).named("augend");
    let addend = smaller.upper(s).named("addend");
    let propagate = (augend ^ addend).extend(s + 1);
    let propagate = if completes { propagate } else { propagate.named("propagate") };
    let sum = lookahead::sum(augend, addend, has_lookahead, "sum");
    let (propagate, carries) = match completes {
        true => (sum.named("without_carry"), m.constant(s + 1, 0)),
        false => (propagate, (sum ^ propagate).named("carries")),
    };
    let tail = smaller.lower(3).hint("tail");

    m.section("Round");
    let plus_one = match has_lookahead {
        true => lookahead::increment(propagate, "plus_one"),
        false => propagate + m.constant(s + 1, 1),
    };
    let reach = (propagate ^ plus_one.hint("plus_one")).named("reach");
    let carry_out = (propagate.top() ^ carries.top()).named("carry_out");
    let [guard, round, sticky] = [2, 1, 0].map(|place| tail.bit(place));
    let below_guard = (round | sticky).named("below_guard");
    let inexact = (guard | below_guard).named("inexact");
    let borrow = (subtract & inexact).named("borrow");
    let half = (guard ^ (subtract & below_guard)).named("half");
    let quarter = (round ^ (subtract & sticky)).named("quarter");
    let last = propagate.bit(0);
    let next = (propagate.bit(1) ^ carries.bit(1)).named("next");
    let carry_two = (subtract | (last & (inexact | next))).named("carry_two");
    let carry_one = (borrow ^ (half & (below_guard | last))).named("carry_one");
    let carry_half = (inexact & !(half & quarter)).named("carry_half");
    let top = !(propagate.bit(s - 1) ^ (carries.bit(s - 1) | (reach.bit(s - 1) & borrow)));
    let below_one = (subtract & !top).named("below_one");
    let carry_in = carry_out.mux(carry_two, below_one.mux(carry_half, carry_one)).named("carry_in");

    let rounded_carries = (carries | (reach & carry_in.replicate(s + 1))).named("rounded_carries");
    let invert = (subtract & !carry_out).named("invert");
    let rounded = (propagate.lower(s) ^ rounded_carries.lower(s) ^ invert.replicate(s)).named("rounded");
    let carried = ((propagate.top() ^ rounded_carries.top()) & !subtract).named("carried");
    let below = (half ^ (quarter & (sticky | half))).named("below");
    let sum = m.concat(&[carried, rounded, below]).named("sum");

    let overflow =
        (carried & exponent.equals(m.parameter("MaxExp", e + 1, Constants(format).max_finite()))).named("overflow");
    let inexact_sum = with_flags.then(|| {
        // Bits that the normalising shift moves into the result are not lost; bits that it moves out are.
        let lost = carry_out.mux(inexact | (last & !subtract), below_one.mux(below_guard, inexact));
        ((lost & !special & !nan_or_zero) | overflow).named("inexact_sum")
    });
    let cancelled = (subtract & reach.top() & !inexact).named("cancelled");
    let special = (special | overflow).named("special_sum");
    let sign = ((sign ^ (subtract & carry_out)) & !((cancelled | nan_or_zero) & subtract)).named("sum_sign");
    let nan_or_zero = (nan_or_zero | cancelled).named("nan_or_zero_sum");

    m.section("Normalise");
    let normalised = Normalised::of(sum);
    let leading_zeros = normalised.leading_zeros();
    let one_more = (exponent + m.constant(e + 1, 1)).named("one_more");
    let exponent = (one_more - leading_zeros.extend(e + 1)).named("exponent");

    m.section("Result");
    let nan = (special & nan_or_zero).named("result_nan");
    let ordinary = (!special & !nan_or_zero).named("ordinary");
    let class = m.concat(&[special, special, nan, m.constant(e - 2, 0)]);
    let exponent = ((exponent & ordinary.replicate(e + 1)) | class).named("result_exponent");
    let fraction = normalised.fraction(s - 1, ordinary) | m.concat(&[nan, m.constant(s - 2, 0)]);
    m.output("sum_o", m.concat(&[sign & !nan, exponent, fraction.named("result_fraction")]));
    if with_flags {
        // A sum below the normal range is exact.
        flags::output(m, [invalid, Some(overflow), None, inexact_sum]);
    }
    adder.finish()
}
