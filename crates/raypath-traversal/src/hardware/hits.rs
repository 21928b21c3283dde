//! The hits of rays that have ended.

use super::connect::{Access, Inputs, Named, hold, keep, named};
use super::package::refer_to_package;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use super::weights::weights;
use crate::netlist::{Netlist, Value};
use crate::state::status;
use crate::step::StepParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::Word;
use std::sync::Arc;

/// The values of a hit, by the field of the ray's state, and whether each is 0 for rays without a hit.
const VALUES: [(&str, &str, u32, bool); 11] = [
    ("t", "extent", 32, true),
    ("primitive", "primitive", 32, true),
    ("t_num", "t_num", 32, true),
    ("t_denom", "t_denom", 32, true),
    ("back_face", "back_face", 1, true),
    ("nodes", "nodes", 32, false),
    ("triangles", "triangles", 32, false),
    ("instance", "hit_instance_index", 32, true),
    ("geometry", "geometry", 32, true),
    ("custom_index", "hit_instance_custom_index", 24, true),
    ("shader_offset", "hit_instance_shader_offset", 24, true),
];

/// The numerators of barycentric coordinates, which are fields of the ray's state.
const NUMERATORS: [&str; 2] = ["u_num", "v_num"];

/// Whether a hit shows this field of the ray's state, or what follows from it.
pub fn is_shown(field: &str) -> bool {
    NUMERATORS.contains(&field) || VALUES.iter().any(|(_, known, ..)| *known == field)
}

/// The module `raypath_unit_hits`. A ray ends where `ends_i` is 1, in the state `next_…_i` with `status_i`. Its hit
/// waits for `ready_i`: `valid_o`, `status_o` and a port for each value. Where `release_o` is 1, the context
/// `context_o` is free from the next cycle on.
pub fn hits(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts, step: StepParameters { features, .. }, .. } = parameters;
    let builder = Builder::new("raypath_unit_hits");
    let m = &builder;
    m.doc("The hits of rays that have ended, in the order of their ends.");
    refer_to_package(m, features);
    let width = bits(contexts);
    let ends = m.input("ends_i", 1);
    let context = m.input("context_i", width);
    let status_word = m.input("status_i", 3);
    let ready = m.input("ready_i", 1);
    let is = |known: u32| status::CODES.is(Word::<_, 3>::new(Netlist(m), Value(status_word)), known).value.0;
    let is_hit = if features.has_candidates() { is(status::HIT) | is(status::PROCEDURAL) } else { is(status::HIT) };
    let is_hit = is_hit.named("is_hit");
    let value = |(name, field, width, is_of_hit): (&str, &str, u32, bool)| {
        let state = m.input(&format!("next_{field}_i"), width);
        named(name, if is_of_hit { state & is_hit.replicate(width) } else { state })
    };
    let values = VALUES.into_iter().filter(|(_, field, ..)| features.has(field));
    let words: Named<'_> = [named("status", status_word)].into_iter().chain(values.map(value)).collect();
    let numerators: Vec<_> = NUMERATORS.iter().filter(|field| features.has(field)).collect();
    let numerators: Named<'_> =
        numerators.into_iter().map(|field| named(field, m.input(&format!("next_{field}_i"), 32))).collect();

    let valid = m.register("valid_q", 1).reset_to(0);
    valid.wire().comment("its context is free already: the memory keeps the word that it has read");
    let can_show = !valid.wire() | ready;
    let t_denom = words.iter().filter(|(name, _)| name == "t_denom").cloned();
    let divided = numerators.into_iter().chain(t_denom).chain([named("is_hit", is_hit)]).collect();
    let Complete { releases, context: first, weights } = complete(parameters, (ends, context), divided, can_show)?;
    valid.next(releases | (valid.wire() & !ready));
    let hit = keep("u_hits", contexts, (ends, context), words, (releases, first));
    let weights = weights.iter().map(|(name, wire)| named(name, hold(&format!("{name}_q"), releases, *wire)));

    m.output("release_o", releases);
    m.output("context_o", first);
    m.output("valid_o", valid.wire());
    hit.into_iter().chain(weights).for_each(|(name, wire)| m.output(&format!("{name}_o"), wire));
    builder.finish()
}

/// The first ray that has ended, with its weights: where `releases` is 1, its hit is complete and can be shown.
struct Complete<'m> {
    releases: Wire<'m>,
    context: Wire<'m>,
    weights: Named<'m>,
}

/// The rays that have ended, at `ended`, in a queue. With barycentrics, `divided` is kept, and each waits for its
/// weights.
fn complete<'m>(
    parameters: UnitParameters,
    ended: Access<'m>,
    divided: Named<'m>,
    can_show: Wire<'m>,
) -> Result<Complete<'m>, Error> {
    let (UnitParameters { contexts, .. }, (ends, context), m) = (parameters, ended, can_show.builder());
    let takes = m.forward("takes", 1);
    let ended = Inputs::default().port("push", ends).port("context", context).port("pop", takes.wire()).place(
        m,
        "u_ended",
        &queue("raypath_unit_ended", contexts, &[("context", context.width())])?,
    );
    let [valid, first] = ["valid", "context"].map(|name| ended.port(name));
    if !parameters.step.features.barycentrics {
        takes.drive(valid & can_show);
        return Ok(Complete { releases: takes.wire(), context: first, weights: Vec::new() });
    }
    let weights = Inputs::default()
        .port("valid", valid)
        .port("context", first)
        .ports(keep("u_fractions", contexts, (ends, context), divided, (takes.wire(), first)))
        .port("ready", can_show)
        .place(m, "u_weights", &weights(parameters)?);
    takes.drive(weights.port("take"));
    let releases = (weights.port("valid") & can_show).named("releases");
    let words = ["u", "v"].map(|name| named(name, weights.port(name)));
    Ok(Complete { releases, context: weights.port("context"), weights: words.into() })
}
