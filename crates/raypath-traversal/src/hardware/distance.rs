//! The distances of triangles, and the closest hit of each block.

use super::connect::{Named, hold, keep, named};
use super::division::{Division, Operands, divide};
use super::parameters::UnitParameters;
use super::queue::bits;
use crate::fold::{HitLimits, fold};
use crate::netlist::{Netlist, Value, from_wires, outputs_with, wires_with};
use crate::state::TriangleHit;
use crate::step::StepParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::Bit;
use std::sync::Arc;

/// The module `raypath_unit_distance`. The outcome of a triangle job enters where `valid_i` and `ready_o` are 1. The
/// closest hit of its block, `closest_…_o` with `context_o`, is there when its last triangle has passed: where
/// `valid_o` is 1, until `taken_i` is 1.
///
/// Numerators and denominators wait in a memory of this module. Where `read_o` is 1, the limits of the ray of
/// `read_context_o` and the indices of its block are read: `limits_…_i` and `index_…_i` have them in the next cycle.
pub fn distance(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts, step, divider_latency, .. } = parameters;
    let StepParameters { features, node, .. } = step;
    let builder = Builder::new("raypath_unit_distance");
    let m = &builder;
    m.doc("The distances of triangles by division, and the closest hit of each block.");
    let c = Netlist(m);
    let width = bits(contexts);
    let place_bits = step.place_bits();
    let valid = m.input("valid_i", 1);
    let context = m.input("context_i", width);
    let [place, is_last] = step.of_job().map(|(name, width)| m.input(&format!("{name}_i"), width));
    let [is_hit, is_front] = ["is_hit_i", "is_front_i"].map(|name| m.input(name, 1));
    let numbers = FRACTION.into_iter().filter(|name| features.has(name));
    let numbers: Named<'_> = numbers.map(|name| named(name, m.input(&format!("{name}_i"), 32))).collect();
    let limits: HitLimits<Netlist<'_>> = from_wires(m, "limits", |field, width| {
        let is_there = features.has_candidates() || !field.contains("after_");
        if is_there { m.input(&format!("{field}_i"), width) } else { m.constant(width, 0) }
    });
    let indices: Vec<Wire<'_>> =
        (0..node.triangles_per_block()).map(|k| m.input(&format!("index_{k}_i"), 32)).collect();
    let geometry = features.has("geometry").then(|| m.input("geometry_i", 32));
    let taken = m.input("taken_i", 1);

    m.section("The operands, and their division");
    let slot = m.concat(&[context, place]);
    let moves = m.forward("moves", 1);
    moves.wire().comment("the divider waits as a whole, while a block is complete and not taken");
    let operands = Operands {
        valid,
        dividend: numbers[0].1,
        divisor: numbers[1].1,
        tag: vec![context, place, is_last, is_hit, !is_front],
    };
    let Division { ready, enters, valid: has_quotient, quotient, tag } =
        divide(divider_latency, operands, Some(moves.wire()))?;
    let read_slot = tag.upper(width + place_bits);

    m.section("The hit whose limits and index are read");
    let read = (has_quotient & moves.wire()).named("read");
    read.comment("behind the divider, so that no word goes through it that a memory has");
    let has_hit = m.register("has_hit_q", 1).reset_to(0);
    let folds = m.forward("folds", 1);
    moves.drive(!has_hit.wire() | folds.wire());
    has_hit.next(read | (has_hit.wire() & !folds.wire()));
    let (t, tag_q) = (hold("t_q", read, quotient), hold("tag_q", read, tag));
    let fraction = keep("u_fractions", contexts << place_bits, (enters, slot), numbers, (read, read_slot));

    m.section("The closest hit of its block so far");
    let place = tag_q.bits(2 + place_bits, 3);
    let index = place.select(&indices).hint("index");
    let rest = [("is_hit", tag_q.bit(1)), ("t", t), ("is_clockwise", tag_q.bit(0)), ("primitive", index)];
    let rest = rest.into_iter().chain(geometry.map(|geometry| ("geometry", geometry)));
    let known: Named<'_> = rest.map(|(name, wire)| named(name, wire)).chain(fraction).collect();
    let found: TriangleHit<Netlist<'_>> = from_wires(m, "", |field, width| found_in(m, &known, field, width));
    let registers: Vec<_> = wires_with("closest", &found, parameters.step)
        .map(|(name, wire)| (m.register(&format!("{name}_q"), wire.width()), name))
        .collect();
    let held: Named<'_> = registers.iter().map(|(register, name)| named(name, register.wire())).collect();
    let before: TriangleHit<Netlist<'_>> = from_wires(m, "closest", |field, width| found_in(m, &held, field, width));
    let closest = fold(before, Bit::new(c, Value(place.is(0))), found, limits);
    for ((register, _), (_, wire)) in registers.iter().zip(wires_with("", &closest, parameters.step)) {
        register.next_when(folds.wire(), wire);
    }
    let is_complete = m.register("is_complete_q", 1).reset_to(0);
    folds.drive(has_hit.wire() & (!is_complete.wire() | taken));
    let completes = folds.wire() & tag_q.bit(2);
    is_complete.next(completes | (is_complete.wire() & !taken));
    let complete_context = m.register("context_q", width);
    complete_context.next_when(folds.wire(), tag_q.upper(width));

    m.output("ready_o", ready);
    m.output("read_o", read);
    m.output("read_context_o", tag.upper(width));
    m.output("valid_o", is_complete.wire());
    m.output("context_o", complete_context.wire());
    outputs_with(m, "closest", &before, parameters.step);
    builder.finish()
}

/// The numbers of a triangle's outcome that wait for its quotient.
const FRACTION: [&str; 4] = ["t_num", "t_denom", "u_num", "v_num"];

/// The wire of this name; 0 if the features do not have it.
fn found_in<'m>(m: &'m Builder, named: &[(String, Wire<'m>)], name: &str, width: u32) -> Wire<'m> {
    named.iter().find(|(known, _)| known == name).map_or_else(|| m.constant(width, 0), |(_, wire)| *wire)
}
