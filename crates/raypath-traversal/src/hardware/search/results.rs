//! The distances of neighbours, and the channel of results.

use super::super::connect::{Inputs, delay, delay_by, hold, keep, named};
use super::super::queue::{count_words, queue};
use super::wiring::{context_bits, rank_of_key};
use crate::search::SearchParameters;
use raypath_float::{DivSqrt, Format, Product, decode, encode, mul};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// Neighbours that wait for their distances.
pub const WAITING: u32 = 64;

/// The digits of a root or a quotient in a cycle.
pub const DIGITS: u32 = 2;

/// The module `raypath_search_results`.
///
/// A neighbour or an end comes where `found_valid_i` and `found_ready_o` are 1. The distance of a neighbour takes two
/// operations: a root and the scale, the scale twice, or, for a cosine, a quotient and a root. A result is shown where
/// `result_valid_o` is 1, until `result_ready_i` is 1: the job's number, the result's number, the vector's index and
/// distance, whether it `is_last_o`, and then its status. A job without neighbours has one result, in which `found_o` is 0.
/// Where `release_o` is 1, the search of `context_o` is over.
///
/// The job's number is written where `enter_i` is 1, its metric and scale where `load_i` is 1, and the key of its query's
/// norm where `is_norm_i` is 1.
pub fn results(parameters: SearchParameters, id_width: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_results");
    let m = &builder;
    m.doc("The distances of neighbours, and the results of searches.");
    let (width, contexts) = (context_bits(parameters), parameters.contexts);
    let at = |name: &str| {
        let [enable, context] = [(name.to_string(), 1), (format!("{name}_context"), width)]
            .map(|(name, width)| m.input(&format!("{name}_i"), width));
        (enable, context)
    };
    let (enter, load, norm) = (at("enter"), at("load"), at("norm"));
    let id = m.input("enter_id_i", id_width);
    let (metric, scale) = (m.input("load_metric_i", 2), m.input("load_scale_i", 32));
    let norm_key = m.input("norm_key_i", 32);
    let columns = [("context", width), ("key", 32), ("index", 32), ("is_end", 1), ("status", 2)];
    let valid = m.input("found_valid_i", 1);
    let found: Vec<Wire<'_>> =
        columns.iter().map(|(name, width)| m.input(&format!("found_{name}_i"), *width)).collect();
    let ready = m.input("result_ready_i", 1);

    m.section("Neighbours and ends that wait");
    let (pops, can_push) = (m.forward("pops", 1), m.forward("can_push", 1));
    let push = (valid & can_push.wire()).named("push");
    let count = m.register("count_q", WAITING.ilog2() + 1).reset_to(0);
    count_words(count, push, pops.wire());
    can_push.drive(!count.wire().top());
    let first = Inputs::default()
        .port("push", push)
        .ports(columns.iter().zip(found).map(|((name, _), wire)| (name.to_string(), wire)))
        .port("pop", pops.wire())
        .place(m, "u_found", &queue("raypath_search_found", WAITING, &columns)?);
    let is_end = (first.port("valid") & first.port("is_end")).named("is_end");

    m.section("The neighbour whose distance is computed");
    let busy = m.register("busy_q", 1).reset_to(0);
    let leaves = m.forward("leaves", 1);
    let take = (first.port("valid") & !is_end & !busy.wire()).named("take");
    busy.next(take | (busy.wire() & !leaves.wire()));
    let context = first.port("context");
    let [held_context, key, index] =
        [("context_q", context), ("key_q", first.port("key")), ("index_q", first.port("index"))]
            .map(|(name, wire)| hold(name, take, wire));
    let read = ((first.port("valid") & !busy.wire()).named("reads"), context);
    let of_load = vec![named("metric", metric), named("scale", scale)];
    let of_load = keep("u_metrics", contexts, load, of_load, read);
    let (metric, scale) = (of_load[0].1, of_load[1].1);
    let norm_key = keep("u_norms", contexts, norm, vec![named("key", norm_key)], read)[0].1;
    let id = keep("u_ids", contexts, enter, vec![named("id", id)], read)[0].1;

    m.section("Its distance, by two operations");
    let [is_second, is_done, waits] =
        ["is_second_q", "is_done_q", "waits_q"].map(|name| m.register(name, 1).reset_to(0));
    let value = m.register("value_q", 32);
    let is_fresh = m.register("is_fresh_q", 1);
    let rank = rank_of_key(key).named("rank");
    let is_cosine = metric.is(2).named("is_cosine");
    let is_dot = metric.is(1).named("is_dot");
    let sign = is_dot & !rank.top() & rank.any();
    let magnitude = m.concat(&[sign, rank.lower(31)]);
    let operand = is_fresh.wire().mux(magnitude, value.wire()).named("operand");
    let works = (busy.wire() & !is_done.wire() & !waits.wire()).named("works");
    let is_scaled = (is_dot | (!is_cosine & is_second.wire())).named("is_scaled");
    let encoder = encode(Format::BINARY32)?;
    let recoded = |name: &str, number| m.instance(name, &encoder, &[("ieee_i", number)])[0];
    let other = is_scaled.mux(scale, rank_of_key(norm_key));
    let (a, b) = (recoded("u_encode_operand", operand), recoded("u_encode_other", other));
    // The encoder, the multiplier and the decoder have a cycle each.
    let factors = [("a_i", delay("operand_recoded_q", a)), ("b_i", delay("other_recoded_q", b))];
    let product = m.instance("u_multiply", &mul(Format::BINARY32, Product::Booth, false)?, &factors)[0];
    let product = delay("product_q", product);
    let has_product = delay_by(2, "has_product_q", works & is_scaled, Some(0));
    let is_root = !is_cosine | is_second.wire();
    let root = Inputs::default()
        .port("valid", works & !is_scaled)
        .port("ready", m.constant(1, 1))
        .port("a", a)
        .port("b", b)
        .port("is_root", is_root)
        .place(m, "u_divide", &DivSqrt::QuotientOrRoot.iterative(Format::BINARY32, DIGITS, 0)?);
    let has_root = (root.port("valid") & waits.wire()).named("has_root");
    let result = has_root.mux(root.port("result"), product);
    let result = m.instance("u_decode_result", &decode(Format::BINARY32)?, &[("recoded_i", result)])[0];
    let has_result = (has_product | has_root).named("has_result");
    waits.next((works & (is_scaled | root.port("ready"))) | (waits.wire() & !has_result));
    is_fresh.next(take | (is_fresh.wire() & !has_result));
    is_second.next((is_second.wire() ^ has_result) & busy.wire());
    is_done.next((has_result & is_second.wire()) | (is_done.wire() & !leaves.wire()));
    value.next_when(has_result, result);

    m.section("The result, which is shown when it is known whether it is the last");
    let is_none = m.register("is_none_q", 1).reset_to(0);
    let is_shown = ((is_done.wire() & first.port("valid")) | is_none.wire()).named("is_shown");
    leaves.drive(is_shown & ready & !is_none.wire());
    let is_last = is_end;
    let ends = (is_shown & ready & is_last).named("ends");
    is_none.next(((is_end & !busy.wire()) | is_none.wire()) & !ends);
    pops.drive(take | ends);
    let number = m.register("number_q", 8).reset_to(0);
    let shown = is_shown & ready;
    number.next_when(shown, is_last.mux(m.constant(8, 0), number.wire() + m.constant(8, 1)));
    let is_negative = (is_cosine & !rank.top() & rank.any()).named("is_negative");

    m.output("found_ready_o", can_push.wire());
    m.output("result_valid_o", is_shown);
    m.output("result_id_o", id);
    m.output("result_rank_o", number.wire());
    m.output("result_index_o", index);
    m.output("result_distance_o", m.concat(&[value.wire().top() | is_negative, value.wire().lower(31)]));
    m.output("result_found_o", !is_none.wire());
    m.output("result_status_o", first.port("status"));
    m.output("result_last_o", is_last);
    m.output("release_o", ends);
    m.output("context_o", is_none.wire().mux(context, held_context));
    builder.finish()
}
