//! The ranks of vectors.

use super::super::connect::{Inputs, delay, delay_by};
use super::super::division::{Division, Operands, divide};
use super::super::queue::{count_words, queue};
use super::beats::NORM;
use super::wiring::{BURST_BITS, Burst, context_bits, key_of};
use crate::search::SearchParameters;
use raypath_float::{Format, Product, decode, encode, mul};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The most vectors and markers between the beats and the list.
pub const IN_FLIGHT: u32 = 128;

/// The module `raypath_search_ranks`.
///
/// A vector or a marker is sent where `sent_i` is 1, and the outcome of a vector's last beat comes where `valid_i` is 1,
/// in the order in which vectors were sent. They leave in that order where `valid_o` and `taken_i` are 1: a marker, or a
/// vector with the key of its rank and whether there `is_rank_o`. The key of a query's norm leaves where `is_norm_o` is
/// 1. Outcomes never wait: `can_send_o` says that there is a place for one more.
pub fn ranks(parameters: SearchParameters, divider_latency: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_ranks");
    let m = &builder;
    m.doc("The ranks of vectors, in the order of the vectors and markers that were sent.");
    let sent = m.input("sent_i", 1);
    let fields = [("kind", BURST_BITS), ("context", context_bits(parameters)), ("index", 32), ("failed", 1)];
    let of_sent: Vec<Wire<'_>> = fields.iter().map(|(name, width)| m.input(&format!("{name}_i"), *width)).collect();
    let of_sent_kind = of_sent[0];
    let (valid, next_code) = (m.input("valid_i", 1), m.input("code_i", 2));
    let [squares, dot, norm] = ["squares_i", "dot_i", "norm_i"].map(|name| m.input(name, 32));
    let taken = m.input("taken_i", 1);

    m.section("What was sent and has not left");
    let pops = m.forward("pops", 1);
    let count = m.register("count_q", IN_FLIGHT.ilog2() + 1).reset_to(0);
    count_words(count, sent, pops.wire());
    let first = Inputs::default()
        .port("push", sent)
        .ports(fields.iter().zip(of_sent).map(|((name, _), wire)| (name.to_string(), wire)))
        .port("pop", pops.wire())
        .place(m, "u_sent", &queue("raypath_search_sent", IN_FLIGHT, &fields)?);

    let is_vector = sent & !Burst::marks(of_sent_kind);
    let code = Inputs::default().port("push", is_vector).port("code", next_code).port("pop", valid).place(
        m,
        "u_codes",
        &queue("raypath_search_codes", IN_FLIGHT, &[("code", 2)])?,
    );
    let code = code.port("code").comment("an outcome comes later than its code");

    m.section("The quotient of dot product and norm, which the cosine's rank needs");
    let is_euclidean = code.is(0).named("is_euclidean");
    let sum = is_euclidean.mux(squares, code.is(NORM).mux(norm, dot)).named("sum");
    let operands = Operands { valid, dividend: dot, divisor: norm, tag: vec![code, sum] };
    let Division { valid, quotient, tag, .. } = divide(divider_latency, operands, None)?;

    m.section("Times the magnitude of the dot product");
    let valid = delay_by(1, "has_quotient_q", valid, Some(0));
    let (quotient, tag) = (delay("quotient_q", quotient), delay("tag_q", tag));
    let sum = tag.lower(32);
    let encoder = encode(Format::BINARY32)?;
    // The encoder, the multiplier and the decoder have a cycle each.
    let recoded = |name: &str, number| {
        let recoded = m.instance(&format!("u_encode_{name}"), &encoder, &[("ieee_i", number)])[0];
        delay(&format!("{name}_recoded_q"), recoded)
    };
    let magnitude = sum & m.constant(32, 0x7fff_ffff);
    let factors = [("a_i", recoded("quotient", quotient)), ("b_i", recoded("sum", magnitude))];
    let product = m.instance("u_multiply", &mul(Format::BINARY32, Product::Booth, false)?, &factors)[0];
    let product = delay("product_q", product);
    let tag = delay_by(2, "product_tag_q", tag, None);
    let (code, sum) = (tag.upper(2), tag.lower(32));
    let product = m.instance("u_decode_product", &decode(Format::BINARY32)?, &[("recoded_i", product)])[0];

    m.section("The key of the rank");
    let is_cosine = code.is(2).named("is_cosine");
    let rank = is_cosine.mux(product, sum);
    let is_negated = (code.is(1) | is_cosine).named("is_negated");
    let rest = rank.lower(31);
    let sign = (rank.top() ^ is_negated) & rest.any();
    let key = delay("key_q", key_of(m.concat(&[sign, rest])));
    let is_rank = delay("is_rank_q", !m.constant(31, 0x7f80_0000).less(rest));
    let has_key = delay_by(3, "has_key_q", valid, Some(0));
    let columns = [("key", 32), ("is_rank", 1)];
    let pops_key = m.forward("pops_key", 1);
    let keys = Inputs::default()
        .port("push", has_key)
        .port("key", key)
        .port("is_rank", is_rank)
        .port("pop", pops_key.wire())
        .place(m, "u_keys", &queue("raypath_search_keys", IN_FLIGHT, &columns)?);

    m.section("The first of them");
    let kind = first.port("kind");
    let is_marker = Burst::marks(kind).named("is_marker");
    let is_norm = Burst::Norm.is(kind).named("is_norm");
    let is_there = (first.port("valid") & (is_marker | keys.port("valid"))).named("is_there");
    let offers = (is_there & !is_norm).named("offers");
    pops.drive((offers & taken) | (is_there & is_norm));
    pops_key.drive(pops.wire() & !is_marker);

    m.output("can_send_o", !count.wire().top());
    m.output("valid_o", offers);
    m.output("is_norm_o", is_there & is_norm);
    fields.iter().for_each(|(name, _)| m.output(&format!("{name}_o"), first.port(name)));
    m.output("key_o", keys.port("key"));
    m.output("is_rank_o", keys.port("is_rank"));
    builder.finish()
}
