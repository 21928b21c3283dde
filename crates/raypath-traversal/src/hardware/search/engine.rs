//! The parts of searches, connected.

use super::super::blocks::data_words;
use super::super::connect::{Inputs, named, prefixed};
use super::super::queue::bits;
use super::beats::{LANES, beats};
use super::branches::{BRANCH, branches};
use super::fetch::fetch;
use super::filter::filter;
use super::list::list;
use super::ranks::ranks;
use super::results::results;
use super::turns::turns;
use super::wiring::{BLOCK_BITS, BLOCK_SHIFT, WORDS, context_bits};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// What searches need of the unit around them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchPorts {
    /// Bits of a beat of the memory: 128, 256 or 512.
    pub memory_width: u32,
    /// Bits of an address: 32 to 64.
    pub address_width: u32,
    /// Bits of a job's number: 1 to 64.
    pub id_width: u32,
    /// Cycles of a division: 1 to 27.
    pub divider_latency: u32,
}

/// The module `raypath_search`: searches beside a datapath.
///
/// A job enters by `search_…`: the address of its words, a multiple of 64, and a number, which its results have. Results
/// leave by `result_…`. Blocks of 64 bytes are read by `vec_req_…` and `vec_rsp_…`. Beats go to the datapath by
/// `beat_…`; the outcome of the last beat of a vector comes where `outcome_valid_i` is 1, at least two cycles later and in
/// order, and never waits. With trees, nodes are among the beats (`beat_is_node_o`), and their outcomes come where
/// `outcome_tested_i` is 1.
pub fn search_engine(parameters: SearchParameters, ports: SearchPorts) -> Result<Arc<Module>, Error> {
    let SearchPorts { memory_width, address_width, id_width, divider_latency } = ports;
    let builder = Builder::new("raypath_search");
    let m = &builder;
    m.doc("Searches: a job goes in, the nearest vectors come out.");
    m.doc(format!("{parameters}."));
    let (width, base_bits) = (context_bits(parameters), address_width - 32);
    let search_valid = m.input("search_valid_i", 1);
    let search_id = m.input("search_id_i", id_width);
    let search_job = m.input("search_job_i", 32);
    let search_base = (base_bits > 0).then(|| m.input("search_base_i", base_bits));
    let result_ready = m.input("result_ready_i", 1);
    let req_ready = m.input("vec_req_ready_i", 1);
    let [rsp_valid, rsp_error] = ["valid", "error"].map(|name| m.input(&format!("vec_rsp_{name}_i"), 1));
    let rsp_tag = m.input("vec_rsp_tag_i", bits(parameters.blocks));
    let data = data_words(m, "vec_rsp_data", "_i", memory_width);
    let beat_ready = m.input("beat_ready_i", 1);
    let outcome_valid = m.input("outcome_valid_i", 1);
    let sums = ["squares", "dot", "norm"].map(|name| named(name, m.input(&format!("outcome_{name}_i"), 32)));
    let has_trees = parameters.has_trees();
    let tested = has_trees.then(|| {
        let of_node = [("tested", 1), ("inside", 4), ("child", 6)];
        of_node.map(|(name, width)| m.input(&format!("outcome_{name}_i"), width))
    });
    m.unused("unused_job", &[search_job.lower(BLOCK_SHIFT)]);

    m.section("Turns, and the blocks that they ask for");
    let forward = |name: &str, width| m.forward(name, width);
    let [release, loads, list_valid, expands, burst_ready, take] =
        ["releases", "loads", "list_valid", "expands", "burst_ready", "take"].map(|name| forward(name, 1));
    let [release_context, block_context, expands_context] =
        ["release_context", "block_context", "expands_context"].map(|name| forward(name, width));
    let (list_half, expands_index) = (forward("list_half", 1), forward("expands_index", BLOCK_BITS));
    let failed = forward("failed", parameters.contexts);
    let of_branch = BRANCH.map(|(name, width)| (format!("next_{name}"), width)).into_iter();
    let events = [("next_is_there", 1), ("visited", 1), ("visited_context", width)];
    let branch: Vec<_> = of_branch
        .chain(events.map(|(name, width)| (name.to_string(), width)))
        .filter(|_| has_trees)
        .map(|(name, width)| (forward(&name, width), name))
        .collect();
    let overflowed = has_trees.then(|| forward("overflowed", parameters.contexts));
    let words: Vec<_> = (0..WORDS).map(|k| (format!("word_{k}"), forward(&format!("word_{k}"), 32))).collect();
    let word_wires: Vec<(String, Wire<'_>)> = words.iter().map(|(name, word)| named(name, word.wire())).collect();
    let turns = Inputs::default()
        .port("enter_valid", search_valid)
        .port("enter_block", search_job.upper(32 - BLOCK_SHIFT))
        .ports(search_base.map(|base| named("enter_base", base)))
        .port("release", release.wire())
        .port("release_context", release_context.wire())
        .port("load", loads.wire())
        .port("block_context", block_context.wire())
        .port("list_valid", list_valid.wire())
        .port("list_half", list_half.wire())
        .ports(word_wires.clone())
        .port("expands", expands.wire())
        .port("expands_context", expands_context.wire())
        .port("expands_index", expands_index.wire())
        .port("failed", failed.wire())
        .ports(branch.iter().map(|(forward, name)| named(name, forward.wire())))
        .port("burst_ready", burst_ready.wire())
        .place(m, "u_turns", &turns(parameters, address_width)?);
    let fetch = Inputs::default()
        .ports(prefixed("burst", turns.under("burst")))
        .port("req_ready", req_ready)
        .port("rsp_valid", rsp_valid)
        .port("rsp_error", rsp_error)
        .port("rsp_tag", rsp_tag)
        .ports(data.iter().enumerate().map(|(k, word)| named(&format!("data_{k}"), *word)))
        .port("take", take.wire())
        .place(m, "u_fetch", &fetch(parameters, memory_width, address_width)?);
    burst_ready.drive(fetch.port("burst_ready"));
    words.iter().for_each(|(name, word)| word.drive(fetch.port(name)));

    m.section("Beats, and the ranks that follow from their outcomes");
    let [job_ready, can_send, list_takes, found_ready] =
        ["job_ready", "can_send", "list_takes", "found_ready"].map(|name| forward(name, 1));
    let beats = Inputs::default()
        .ports(prefixed("head", fetch.under("head")))
        .ports(word_wires)
        .port("failed", fetch.port("failed"))
        .port("job_ready", job_ready.wire())
        .port("beat_ready", beat_ready)
        .port("can_send", can_send.wire())
        .ports(overflowed.map(|forward| named("overflowed", forward.wire())))
        .place(m, "u_beats", &beats(parameters)?);
    take.drive(beats.port("take"));
    failed.drive(beats.port("failed"));
    block_context.drive(beats.port("context"));
    list_valid.drive(beats.port("list_valid"));
    list_half.drive(beats.port("index").bit(0));
    if let (Some([tested, inside, child]), Some(overflowed)) = (tested, overflowed) {
        m.section("The nodes of trees");
        let branches = Inputs::default()
            .port("sent", beats.port("node_sent"))
            .port("context", beats.port("context"))
            .port("first", words[14].1.wire())
            .port("is_leaf", words[15].1.wire().bit(0))
            .port("is_keys", beats.port("is_keys"))
            .port("is_last", beats.port("index").bit(0))
            .port("valid", tested)
            .port("inside", inside)
            .port("child", child)
            .port("enter", turns.port("entered"))
            .port("enter_context", turns.port("entered_context"))
            .port("read", turns.port("picks"))
            .port("read_context", turns.port("picked_context"))
            .port("pop", turns.port("pops"))
            .port("pop_context", turns.port("own_context"))
            .place(m, "u_branches", &branches(parameters)?);
        branch.iter().for_each(|(forward, name)| forward.drive(branches.port(name)));
        overflowed.drive(branches.port("overflowed"));
        m.section("Ranks");
    }
    let [limits, filter_takes] = ["limits", "filter_takes"].map(|name| forward(name, 1));
    let (limit_context, limit) = (forward("limit_context", width), forward("limit", 64));
    let ranks = Inputs::default()
        .port("sent", beats.port("sent"))
        .ports(["kind", "context", "index", "code"].map(|name| named(name, beats.port(name))))
        .port("failed", beats.port("has_failed"))
        .port("valid", outcome_valid)
        .ports(sums)
        .port("taken", filter_takes.wire())
        .place(m, "u_ranks", &ranks(parameters, divider_latency)?);
    can_send.drive(ranks.port("can_send"));
    let filter = Inputs::default()
        .ports(
            ["valid", "kind", "context", "index", "key", "is_rank", "failed"].map(|name| named(name, ranks.port(name))),
        )
        .port("limits", limits.wire())
        .port("limit_context", limit_context.wire())
        .port("limit", limit.wire())
        .port("next_taken", list_takes.wire())
        .place(m, "u_filter", &filter(parameters)?);
    filter_takes.drive(filter.port("taken"));

    m.section("The best candidates, and results");
    let next = filter.under("next");
    let list = Inputs::default()
        .port("clear_valid", beats.port("job_valid"))
        .port("clear_context", beats.port("context"))
        .ports(
            ["bound", "candidate", "neighbour", "refused"]
                .map(|name| named(&format!("clear_{name}"), turns.port(name))),
        )
        .ports(next)
        .port("found_ready", found_ready.wire())
        .place(m, "u_list", &list(parameters)?);
    limits.drive(list.port("limits"));
    limit_context.drive(list.port("limit_context"));
    limit.drive(list.port("limit"));
    job_ready.drive(list.port("clear_ready"));
    loads.drive(beats.port("job_valid") & list.port("clear_ready"));
    list_takes.drive(list.port("taken"));
    expands.drive(list.port("expands"));
    expands_context.drive(list.port("context"));
    expands_index.drive(list.port("index"));
    let found = prefixed("found", list.under("found"));
    let results = Inputs::default()
        .port("enter", search_valid & turns.port("enter_ready"))
        .port("enter_context", turns.port("entered_context"))
        .port("enter_id", search_id)
        .port("load", loads.wire())
        .port("load_context", beats.port("context"))
        .port("load_metric", turns.port("metric"))
        .port("load_scale", turns.port("scale"))
        .port("norm", ranks.port("is_norm"))
        .port("norm_context", ranks.port("context"))
        .port("norm_key", ranks.port("key"))
        .port("found_context", list.port("context"))
        .ports(found)
        .port("result_ready", result_ready)
        .place(m, "u_results", &results(parameters, id_width)?);
    found_ready.drive(results.port("found_ready"));
    release.drive(results.port("release"));
    release_context.drive(results.port("context"));

    m.output("search_ready_o", turns.port("enter_ready"));
    results.under("result").into_iter().for_each(|(name, wire)| m.output(&format!("result_{name}_o"), wire));
    m.output("vec_req_valid_o", fetch.port("req_valid"));
    m.output("vec_req_addr_o", m.concat(&[fetch.port("req_block"), m.constant(BLOCK_SHIFT, 0)]));
    m.output("vec_req_tag_o", fetch.port("req_tag"));
    m.output("beat_valid_o", beats.port("beat_valid"));
    for (stem, count) in [("a", LANES), ("b", LANES), ("mask", LANES)] {
        (0..count).for_each(|lane| m.output(&format!("beat_{stem}_{lane}_o"), beats.port(&format!("{stem}_{lane}"))));
    }
    m.output("beat_is_last_o", beats.port("is_last"));
    m.output("beat_is_angular_o", beats.port("is_angular"));
    if has_trees {
        m.output("beat_is_node_o", beats.port("is_node"));
        m.output("beat_is_keys_o", beats.port("is_keys"));
        beats.under("node").into_iter().filter(|(name, _)| name != "sent").for_each(|(name, wire)| {
            m.output(&format!("beat_node_{name}_o"), wire);
        });
    }
    m.output("is_idle_o", turns.port("is_idle"));
    builder.finish()
}
