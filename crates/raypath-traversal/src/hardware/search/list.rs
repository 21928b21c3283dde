//! The best candidates of each search, sorted.

use super::super::connect::{Access, hold, keep, named};
use super::super::queue::bits;
use super::super::scheduler::lowest;
use super::filter::fields;
use super::wiring::{BLOCK_BITS, Burst, context_bits, number_of, when};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Module, Register, Wire};
use std::sync::Arc;

/// Candidates in a word of the memory.
pub const PER_WORD: u32 = 16;

/// The key of no candidate, behind those of all ranks.
const NOTHING: u64 = 0xffff_ffff;

/// The module `raypath_search_list`, which keeps the best candidates of each search in words of sixteen, sorted by key and
/// index.
///
/// A search begins where `clear_valid_i` and `clear_ready_o` are 1, for `clear_context_i`: with the key of its bound, the
/// numbers of the last candidate and of the last neighbour, and whether it is refused. Vectors and markers come where
/// `valid_i` is 1, and are taken where `taken_o` is 1. A vector that is in the list, or behind a full list, changes nothing.
/// What is behind `limit_o` need not come; it is written where `limits_o` is 1. Where `expands_o` is 1, the neighbours of
/// `index_o` (its lower bits, which select a block) come next in the search of `context_o`: it is the best candidate for
/// which that was not said. If there is none, and at the last marker, the neighbours leave, the best first, where
/// `found_valid_o` and `found_ready_i` are 1, and after them the end, with its status: 0, 1 for a job that is refused, 2 for
/// an error of the memory. The last two have no neighbours.
pub fn list(parameters: SearchParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_list");
    let m = &builder;
    m.doc("The best candidates of each search, sorted, in words of sixteen.");
    let (width, contexts) = (context_bits(parameters), parameters.contexts);
    let (word_bits, place_bits) = (word_bits(parameters), place_bits(parameters));
    let clear_valid = m.input("clear_valid_i", 1);
    let clear_context = m.input("clear_context_i", width);
    let bound = m.input("clear_bound_i", 32);
    let settings = [("candidate", place_bits), ("neighbour", place_bits), ("refused", 1)]
        .map(|(name, width)| named(name, m.input(&format!("clear_{name}_i"), width)));
    let valid = m.input("valid_i", 1);
    let [kind, next_context, index, key, has_failed] =
        fields(parameters).map(|(name, width)| m.input(&format!("{name}_i"), width));
    let found_ready = m.input("found_ready_i", 1);

    m.section("What is done: a list is cleared, a candidate inserted, one to expand sought, or the neighbours leave");
    let [clears, inserts, seeks, drains] =
        ["clears_q", "inserts_q", "seeks_q", "drains_q"].map(|name| m.register(name, 1).reset_to(0));
    let [finds_none, drained, overlaps] = ["finds_none", "drained", "overlaps"].map(|name| m.forward(name, 1));
    overlaps.wire().comment("the last word of an insertion is written while the first of the next is read");
    let idle = !(clears.wire() | inserts.wire() | seeks.wire() | drains.wire());
    let free = (idle | overlaps.wire()).named("free");
    let clear = (clear_valid & free).named("clear");
    let take = (valid & free & !clear_valid).named("take");
    let begins = (clear | take).named("begins");
    let next_context = clear.mux(clear_context, next_context).named("next_context");
    let context = hold("context_q", begins, next_context);
    let [key, index, failed] = [("own_key_q", key), ("own_index_q", index), ("failed_q", has_failed)]
        .map(|(name, wire)| hold(name, take, wire));
    let goes = m.forward("goes_on", 1);
    let next = |register: Register<'_>, enters: Wire<'_>| register.next(enters | (register.wire() & goes.wire()));
    next(clears, clear);
    next(inserts, take & Burst::Vector.is(kind));
    next(seeks, take & Burst::Expand.is(kind) & !has_failed);
    let ends = Burst::Drain.is(kind) | (Burst::Expand.is(kind) & has_failed);
    drains.next((take & ends) | finds_none.wire() | (drains.wire() & !drained.wire()));

    m.section("The settings of the search");
    let at: Access<'_> = (begins, next_context);
    let kept = keep("u_settings", contexts, (clear, clear_context), settings.to_vec(), at);
    let [last_candidate, last_neighbour, refused] = [0, 1, 2].map(|k| kept[k].1);

    m.section("The word that was read, and the next");
    let word = m.register("word_q", word_bits);
    let restarts = (begins | finds_none.wire()).named("restarts");
    let advances = (goes.wire() & !restarts).named("advances");
    let next_word = restarts.mux(m.constant(word_bits, 0), word.wire() + m.constant(word_bits, 1)).named("next_word");
    word.next_when(restarts | advances, next_word);
    let writes = m.forward("writes", 1);
    let columns = [("key", 32), ("index", 32), ("expanded", 1)];
    let written: Vec<_> = (0..PER_WORD)
        .flat_map(|k| {
            columns.map(|(name, width)| (format!("{name}_{k}"), m.forward(&format!("new_{name}_{k}"), width)))
        })
        .collect();
    let stored = written.iter().map(|(name, forward)| named(name, forward.wire())).collect();
    let depth = contexts.next_power_of_two() << word_bits;
    let read_context = begins.mux(next_context, context);
    let read = (restarts | advances, m.concat(&[read_context, next_word]));
    let read = keep("u_candidates", depth, (writes.wire(), m.concat(&[context, word.wire()])), stored, read);
    let entries: Vec<[Wire<'_>; 3]> = read.chunks(3).map(|entry| [0, 1, 2].map(|k| entry[k].1)).collect();
    let is_nothing: Vec<Wire<'_>> =
        entries.iter().enumerate().map(|(k, entry)| entry[0].is(NOTHING).named(&format!("is_nothing_{k}"))).collect();
    let is_last = word.wire().equals(last_candidate.upper(word_bits)).named("is_last_word");

    m.section("A candidate moves those behind it by one place, and the last of the word goes on to the next");
    let is_own = m.register("is_own_q", 1);
    is_own.next(take);
    let moved = columns.map(|(name, width)| m.register(&format!("moved_{name}_q"), width));
    let own = [key, index, m.constant(1, 0)];
    let carried = [0, 1, 2].map(|k| is_own.wire().mux(own[k], moved[k].wire()));
    let order = m.concat(&carried[..2]).named("carried");
    let orders: Vec<Wire<'_>> = entries.iter().map(|[key, index, _]| m.concat(&[*key, *index])).collect();
    let is_before: Vec<Wire<'_>> =
        orders.iter().enumerate().map(|(k, other)| order.less(*other).named(&format!("is_before_{k}"))).collect();
    let is_there =
        m.concat(&orders.iter().map(|other| other.equals(order)).collect::<Vec<_>>()).any().named("is_there");
    let places = (inserts.wire() & !is_there).named("places");
    let inserted = |k: usize, field: usize| {
        let here = is_before[k].mux(carried[field], entries[k][field]);
        if k == 0 { here } else { is_before[k - 1].mux(entries[k - 1][field], here) }
    };
    let last = PER_WORD as usize - 1;
    let behind = [0, 1, 2].map(|field| is_before[last].mux(entries[last][field], carried[field]));
    moved.iter().zip(behind).for_each(|(register, wire)| register.next(wire));
    let inserts_on = (places & !behind[0].is(NOTHING) & !is_last).named("inserts_on");
    overlaps.drive(inserts.wire() & !inserts_on & (is_there | word.wire().any()));
    let is_full = (places & is_last & !inserted(last, 0).is(NOTHING)).named("is_full");
    let last_order = m.concat(&[inserted(last, 0), inserted(last, 1)]);

    m.section("The best candidate whose neighbours were not asked for");
    let mut can_expand = Vec::new();
    for (k, entry) in entries.iter().enumerate() {
        let behind = |k: usize| last_candidate.lower(PER_WORD.ilog2()).less(m.constant(PER_WORD.ilog2(), k as u64));
        let is_kept = if k == 0 { m.constant(1, 1) } else { !is_last | !behind(k) };
        can_expand.push(!is_nothing[k] & !entry[2] & is_kept);
    }
    can_expand.reverse();
    let can_expand = m.concat(&can_expand).named("can_expand");
    let chosen = lowest(can_expand).named("chosen");
    let number = number_of(chosen);
    let column = |field: usize| entries.iter().map(|entry| entry[field]).collect::<Vec<_>>();
    let expands = (seeks.wire() & can_expand.any()).named("expands");
    let seeks_on = (seeks.wire() & !can_expand.any() & !is_last).named("seeks_on");
    finds_none.drive(seeks.wire() & !can_expand.any() & is_last);

    m.section("The neighbours");
    let place = m.register("place_q", PER_WORD.ilog2());
    let is_over = m.register("is_over_q", 1);
    let status = m.concat(&[failed, refused & !failed]).named("status");
    let found_nothing = place.wire().select(&is_nothing);
    let is_end = (found_nothing | is_over.wire() | status.any()).named("is_end");
    let pushes = (drains.wire() & found_ready).named("pushes");
    drained.drive(pushes & is_end);
    let is_found = (pushes & !is_end).named("is_found");
    let drains_on = (is_found & place.wire().all()).named("drains_on");
    place.next_when(
        restarts | is_found,
        restarts.mux(m.constant(PER_WORD.ilog2(), 0), place.wire() + m.constant(PER_WORD.ilog2(), 1)),
    );
    let is_last_neighbour = m.concat(&[word.wire(), place.wire()]).equals(last_neighbour);
    is_over.next_when(restarts | is_found, !restarts & is_last_neighbour);

    m.section("The word that is written");
    let is_all_cleared = word.wire().is(u64::from(words(parameters)) - 1);
    let clears_on = (clears.wire() & !is_all_cleared).named("clears_on");
    goes.drive(clears_on | inserts_on | seeks_on | drains_on);
    writes.drive(clears.wire() | places | expands);
    for (place, (_, forward)) in written.iter().enumerate() {
        let (k, field) = (place / 3, place % 3);
        let marked = if field == 2 { entries[k][2] | chosen.bit(k as u32) } else { entries[k][field] };
        let of_insert = inserts.wire().mux(inserted(k, field), marked);
        // The index of no candidate may be any.
        forward.drive(match field {
            0 => of_insert | clears.wire().replicate(32),
            1 => of_insert,
            _ => when(!clears.wire(), of_insert),
        });
    }

    m.output("limits_o", clear | is_full);
    m.output("limit_context_o", clear.mux(clear_context, context));
    m.output("limit_o", clear.mux(m.concat(&[bound, m.constant(32, NOTHING)]), last_order));
    m.output("clear_ready_o", free);
    m.output("taken_o", take);
    m.output("expands_o", expands);
    m.output("context_o", context);
    let blocks: Vec<Wire<'_>> = entries.iter().map(|entry| entry[1].lower(BLOCK_BITS)).collect();
    m.output("index_o", number.select(&blocks));
    m.output("found_valid_o", drains.wire());
    m.output("found_key_o", place.wire().select(&column(0)));
    m.output("found_index_o", place.wire().select(&column(1)));
    m.output("found_is_end_o", is_end);
    m.output("found_status_o", status);
    builder.finish()
}

fn words(parameters: SearchParameters) -> u32 {
    parameters.candidates.div_ceil(PER_WORD)
}

fn word_bits(parameters: SearchParameters) -> u32 {
    bits(words(parameters))
}

/// Bits of the number of a candidate.
pub fn place_bits(parameters: SearchParameters) -> u32 {
    word_bits(parameters) + PER_WORD.ilog2()
}
