//! The set-up of rays: five quotients of each, from one pipelined divider.

use super::connect::{delay, hold};
use super::division::{Division, Operands, divide};
use super::queue::bits;
use crate::netlist::{Netlist, Value, from_list, inputs, outputs, wires};
use crate::set_up::{Axes, Entry, QUOTIENTS, axes, derived, divisions, is_refused};
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::{Num, Vec3};
use std::sync::Arc;

/// The module `raypath_unit_set_up`, which takes a ray every five cycles.
///
/// A ray, `entry_…_i` with `is_meaningless_i` of its flags and `context_i`, enters in a cycle in which `valid_i` and `ready_o` are 1. Its constants,
/// `inv_…_o`, `shear_…_o`, `kx_o`, `ky_o` and `kz_o`, are there with `context_o` in the one cycle in which `valid_o` is
/// 1; `is_refused_o` says that the ray is refused.
pub fn set_up(contexts: u32, divider_latency: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_set_up");
    let m = &builder;
    m.doc("The constants of rays, from one divider that each ray uses five times.");
    let c = Netlist(m);
    let valid = m.input("valid_i", 1);
    let entry: Entry<Netlist<'_>> = inputs(m, "entry");
    let is_meaningless = m.input("is_meaningless_i", 1);
    let context = m.input("context_i", bits(contexts));
    // Of the origin, the exponents alone decide: it has to be finite.
    let unread = wires("", &entry.origin).into_iter().flat_map(|(_, wire)| [wire.top(), wire.lower(23)]);
    m.unused("unused_origin", &unread.collect::<Vec<_>>());

    m.section("The ray whose operands enter the divider, and the number of the next quotient");
    let busy = m.register("busy_q", 1).reset_to(0);
    let number = m.register("number_q", 3).reset_to(0);
    let is_last = number.wire().is(QUOTIENTS as u64 - 1).named("is_last");
    let ready = (!busy.wire() | is_last).named("ready").comment("with the last operands of the ray before it");
    let enters = (valid & ready).named("enters");
    busy.next(enters | (busy.wire() & !is_last));
    number.next_when(busy.wire(), is_last.mux(m.constant(3, 0), number.wire() + m.constant(3, 1)));
    let components = wires("dir", &entry.dir);
    let held: Vec<_> = components.iter().map(|(name, wire)| hold(&format!("{name}_q"), enters, *wire)).collect();
    let dir: Vec3<Netlist<'_>> = from_list(m, &held);
    let refused = hold("is_refused_q", enters, is_meaningless | is_refused(c, &entry).value.0.hint("entry_is_refused"));
    let context = hold("context_q", enters, context);

    m.section("The axes, which the last two quotients need, in a register because they are slow");
    let found = wires("axis", &axes(c, dir));
    let held: Vec<_> = found.iter().map(|(name, wire)| delay(&format!("{name}_q"), *wire)).collect();
    let operands = divisions(c, dir, from_list(m, &held));

    m.section("The operands, and their division: a quotient is always taken");
    let tag: Vec<Wire<'_>> = [context, refused].into_iter().chain(held).chain([is_last]).collect();
    let widths: Vec<u32> = tag.iter().map(|wire| wire.width()).collect();
    let operands = Operands {
        valid: busy.wire(),
        dividend: one_of(number.wire(), operands.map(|division| division.dividend)),
        divisor: one_of(number.wire(), operands.map(|division| division.divisor)),
        tag,
    };
    let Division { valid: has_result, quotient, tag, .. } = divide(divider_latency, operands, None)?;
    let mut low = tag.width();
    let tag: Vec<Wire<'_>> = widths
        .iter()
        .map(|width| {
            low -= width;
            tag.bits(low + width - 1, low)
        })
        .collect();

    m.section("The constants of a ray, with its last quotient: its quotients come in consecutive cycles");
    let mut quotients = vec![quotient];
    for k in (0..QUOTIENTS - 1).rev() {
        quotients.insert(0, delay(&format!("quotient_{k}_q"), quotients[0]));
    }
    let axes: Axes<Netlist<'_>> = from_list(m, &tag[2..5]);
    let derived = derived(c, axes, std::array::from_fn(|k| Num::new(c, Value(quotients[k]))));
    m.output("ready_o", ready);
    m.output("valid_o", has_result & tag[5]);
    m.output("context_o", tag[0]);
    m.output("is_refused_o", tag[1] | derived.is_too_short.value.0);
    outputs(m, "inv", &derived.inv);
    outputs(m, "shear", &derived.shear);
    wires("", &axes).into_iter().for_each(|(name, wire)| m.output(&format!("{name}_o"), wire));
    builder.finish()
}

/// The number at this place.
fn one_of<'m>(place: Wire<'m>, numbers: [Num<Netlist<'m>>; QUOTIENTS]) -> Wire<'m> {
    let numbers = numbers.map(|number| number.value.0);
    (1..QUOTIENTS).fold(numbers[0], |chosen, k| place.is(k as u64).mux(numbers[k], chosen))
}
