//! The beats of vectors, and where other blocks go.

use super::super::connect::{hold, keep, named};
use super::widen::widen;
use super::wiring::{BURST_BITS, Burst, WORDS, bit_of, context_bits, one_hot, vector_block_bits};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// Lanes of a Euclidean beat; an angular beat has half as many.
pub const LANES: usize = 16;

/// What a datapath's outcome is for: the metric's code, or this for a query's norm.
pub const NORM: u64 = 3;

/// The module `raypath_search_beats`.
///
/// It takes the first block of the queue (`head_…_i`, `take_o`), whose words and error come in the next cycle. The words
/// of a block go on to all readers at `word_…_o`, with the number of its search, `context_o`, and its index `index_o`:
/// where `job_valid_o` and `job_ready_i` are 1, a job, of which `job_failed_o` says that it could not be read; where
/// `list_valid_o` is 1, a list. Queries are kept here. `failed_o` has a bit for each search of which a block failed: no
/// more of its vectors are sent; with trees, it has those of `overflowed_i`.
///
/// A beat is offered where `beat_valid_o` is 1, until `beat_ready_i` is 1: its lanes, `a_…_o` of the query and `b_…_o` of
/// the vector, `mask_…_o`, whether it `is_last_o` of its vector, and `is_angular_o`. With the last beat, and for
/// each marker, `sent_o` is 1, with kind, context, index, what the outcome is for, `code_o`, and whether the search has failed. `can_send_i` says that it
/// may be.
///
/// With trees, a node is offered in the same way where `is_node_o` is 1: its words are `node_…_o` and those of `b_…_o`, and
/// the first words of the query's block are those of `a_…_o`. It leaves where `node_sent_o` is 1, and `is_keys_o` says
/// whether it is one of keys.
pub fn beats(parameters: SearchParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_beats");
    let m = &builder;
    m.doc("Blocks become beats of the datapath, or go to where they are kept.");
    let (width, contexts) = (context_bits(parameters), parameters.contexts);
    let head_valid = m.input("head_valid_i", 1);
    let [kind, context, index, last] = [("kind", BURST_BITS), ("context", width), ("index", 32), ("last", 1)]
        .map(|(name, width)| m.input(&format!("head_{name}_i"), width));
    let words: Vec<Wire<'_>> = (0..WORDS).map(|k| m.input(&format!("word_{k}_i"), 32)).collect();
    let block_failed = m.input("failed_i", 1);
    let [job_ready, beat_ready, can_send] = ["job_ready_i", "beat_ready_i", "can_send_i"].map(|name| m.input(name, 1));
    let has_trees = parameters.has_trees();
    let overflowed = if has_trees { m.input("overflowed_i", contexts) } else { m.constant(contexts, 0) };

    m.section("The block that was taken");
    let busy = m.register("busy_q", 1).reset_to(0);
    let ends = m.forward("ends", 1);
    let keeps_query = m.forward("keeps_query", 1);
    let take = (head_valid & (!busy.wire() | ends.wire()) & !keeps_query.wire()).named("take");
    keeps_query.wire().comment("a vector behind it reads the query in the cycle in which it is taken");
    busy.next(take | (busy.wire() & !ends.wire()));
    let before = context;
    let (next_context, next_kind) = (context, kind);
    let [kind, context, index, last] = [("kind_q", kind), ("context_q", before), ("index_q", index), ("last_q", last)]
        .map(|(name, wire)| hold(name, take, wire));
    let is = |burst: Burst, name: &str| (busy.wire() & burst.is(kind)).named(name);
    let [is_job, is_query, is_norm, is_list] =
        [(Burst::Job, "is_job"), (Burst::Query, "is_query"), (Burst::Norm, "is_norm"), (Burst::List, "is_list")]
            .map(|(burst, name)| is(burst, name));
    let is_vector = is_norm | is(Burst::Vector, "is_vector");
    let is_node = if has_trees { is(Burst::Node, "is_block_of_node") } else { m.constant(1, 0) };
    let is_marker = (busy.wire() & Burst::marks(kind)).named("is_marker");
    keeps_query.drive(is_query);

    m.section("The searches of which a block has failed");
    let fails = (busy.wire() & !is_marker & block_failed).named("fails");
    let failed = m.register("failed_q", contexts).reset_to(0);
    let failed_before = failed.wire() | overflowed;
    let has_failed = (bit_of(failed_before, context) & !is_job | fails).named("has_failed");
    let here = one_hot(context, contexts);
    failed.next_when(is_job | fails, has_failed.mux(failed.wire() | here, failed.wire() & !here));

    m.section("The shape of vectors: metric, elements, and how many of them the last block has");
    let (metric, elements) = (words[0].bits(5, 4), words[0].bits(9, 8));
    let tail = words[1].lower(6) - m.constant(6, 1);
    let [is_word, is_half] = word_or_half(elements);
    let kept = m.concat(&[!(is_word | is_half), !is_word, m.constant(4, 15)]);
    let tail = ((tail & kept).extend(LEFT_BITS) + m.constant(LEFT_BITS, 1)).named("tail");
    let shape =
        [("metric", metric), ("elements", elements), ("tail", tail)].map(|(name, wire)| (name.to_string(), wire));
    let shape = shape.into_iter().chain(has_trees.then(|| named("is_keys", !words[0].bit(0)))).collect();
    let shape = keep("u_shapes", contexts, (is_job, context), shape, (take, next_context));
    let [metric, elements, tail] = [0, 1, 2].map(|k| shape[k].1);
    let is_angular = metric.any().named("is_angular");

    m.section("The query's block, at the same place as that of the vector");
    let block_width = vector_block_bits(parameters);
    let block = m.register("block_q", block_width).reset_to(0);
    let next_block = (busy.wire() & ends.wire() & (is_vector | is_query))
        .mux(last.mux(m.constant(block_width, 0), block.wire() + m.constant(block_width, 1)), block.wire());
    block.next(next_block);
    let columns: Vec<(String, Wire<'_>)> =
        words.iter().enumerate().map(|(k, word)| (format!("word_{k}"), *word)).collect();
    let write = (is_query, m.concat(&[context, block.wire()]));
    let read_block = next_block.named("next_block");
    let reads = Burst::Norm.is(next_kind) | Burst::Vector.is(next_kind);
    let reads = if has_trees { reads | Burst::Node.is(next_kind) } else { reads };
    let reads = (take & reads).named("reads_query");
    let read = (reads, m.concat(&[next_context, read_block]));
    let depth = contexts.next_power_of_two() << block_width;
    let query: Vec<Wire<'_>> = keep("u_query", depth, write, columns, read).into_iter().map(|(_, wire)| wire).collect();

    m.section("The beats of a block");
    let skips_q = m.register("skips_q", 1);
    let skips = (is_vector & block.wire().is(0).mux(has_failed, skips_q.wire())).named("skips");
    skips.comment("a whole vector, because the datapath adds until the last beat");
    skips_q.next_when(is_vector, skips);
    let first = m.register("is_first_q", 1);
    let (left_q, beat_q) = (m.register("left_q", LEFT_BITS), m.register("beat_q", 3));
    let [is_word, is_half] = word_or_half(elements);
    let full = m.concat(&[!(is_word | is_half), is_half, is_word, m.constant(4, 0)]);
    let left = first.wire().mux(last.mux(tail, full), left_q.wire()).named("left");
    let beat = first.wire().mux(m.constant(3, 0), beat_q.wire()).named("beat");
    let lanes = is_angular.mux(m.constant(LEFT_BITS, LANES as u64 / 2), m.constant(LEFT_BITS, LANES as u64));
    let is_end = (!lanes.less(left)).named("is_end");
    let is_last = (is_end & last).named("is_last");
    let offer = (is_vector & !skips & (!is_last | can_send)).named("offer");
    let leaves = (offer & beat_ready).named("leaves");
    first.next(take | (first.wire() & !leaves));
    left_q.next_when(leaves, left - lanes);
    beat_q.next_when(leaves, beat + m.constant(3, 1));
    let sends = ((leaves & is_last) | (is_marker & can_send)).named("sends");
    let (tests, keeps_node) = (is_node & last, is_node & !last);
    let node_leaves = tests & beat_ready;
    let of_vector = (leaves & is_end) | skips;
    let of_node = keeps_node | node_leaves;
    ends.drive((is_job & job_ready) | is_query | is_list | of_vector | of_node | (is_marker & can_send));

    // In an even half beat, the lower lanes have the elements of a Euclidean beat.
    let half = is_angular.mux(beat, m.concat(&[beat.lower(2), m.constant(1, 0)])).named("half_beat");
    let widen = widen()?;
    let of = |name: &str, words: &[Wire<'_>], lane: usize| {
        let part = |bits: u32, from: usize| {
            let place = from * bits as usize;
            words[place / 32].bits((place % 32) as u32 + bits - 1, (place % 32) as u32)
        };
        let at = |bits: u32| {
            let per_block = 512 / bits as usize;
            let euclidean: Vec<Wire<'_>> = (0..per_block / LANES).map(|k| part(bits, LANES * k + lane)).collect();
            if lane >= LANES / 2 {
                return beat.select(&euclidean);
            }
            let angular: Vec<Wire<'_>> = (0..2 * per_block / LANES).map(|k| part(bits, LANES / 2 * k + lane)).collect();
            half.select(&angular)
        };
        let inputs = [("elements_i", elements), ("word_i", at(32)), ("half_i", at(16)), ("byte_i", at(8))];
        m.instance(&format!("u_{name}_{lane}"), &widen, &inputs)[0]
    };
    for lane in 0..LANES {
        m.output(&format!("a_{lane}_o"), of("a", &query, lane));
        m.output(&format!("b_{lane}_o"), of("b", &words, lane));
        m.output(&format!("mask_{lane}_o"), m.constant(LEFT_BITS, lane as u64).less(left));
    }

    m.output("take_o", take);
    m.output("beat_valid_o", offer | tests);
    if has_trees {
        m.output("is_node_o", tests);
        m.output("is_keys_o", shape[3].1);
        m.output("node_sent_o", node_leaves);
        for (k, word) in words.iter().enumerate() {
            m.output(&format!("node_{k}_o"), hold(&format!("node_{k}_q"), keeps_node, *word));
        }
    }
    m.output("is_last_o", is_last);
    m.output("is_angular_o", is_angular);
    m.output("code_o", is_norm.mux(m.constant(2, NORM), metric));
    m.output("sent_o", sends);
    m.output("kind_o", kind);
    m.output("context_o", context);
    m.output("index_o", index);
    m.output("has_failed_o", has_failed);
    m.output("failed_o", failed_before);
    m.output("job_valid_o", is_job);
    m.output("list_valid_o", is_list);
    builder.finish()
}

/// Whether elements are binary32, and whether they are binary16.
fn word_or_half(elements: Wire<'_>) -> [Wire<'_>; 2] {
    [!elements.any(), elements.is(1)]
}

/// Bits of the number of elements of a block that are left, which is at most 64.
const LEFT_BITS: u32 = 7;
