//! The rays: their contexts, their set-up, and what is kept of them.

use super::connect::{Inputs, Named, keep, named};
use super::contexts::contexts;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use super::set_up::set_up;
use crate::fold::HitLimits;
use crate::netlist::{Netlist, Value, inputs, wires};
use crate::set_up::Entry;
use raypath_hdl::{Builder, Error, Module};
use raypath_ops::Bit;
use std::sync::Arc;

/// The module `raypath_unit_rays`.
///
/// A ray enters where `valid_i` and `ready_o` are 1: `entry_…_i`, `id_i`, `any_hit_i`, `cull_i`, `root_i`. When its
/// constants are known, `start_valid_o` is 1 with `start_context_o` and `start_is_refused_o`, until `start_taken_i` is
/// 1. `release_i` frees the context `hit_context_i`, whose `id_o` is read at the same time.
///
/// Readers give an enable and a context, and have their words in the next cycle: `job_read_i` for `job_…_o`,
/// `limits_read_i` for `limits_…_o`, `step_read_i` for `begin_…_o`.
pub fn rays(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts: count, id_width, divider_latency, .. } = parameters;
    let builder = Builder::new("raypath_unit_rays");
    let m = &builder;
    m.doc("The contexts of rays, the set-up of rays, and what is kept of them.");
    let width = bits(count);
    let valid = m.input("valid_i", 1);
    let entry: Entry<Netlist<'_>> = inputs(m, "entry");
    let id = m.input("id_i", id_width);
    let any_hit = m.input("any_hit_i", 1);
    let cull = m.input("cull_i", 2);
    let root = m.input("root_i", 32);
    let start_taken = m.input("start_taken_i", 1);
    let reader = |name: &str| {
        let [enable, context] =
            [("read", 1), ("context", width)].map(|(port, w)| m.input(&format!("{name}_{port}_i"), w));
        (enable, context)
    };
    let release = (m.input("release_i", 1), m.input("hit_context_i", width));
    let [job, limits_reader, step] = ["job", "limits", "step"].map(reader);

    m.section("A ray enters a free context");
    let enters = m.forward("enters", 1);
    let free = Inputs::default()
        .port("take", enters.wire())
        .port("release", release.0)
        .port("released", release.1)
        .place(m, "u_contexts", &contexts(count)?);
    let context = free.port("context");
    let constants = Inputs::default()
        .port("valid", valid & free.port("valid"))
        .ports(wires("entry", &entry))
        .port("context", context)
        .place(m, "u_set_up", &set_up(count, divider_latency)?);
    let ready = (constants.port("ready") & free.port("valid")).named("ready");
    enters.drive(valid & ready);

    m.section("What is kept of it, by reader");
    let bit = |place: u32| Bit::new(Netlist(m), Value(cull.bit(place)));
    let limits = HitLimits { t_min: entry.t_min, cull_back: bit(0), cull_front: bit(1) };
    let begin = vec![named("root", root), named("t_max", entry.t_max.value.0), named("any_hit", any_hit)];
    let at_entry = (enters.wire(), context);
    let id = keep("u_ids", count, at_entry, vec![named("id", id)], release);
    let origin = keep("u_origins", count, at_entry, wires("origin", &entry.origin), job);
    let limits = keep("u_limits", count, at_entry, wires("limits", &limits), limits_reader);
    let begin = keep("u_begins", count, at_entry, begin, step);
    let is_known = constants.port("valid");
    let derived: Named<'_> = CONSTANTS.iter().map(|name| named(name, constants.port(name))).collect();
    let derived = keep("u_constants", count, (is_known, constants.port("context")), derived, job);

    m.section("Rays that begin");
    let start = Inputs::default()
        .port("push", is_known)
        .port("context", constants.port("context"))
        .port("is_refused", constants.port("is_refused"))
        .port("pop", start_taken)
        .place(m, "u_starts", &queue("raypath_unit_starts", count, &[("context", width), ("is_refused", 1)])?);

    m.output("ready_o", ready);
    for name in ["valid", "context", "is_refused"] {
        m.output(&format!("start_{name}_o"), start.port(name));
    }
    let output = |name: &str, wire| m.output(&format!("{name}_o"), wire);
    id.iter().chain(&limits).for_each(|(name, wire)| output(name, *wire));
    origin.into_iter().chain(derived).for_each(|(name, wire)| output(&format!("job_{name}"), wire));
    begin.iter().for_each(|(name, wire)| output(&format!("begin_{name}"), *wire));
    builder.finish()
}

/// The constants of a ray, which are fields of the datapath's ray.
pub const CONSTANTS: [&str; 9] = ["inv_x", "inv_y", "inv_z", "shear_x", "shear_y", "shear_z", "kx", "ky", "kz"];
