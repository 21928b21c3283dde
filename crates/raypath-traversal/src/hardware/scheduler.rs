//! Which answer is the next step's.

use crate::step::UnitFeatures;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The sources of answers, in the order of the bits of `request_i` and `grant_o`. The last needs candidates.
const SOURCES: [&str; 6] = ["boxes", "block", "fault", "start", "continue", "verdict"];

/// The sources of a unit with these features.
pub fn sources(features: UnitFeatures) -> &'static [&'static str] {
    if features.has_candidates() { &SOURCES } else { &SOURCES[..5] }
}

/// The module `raypath_unit_scheduler`: `grant_o` has one bit of `request_i`. The first source after the one that was
/// granted last is granted, in a circle, so that a source waits for at most one step of each other source.
pub fn scheduler(features: UnitFeatures) -> Result<Arc<Module>, Error> {
    let sources = sources(features);
    let count = sources.len() as u32;
    let builder = Builder::new("raypath_unit_scheduler");
    let m = &builder;
    m.doc("Which answer is the next step's: that of the first source after the one that was granted last.");
    m.doc(format!("The sources, from bit 0 on: {}.", sources.join(", ")));
    let request = m.input("request_i", count);
    let grant = after_last(request, request.any());
    m.output("grant_o", grant);
    builder.finish()
}

/// One bit of `request`: the first after the one that was granted last, in a circle. A grant counts where `takes` is 1.
pub fn after_last<'m>(request: Wire<'m>, takes: Wire<'m>) -> Wire<'m> {
    let (m, count) = (request.builder(), request.width());
    // The first is after none.
    let after = m.register("after_q", count - 1).reset_to(0);
    let later = (request.upper(count - 1) & after.wire()).named("later");
    let first_later = m.concat(&[lowest(later), m.constant(1, 0)]);
    let grant = later.any().mux(first_later, lowest(request)).named("grant").comment("x & (~x + 1): the lowest bit");
    let is_after = |source: u32| if source == 1 { grant.bit(0) } else { grant.lower(source).any() };
    let behind: Vec<Wire<'m>> = (1..count).rev().map(is_after).collect();
    after.next_when(takes, m.concat(&behind));
    grant
}

/// The lowest bit of a word.
pub fn lowest(word: Wire<'_>) -> Wire<'_> {
    word & (!word + word.builder().constant(word.width(), 1))
}
