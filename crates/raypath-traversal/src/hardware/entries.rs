//! The set-up of a unit with instances: of new rays, and of rays that enter an instance.

use super::connect::{Inputs, hold};
use super::queue::bits;
use super::rays::CONSTANTS;
use super::set_up::set_up;
use crate::netlist::{Netlist, from_list, inputs, outputs, wires};
use crate::set_up::Entry;
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::Vec3;
use std::sync::Arc;

/// The module `raypath_unit_entries`: `raypath_unit_set_up`, and what chooses its next ray.
///
/// A new ray enters as in `raypath_unit_set_up`; `free_i` says that there is a context for it. The outcome of a
/// transform, `transformed_…_i`, is there where `transformed_valid_i` is 1, and is taken where `transformed_ready_o` is
/// 1 too. The first of an instance is the origin, which this module keeps. The second, which
/// `transformed_is_last_i` says, is the direction, with which the ray enters the set-up.
///
/// Where `enters_instance_o` is 1, `object_…_o` is the origin of `origin_context_o` in the space of its instance. The
/// constants come out as from `raypath_unit_set_up`, and `is_instance_o` says that they are those in an instance.
///
/// With directions, `direction_…_o` is its direction there.
///
/// New rays and instances take turns if both wait. As `ready_o` does not depend on `valid_i`, the turn of a new ray
/// passes in a cycle in which it could enter, whether it comes or not.
pub fn entries(contexts: u32, divider_latency: u32, has_directions: bool) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_entries");
    let m = &builder;
    m.doc("The set-up of new rays, and of rays that enter an instance.");
    let width = bits(contexts);
    let valid = m.input("valid_i", 1);
    let entry: Entry<Netlist<'_>> = inputs(m, "entry");
    let is_meaningless = m.input("is_meaningless_i", 1);
    let context = m.input("context_i", width);
    let free = m.input("free_i", 1);
    let [is_transformed, is_last] = ["valid", "is_last"].map(|name| m.input(&format!("transformed_{name}_i"), 1));
    let transformed_context = m.input("transformed_context_i", width);
    let transformed: Vec3<Netlist<'_>> = inputs(m, "transformed");

    m.section("The turns");
    let ready = m.forward("ready", 1);
    let yields = m.register("yields_q", 1).reset_to(0);
    yields.wire().comment("after an instance a new ray goes first, so that both get their turn");
    let waits = (is_transformed & is_last).named("waits");
    let chosen = (waits & !(yields.wire() & free)).named("chosen");
    yields.next_when(ready.wire(), chosen);

    m.section("The ray that is next");
    let is_origin = (is_transformed & !is_last).named("is_origin");
    let origin = wires("origin", &transformed).into_iter();
    let origin: Vec<Wire<'_>> = origin.map(|(name, wire)| hold(&format!("{name}_q"), is_origin, wire)).collect();
    let direction = wires("", &transformed).into_iter().map(|(_, wire)| wire);
    // The range of the ray was tested when it entered the unit.
    let zero = m.constant(32, 0);
    let in_instance = origin.iter().copied().chain(direction).chain([zero, zero]);
    let next: Vec<_> =
        wires("entry", &entry).into_iter().zip(in_instance).map(|((name, a), b)| (name, chosen.mux(b, a))).collect();
    // The highest bit of the context says that the ray is in an instance.
    let constants = Inputs::default()
        .port("valid", chosen | valid)
        .ports(next)
        .port("is_meaningless", is_meaningless & !chosen)
        .port("context", m.concat(&[chosen, chosen.mux(transformed_context, context)]))
        .place(m, "u_set_up", &set_up(2 * contexts, divider_latency)?);
    ready.drive(constants.port("ready"));

    m.output("ready_o", ready.wire() & !chosen);
    m.output("transformed_ready_o", !is_last | (chosen & ready.wire()));
    m.output("enters_instance_o", chosen & ready.wire());
    m.output("origin_context_o", transformed_context);
    outputs(m, "object", &from_list::<Vec3<Netlist<'_>>>(m, &origin));
    if has_directions {
        outputs(m, "direction", &transformed);
    }
    let (known, is_instance) = (constants.port("context").lower(width), constants.port("context").top());
    m.output("context_o", known);
    m.output("is_instance_o", is_instance);
    for name in ["valid", "is_refused"].into_iter().chain(CONSTANTS) {
        m.output(&format!("{name}_o"), constants.port(name));
    }
    builder.finish()
}
