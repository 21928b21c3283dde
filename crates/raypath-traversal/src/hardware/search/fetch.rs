//! The blocks of searches, in the order in which they were asked for.

use super::super::blocks::{data_words, progress};
use super::super::connect::{Inputs, hold};
use super::super::queue::{bits, queue};
use super::wiring::{BLOCK_SHIFT, BURST_BITS, Burst, WORDS, bit_of, context_bits, one_hot, when};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module `raypath_search_fetch`.
///
/// A burst enters where `burst_valid_i` and `burst_ready_o` are 1: `burst_count_i` blocks from `burst_block_i` on, or a
/// marker, which takes a place in the queue like a block. Requests leave by `req_…`, whose tag is the place in the
/// queue. A beat of a block comes where `rsp_valid_i` is 1, those of a tag in order of addresses.
///
/// The first block of the queue is there where `head_valid_o` is 1, with its burst and whether it is the last of it.
/// Where `take_i` is 1 it is taken: in the next cycle, and until the next is taken, its words are at `word_…_o` and its
/// error at `failed_o`.
pub fn fetch(parameters: SearchParameters, memory_width: u32, address_width: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_fetch");
    let m = &builder;
    let depth = parameters.blocks;
    m.doc(format!("Up to {depth} blocks of searches, in the order in which they were asked for."));
    let (slot, block_bits) = (bits(depth), address_width - BLOCK_SHIFT);
    let fields = [("kind", BURST_BITS), ("context", context_bits(parameters)), ("index", 32)];
    let burst_valid = m.input("burst_valid_i", 1);
    let burst: Vec<Wire<'_>> = fields.iter().map(|(name, width)| m.input(&format!("burst_{name}_i"), *width)).collect();
    let first_block = m.input("burst_block_i", block_bits);
    let count = m.input("burst_count_i", COUNT_BITS);
    let req_ready = m.input("req_ready_i", 1);
    let [rsp_valid, rsp_error] = ["rsp_valid_i", "rsp_error_i"].map(|name| m.input(name, 1));
    let rsp_tag = m.input("rsp_tag_i", slot);
    let data = data_words(m, "data", "_i", memory_width);
    let take = m.input("take_i", 1);

    m.section("The burst, block by block");
    let [pushes, ends] = ["pushes", "ends"].map(|name| m.forward(name, 1));
    let busy = m.register("busy_q", 1).reset_to(0);
    let enters = (burst_valid & (!busy.wire() | ends.wire())).named("enters");
    busy.next(enters | (busy.wire() & !ends.wire()));
    let held: Vec<Wire<'_>> =
        fields.iter().zip(burst).map(|((name, _), wire)| hold(&format!("{name}_q"), enters, wire)).collect();
    let (block, left) = (m.register("block_q", block_bits), m.register("left_q", COUNT_BITS));
    let one = |width| m.constant(width, 1);
    block.next_when(enters | pushes.wire(), enters.mux(first_block, block.wire() + one(block_bits)));
    left.next_when(enters | pushes.wire(), enters.mux(count, left.wire() - one(COUNT_BITS)));
    let is_marker = Burst::marks(held[0]).named("is_marker");
    let is_last = (is_marker | left.wire().is(1)).named("is_last");

    m.section("The queue");
    // One bit more than a place has, so that a full queue differs from an empty one.
    let [head, tail] = ["head_q", "tail_q"].map(|name| m.register(name, slot + 1).reset_to(0));
    let is_full = (head.wire() ^ tail.wire()).is(u64::from(depth)).named("is_full");
    let req_valid = m.register("req_valid_q", 1).reset_to(0);
    let can_request = (is_marker | !req_valid.wire() | req_ready).named("can_request");
    pushes.drive(busy.wire() & !is_full & can_request);
    ends.drive(pushes.wire() & is_last);
    let requests = (pushes.wire() & !is_marker).named("requests");
    req_valid.next(requests | (req_valid.wire() & !req_ready));
    let (place, first) = (tail.wire().lower(slot), head.wire().lower(slot));
    tail.next_when(pushes.wire(), tail.wire() + one(slot + 1));
    head.next_when(take, head.wire() + one(slot + 1));
    let columns: Vec<(&str, u32)> = fields.iter().copied().chain([("last", 1)]).collect();
    let entry = Inputs::default()
        .port("push", pushes.wire())
        .ports(fields.iter().zip(&held).map(|((name, _), wire)| (name.to_string(), *wire)))
        .port("last", is_last)
        .port("pop", take)
        .place(m, "u_entries", &queue("raypath_search_entries", depth, &columns)?);

    m.section("The blocks that have arrived");
    let beats = WORDS * 32 / memory_width;
    let (beat, failed) = if beats == 1 {
        (None, rsp_error)
    } else {
        let name = "raypath_search_progress";
        let (beat, failed) = progress(m, name, depth, beats, [rsp_valid, rsp_tag, rsp_error])?;
        (Some(beat), failed)
    };
    let is_beat = |number: u32| beat.map_or(rsp_valid, |beat| rsp_valid & beat.is(number.into()));
    let arrived = is_beat(beats - 1).named("arrived");
    let is_there = arrivals(m, depth, (arrived, rsp_tag), (pushes.wire() & is_marker, place), (take, first));
    let mut words = Vec::new();
    for number in 0..beats {
        let names: Vec<String> =
            (0..data.len()).map(|k| format!("word_{}", number as usize * data.len() + k)).collect();
        let mut columns: Vec<(&str, u32)> = names.iter().map(|name| (name.as_str(), 32)).collect();
        let mut word = data.clone();
        if number == beats - 1 {
            columns.push(("failed", 1));
            word.push(failed);
        }
        let memory = m.memory(&format!("u_beats_{number}"), depth, &columns);
        memory.write(is_beat(number), rsp_tag, &word);
        words.extend(memory.read(take, first));
    }

    m.output("burst_ready_o", !busy.wire() | ends.wire());
    m.output("req_valid_o", req_valid.wire());
    m.output("req_block_o", hold("req_block_q", requests, block.wire()));
    m.output("req_tag_o", hold("req_tag_q", requests, place));
    m.output("head_valid_o", entry.port("valid") & is_there);
    columns.iter().for_each(|(name, _)| m.output(&format!("head_{name}_o"), entry.port(name)));
    words.iter().take(WORDS as usize).enumerate().for_each(|(k, word)| m.output(&format!("word_{k}_o"), *word));
    m.output("failed_o", words[WORDS as usize]);
    builder.finish()
}

/// Bits of the number of a burst's blocks, which is at most 256.
pub const COUNT_BITS: u32 = 9;

/// Whether the first block has arrived: a bit for each place, set by a block or a marker, and cleared where the first is
/// taken.
fn arrivals<'m>(
    m: &'m Builder,
    depth: u32,
    (arrived, tag): (Wire<'m>, Wire<'m>),
    (marks, place): (Wire<'m>, Wire<'m>),
    (take, first): (Wire<'m>, Wire<'m>),
) -> Wire<'m> {
    let group = depth.min(64);
    let within = bits(group);
    let found = (0..depth / group).map(|number| {
        let here = |enable: Wire<'m>, at: Wire<'m>| {
            let is_here =
                if depth == group { enable } else { enable & at.upper(at.width() - within).is(number.into()) };
            when(is_here, one_hot(at.lower(within), group))
        };
        let register = m.register(&format!("arrived_{number}_q"), group).reset_to(0);
        let set = here(arrived, tag) | here(marks, place);
        register.next((register.wire() | set) & !here(take, first));
        bit_of(register.wire(), first.lower(within))
    });
    let found: Vec<Wire<'m>> = found.collect();
    let is_there = if depth == group { found[0] } else { first.upper(first.width() - within).select(&found) };
    is_there.named("is_there")
}
