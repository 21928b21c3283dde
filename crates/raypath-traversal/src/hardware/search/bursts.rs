//! The addresses of what searches ask for, and the indices whose vectors were compared.

use super::super::connect::{Inputs, Outputs, hold, keep, named};
use super::super::queue::{count_words, queue};
use super::fetch::COUNT_BITS;
use super::wiring::{BLOCK_BITS, BURST_BITS, context_bits, one_hot, when};
use crate::search::SearchParameters;
use raypath_hdl::{Builder, Error, Forward, Register, Wire};

/// Bursts that wait for the fetch.
pub const WAITING: u32 = 16;

/// Indices in a word of the memory of those that were compared.
const WAYS: u32 = 8;

/// The columns of a burst.
pub const BURST_COLUMNS: [&str; 5] = ["kind", "context", "index", "block", "count"];

/// What a turn asks for in a cycle: `blocks` blocks from `base` + `factor` × `stride` + `offset` on.
pub struct Asked<'m> {
    pub asks: Wire<'m>,
    pub kind: Wire<'m>,
    pub context: Wire<'m>,
    pub index: Wire<'m>,
    pub base: Wire<'m>,
    pub factor: Wire<'m>,
    pub stride: Wire<'m>,
    pub offset: Wire<'m>,
    pub blocks: Wire<'m>,
    /// A vector that may be none, and one that may have been compared before.
    pub checks: Wire<'m>,
    pub compares: Wire<'m>,
}

/// The index that is looked up, the number of vectors, and the upper bits of all addresses.
pub struct Lookup<'m> {
    pub checked: Wire<'m>,
    pub count: Wire<'m>,
    pub upper: Option<Wire<'m>>,
}

/// The indices of the search before are forgotten, set by set, after a search has entered, if there are any.
pub struct Sweep<'m> {
    pub begins: Wire<'m>,
    pub context: Wire<'m>,
    pub goes_on: Register<'m>,
    /// Drives the searches that remember an index in this cycle.
    pub remembers: Forward<'m>,
}

/// The bursts that wait for the fetch. What is asked for is held until it has moved on; a vector that was compared
/// before, or is none, is dropped.
pub fn bursts<'m>(
    m: &'m Builder,
    parameters: SearchParameters,
    asked: &Asked<'m>,
    lookup: &Lookup<'m>,
    forgets: Sweep<'m>,
    (moves, burst_ready): (Forward<'m>, Wire<'m>),
) -> Result<Outputs<'m>, Error> {
    m.section("The address, and whether the vector was compared before");
    let has_burst = m.register("has_burst_q", 1).reset_to(0);
    let leaves = m.forward("leaves", 1);
    moves.drive(!has_burst.wire() | leaves.wire());
    let loads = (asked.asks & moves.wire()).named("loads");
    has_burst.next(loads | (has_burst.wire() & !leaves.wire()));
    let held = |name: &str, wire| hold(&format!("burst_{name}_q"), loads, wire);
    let (kind, burst_context, index) =
        (held("kind", asked.kind), held("context", asked.context), held("index", asked.index));
    let [base, factor, stride, offset] =
        [("base", asked.base), ("factor", asked.factor), ("stride", asked.stride), ("offset", asked.offset)]
            .map(|(name, wire)| held(name, wire));
    let (count, is_checked) = (held("count", asked.blocks), held("is_checked", asked.checks));
    let is_compared = held("is_compared", asked.compares);
    let compared = lookup.checked;
    let is_outside = held("is_outside", !compared.less(lookup.count));
    let sets = parameters.remembered / WAYS;
    let set_bits = sets.ilog2();
    let set = (compared.lower(set_bits) ^ compared.bits(2 * set_bits - 1, set_bits)).named("compared_set");
    let set_q = held("set", set);
    let (writes, ways) =
        (m.forward("remembers", 1), (0..WAYS).map(|k| m.forward(&format!("new_way_{k}"), 32)).collect::<Vec<_>>());
    let sweep_set = m.register("sweep_set_q", set_bits).reset_to(0);
    let sweeps = forgets.goes_on;
    let sweep = (sweeps.wire() & !writes.wire()).named("sweep");
    sweep_set.next_when(sweep, sweep_set.wire() + m.constant(set_bits, 1));
    sweeps.next(forgets.begins | (sweeps.wire() & !(sweep & sweep_set.wire().all())));
    let write = m.concat(&[sweep.mux(forgets.context, burst_context), sweep.mux(sweep_set.wire(), set_q)]);
    let stored = ways.iter().enumerate().map(|(k, way)| named(&format!("way_{k}"), way.wire())).collect();
    let depth = parameters.contexts.next_power_of_two() * sets;
    let read = (loads & asked.compares, m.concat(&[asked.context, set]));
    let known = keep("u_compared", depth, (writes.wire() | sweep, write), stored, read);
    let is_known =
        m.concat(&known.iter().map(|(_, way)| way.equals(index)).collect::<Vec<_>>()).any().named("is_known");
    let skips = ((is_checked & is_outside) | (is_compared & is_known)).named("skips");
    let offers = (has_burst.wire() & !skips).named("offers");
    let count_q = m.register("count_q", WAITING.ilog2() + 1).reset_to(0);
    let can_push = (!count_q.wire().top()).named("can_push");
    let pushes = (offers & can_push).named("pushes");
    leaves.drive(has_burst.wire() & (skips | can_push));
    writes.drive(pushes & is_compared);
    forgets.remembers.drive(when(pushes & is_compared, one_hot(burst_context, parameters.contexts)));
    let new = [index].into_iter().chain(known.iter().map(|(_, way)| *way));
    ways.iter().zip(new).for_each(|(forward, way)| forward.drive(way | sweep.replicate(32)));
    let product = (factor * stride).named("product");
    m.unused("unused_product", &[product.upper(BLOCK_BITS)]);
    let block = base + product.lower(BLOCK_BITS) + offset;
    let block = lookup.upper.map_or(block, |base| m.concat(&[held("upper", base), block]));

    m.section("Bursts that wait, so that indices which are skipped cost no time");
    let columns = [
        ("kind", BURST_BITS),
        ("context", context_bits(parameters)),
        ("index", 32),
        ("block", block.width()),
        ("count", COUNT_BITS),
    ];
    let pops = m.forward("pops", 1);
    count_words(count_q, pushes, pops.wire());
    let bursts = [kind, burst_context, index, block, count];
    let queue = Inputs::default()
        .port("push", pushes)
        .ports(columns.iter().zip(bursts).map(|((name, _), wire)| named(name, wire)))
        .port("pop", pops.wire())
        .place(m, "u_bursts", &queue("raypath_search_bursts", WAITING, &columns)?);
    pops.drive(queue.port("valid") & burst_ready);
    Ok(queue)
}
