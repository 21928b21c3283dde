//! The hits of rays that have ended.

use super::connect::{Inputs, Named, keep, named};
use super::queue::{bits, queue};
use crate::state::status;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The values of a hit, by the field of the ray's state, and whether each is 0 for rays without a hit.
const VALUES: [(&str, &str, u32, bool); 7] = [
    ("t", "extent", 32, true),
    ("triangle", "triangle", 32, true),
    ("t_num", "t_num", 32, true),
    ("t_denom", "t_denom", 32, true),
    ("back_face", "back_face", 1, true),
    ("nodes", "nodes", 32, false),
    ("triangles", "triangles", 32, false),
];

/// Whether a hit shows this field of the ray's state.
pub fn is_shown(field: &str) -> bool {
    VALUES.iter().any(|(_, known, ..)| *known == field)
}

/// The module `raypath_unit_hits`. A ray ends where `ends_i` is 1, in the state `next_…_i` with `status_i`. Its hit
/// waits for `ready_i`: `valid_o`, `status_o` and a port for each value. Where `release_o` is 1, the context
/// `context_o` is free from the next cycle on.
pub fn hits(contexts: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_hits");
    let m = &builder;
    m.doc("The hits of rays that have ended, in the order of their ends.");
    let width = bits(contexts);
    let ends = m.input("ends_i", 1);
    let context = m.input("context_i", width);
    let status_word = m.input("status_i", 2);
    let ready = m.input("ready_i", 1);
    let is_hit = status_word.is(status::HIT.into()).named("is_hit");
    let value = |(name, field, width, is_of_hit): (&str, &str, u32, bool)| {
        let state = m.input(&format!("next_{field}_i"), width);
        named(name, if is_of_hit { state & is_hit.replicate(width) } else { state })
    };
    let words: Named<'_> = [named("status", status_word)].into_iter().chain(VALUES.map(value)).collect();

    let release = m.forward("takes", 1);
    let waiting = Inputs::default().port("push", ends).port("context", context).port("pop", release.wire()).place(
        m,
        "u_ended",
        &queue("raypath_unit_ended", contexts, &[("context", width)])?,
    );
    let valid = m.register("valid_q", 1).reset_to(0);
    release.drive(waiting.port("valid") & (!valid.wire() | ready));
    valid.next(release.wire() | (valid.wire() & !ready));
    let hit = keep("u_hits", contexts, (ends, context), words, (release.wire(), waiting.port("context")));

    m.output("release_o", release.wire());
    m.output("context_o", waiting.port("context"));
    m.output("valid_o", valid.wire());
    hit.into_iter().for_each(|(name, wire)| m.output(&format!("{name}_o"), wire));
    builder.finish()
}
