//! Quotients and roots, a few digits in each cycle.
//!
//! Hardware: registers for the remainder, the digits so far, the divisor, and what the operands alone determine; the
//! subtractors of one cycle; and the rounding, between the registers and the output. A ring with one bit for each cycle
//! marks the places of the cycle's digits.

use crate::Format;
use crate::units::recurrence::{DivSqrt, Start, step, subtrahend};
use crate::units::round::Unrounded;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module of [`DivSqrt::iterative`].
pub(crate) fn iterative(
    function: DivSqrt,
    format: Format,
    digits_a_cycle: u32,
    tag_width: u32,
    name: &str,
    doc: &str,
) -> Result<Arc<Module>, Error> {
    let needed = DivSqrt::digits(format);
    if !(1..=needed).contains(&digits_a_cycle) {
        let problem = format!("are {digits_a_cycle} a cycle, expected 1 to {needed}");
        return Err(Error::Width { module: name.to_string(), signal: "digits".to_string(), problem });
    }
    let builder = Builder::new(name);
    let m = &builder;
    m.doc(doc);
    let cycles = needed.div_ceil(digits_a_cycle);
    // The last cycle may have digits behind those that are needed.
    let places = cycles * digits_a_cycle;

    let valid_i = m.input("valid_i", 1);
    let ready_i = m.input("ready_i", 1);
    let busy = m.register("busy_q", 1).reset_to(0);
    let done = m.register("done_q", 1).reset_to(0);
    let ring = m.register("ring_q", cycles);
    m.section("Control");
    let ready = (!busy.wire() & (!done.wire() | ready_i)).named("ready");
    let accept = (valid_i & ready).named("accept");
    let last = (busy.wire() & ring.wire().bit(0)).named("last");
    let work = (accept | busy.wire()).named("work");
    busy.next(accept | (busy.wire() & !last));
    done.next(last | (done.wire() & !ready_i));
    let zero = m.constant(1, 0);
    let turned = if cycles == 1 { zero } else { m.concat(&[zero, ring.wire().upper(cycles - 1)]) };
    ring.next_when(work, accept.mux(m.constant(cycles, 1 << (cycles - 1)), turned));
    let hold = |stem: &str, wire: Wire<'_>| {
        let register = m.register(&format!("{stem}_q"), wire.width());
        register.next_when(accept, wire);
        register.wire()
    };
    let tag = (tag_width > 0).then(|| hold("tag", m.input("tag_i", tag_width)));

    let start = Start::of(function, format, m);
    m.section("Operands");
    let [exponent, settled, sign] =
        [("exponent", start.exponent), ("settled", start.settled), ("sign", start.sign)].map(|(stem, x)| hold(stem, x));
    let [divisor, is_root] =
        [("divisor", start.divisor), ("is_root", start.is_root)].map(|(stem, wire)| wire.map(|wire| hold(stem, wire)));
    // A root's trial subtrahend has a bit behind the last place.
    let missing = if function.takes_roots() { places + 1 - start.remainder.width() } else { 0 };
    let first = if missing == 0 { start.remainder } else { m.concat(&[start.remainder, m.constant(missing, 0)]) };

    m.section("Digits");
    let remainder = m.register("remainder_q", first.width());
    let digits = m.register("digits_q", places);
    let (mut next_remainder, mut next_digits) = (remainder.wire(), digits.wire());
    for number in 0..digits_a_cycle {
        // The bit of the ring stands at the place of this cycle's first digit.
        let place = |cycle: u32| {
            let before = (number > 0).then(|| m.constant(number, 0));
            let behind = (number + 1 < digits_a_cycle).then(|| m.constant(digits_a_cycle - number - 1, 0));
            before.into_iter().chain([ring.wire().bit(cycles - 1 - cycle)]).chain(behind)
        };
        let mask = m.concat(&(0..cycles).flat_map(place).collect::<Vec<_>>()).named(&format!("place_{number}"));
        let trial = || m.concat(&[next_digits, zero]) | m.concat(&[zero, mask]);
        let (digit, rest) = step(next_remainder, subtrahend(next_remainder, divisor, is_root, trial), number);
        next_digits = (next_digits | (mask & digit.replicate(places))).named(&format!("digits_{number}"));
        next_remainder = rest;
    }
    remainder.next_when(work, accept.mux(first, next_remainder));
    digits.next_when(work, next_digits & (!accept).replicate(places));

    let word = digits.wire().upper(needed);
    let spare = (places > needed).then(|| digits.wire().lower(places - needed).any());
    let rest = remainder.wire().any();
    let sticky = spare.map_or(rest, |spare| spare | rest).named("sticky");
    let rounded = Unrounded { format, word, sticky, exponent, settled, sign, subnormal: None }.round();
    m.output("ready_o", ready);
    m.output("valid_o", done.wire());
    m.output("result_o", rounded.number);
    tag.into_iter().for_each(|tag| m.output("tag_o", tag));
    builder.finish()
}
