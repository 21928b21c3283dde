//! What drops the vectors that are too far away, one a cycle, before the list.

use super::super::connect::{Inputs, delay_by, hold, keep, named};
use super::super::queue::queue;
use super::wiring::{BURST_BITS, Burst, context_bits};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// Vectors and markers that wait for the list.
pub const WAITING: u32 = 16;

/// The fields of a vector or a marker.
pub fn fields(parameters: SearchParameters) -> [(&'static str, u32); 5] {
    [("kind", BURST_BITS), ("context", context_bits(parameters)), ("index", 32), ("key", 32), ("failed", 1)]
}

/// The module `raypath_search_filter`. Vectors and markers come where `valid_i` is 1, and are taken where `taken_o` is 1.
/// They leave in that order where `next_valid_o` and `next_taken_i` are 1, but for vectors without a rank and those behind
/// the limit of their search, in the order of keys and indices. A limit is written where `limits_i` is 1. A vector that
/// was taken before may be compared with the limit before.
pub fn filter(parameters: SearchParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_filter");
    let m = &builder;
    m.doc("Vectors that may be among the best of their search, and markers.");
    let (valid, is_rank) = (m.input("valid_i", 1), m.input("is_rank_i", 1));
    let fields = fields(parameters);
    let next: Vec<Wire<'_>> = fields.iter().map(|(name, width)| m.input(&format!("{name}_i"), *width)).collect();
    let limits = (m.input("limits_i", 1), m.input("limit_context_i", context_bits(parameters)));
    let limit = m.input("limit_i", 64);
    let next_taken = m.input("next_taken_i", 1);

    m.section("Its limit is read");
    let pops = m.forward("pops", 1);
    let count = m.register("count_q", WAITING.ilog2() + 1).reset_to(0);
    let take = (valid & !count.wire().top()).named("take");
    let limit = keep("u_limits", parameters.contexts, limits, vec![named("limit", limit)], (take, next[1]));
    let held: Vec<Wire<'_>> =
        fields.iter().zip(next).map(|((name, _), wire)| hold(&format!("{name}_q"), take, wire)).collect();
    let is_rank = hold("is_rank_q", take, is_rank);
    let is_taken = delay_by(1, "is_taken_q", take, Some(0));

    m.section("It is kept or dropped");
    let is_too_far = limit[0].1.less(m.concat(&[held[3], held[2]])).named("is_too_far");
    let keeps = (is_taken & (Burst::marks(held[0]) | (is_rank & !is_too_far))).named("keeps");
    let drops = (is_taken & !keeps).named("drops");
    // The words that are in the queue or on the way to it.
    let leaves = m.concat(&[m.constant(1, 0), pops.wire()]) + m.concat(&[m.constant(1, 0), drops]);
    let width = count.wire().width();
    count.next(count.wire() + take.extend(width) - leaves.extend(width));
    let queue = Inputs::default()
        .port("push", keeps)
        .ports(fields.iter().zip(held).map(|((name, _), wire)| (name.to_string(), wire)))
        .port("pop", pops.wire())
        .place(m, "u_kept", &queue("raypath_search_kept", WAITING, &fields)?);
    pops.drive(queue.port("valid") & next_taken);

    m.output("taken_o", take);
    m.output("next_valid_o", queue.port("valid"));
    fields.iter().for_each(|(name, _)| m.output(&format!("next_{name}_o"), queue.port(name)));
    builder.finish()
}
