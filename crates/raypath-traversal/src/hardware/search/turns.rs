//! What each search fetches next.

use super::super::connect::{Access, hold, keep, named};
use super::super::scheduler::{after_last, lowest};
use super::branches::BRANCH;
use super::bursts::{Asked, BURST_COLUMNS, Lookup, Sweep, bursts};
use super::fetch::COUNT_BITS;
use super::job::Settings;
use super::visit::{OfTurn, Visit};
use super::wiring::{BLOCK_BITS, Burst, WORDS, bit_of, context_bits, number_of, one_hot, when};
use crate::search::{NODE_BLOCKS, SearchParameters};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// Vectors or indices of a turn.
const PER_TURN: u64 = WORDS as u64;

/// The phases of a search. What comes in its next turn:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Phase {
    /// The job is asked for.
    #[default]
    Enter,
    /// The query.
    Begin,
    /// Vectors of a scan.
    Scan,
    /// The indices of a block of the list, which has arrived.
    List,
    /// As `List`, in the neighbours of a candidate.
    Neighbours,
    /// The neighbours of the candidate that the list has named.
    Expand,
    /// The children of the branch of a tree that came last.
    Visit,
}

const PHASE_BITS: u32 = 3;

impl Phase {
    fn is(self, phase: Wire<'_>) -> Wire<'_> {
        phase.is(self as u64)
    }

    fn wire(self, m: &Builder) -> Wire<'_> {
        m.constant(PHASE_BITS, self as u64)
    }
}

/// The module `raypath_search_turns`.
///
/// A search enters where `enter_valid_i` and `enter_ready_o` are 1, with the block of its job; `enter_context_o` is its
/// number, and it is over where `release_i` is 1. Searches that can go on take turns: in each, one asks for what comes
/// next in it, at most 16 vectors, as bursts (`burst_…_o`) that leave where `burst_ready_i` is 1. It can go on when its
/// job was loaded (`load_i`, with its words), when a block of its list has arrived (`list_valid_i`), when the list of
/// candidates has named one to expand (`expands_i`), after a turn of a scan that is not at its end, and, in a unit with
/// trees, when the last outcome of a branch has come (`visited_i`). The branch that is next (`next_…_i`) is read where
/// `picks_o` is 1, and leaves where `pops_o` is 1, before an outcome of its nodes can come.
///
/// The job's settings for the list of candidates and for results are outputs, valid with the words of the job.
pub fn turns(parameters: SearchParameters, address_width: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_turns");
    let m = &builder;
    m.doc("What each search fetches next.");
    let (width, contexts, base_bits) = (context_bits(parameters), parameters.contexts, address_width - 32);
    let enter_valid = m.input("enter_valid_i", 1);
    let enter_block = m.input("enter_block_i", BLOCK_BITS);
    let enter_base = (base_bits > 0).then(|| m.input("enter_base_i", base_bits));
    let event = |name: &str, context: &str| (m.input(&format!("{name}_i"), 1), m.input(&format!("{context}_i"), width));
    let (release, load) = (event("release", "release_context"), event("load", "block_context"));
    let (list, expands) = ((m.input("list_valid_i", 1), load.1), event("expands", "expands_context"));
    let list_half = m.input("list_half_i", 1);
    let words: Vec<Wire<'_>> = (0..WORDS).map(|k| m.input(&format!("word_{k}_i"), 32)).collect();
    let expanded = m.input("expands_index_i", BLOCK_BITS);
    let failed = m.input("failed_i", contexts);
    let has_trees = parameters.has_trees();
    let tree = has_trees.then(|| {
        let branch = BRANCH.map(|(name, width)| m.input(&format!("next_{name}_i"), width));
        (event("visited", "visited_context"), branch, m.input("next_is_there_i", 1))
    });
    let burst_ready = m.input("burst_ready_i", 1);

    m.section("Searches that enter, each with a memory of compared indices that is empty");
    let in_use = m.register("in_use_q", contexts).reset_to(0);
    let sweeps = m.register("sweeps_q", 1).reset_to(0);
    let can_enter = (!in_use.wire().all() & !sweeps.wire()).named("can_enter");
    let enters = (enter_valid & can_enter).named("enters");
    let free = lowest(!in_use.wire()).named("free");
    let entered = number_of(free).named("entered");
    let at = |(enable, context)| when(enable, one_hot(context, contexts));
    in_use.next((in_use.wire() | when(enters, free)) & !at(release));
    let remembers = m.forward("remembers_now", contexts);
    let remembered = m.register("remembered_q", contexts).reset_to((1 << contexts) - 1);
    remembered.wire().comment("searches with indices of the one before, as all have after a reset");
    remembered.next((remembered.wire() & !when(enters, free)) | remembers.wire());
    let begins_sweep = (enters & (remembered.wire() & free).any()).named("begins_sweep");
    let swept = hold("swept_q", enters, entered);
    let mut of_enter = vec![named("block", enter_block)];
    of_enter.extend(enter_base.map(|base| named("base", base)));

    m.section("Whose turn is next");
    let [again, ends] = ["again", "ends"].map(|name| m.forward(name, 1));
    let runs = m.register("runs_q", 1).reset_to(0);
    let context = m.register("context_q", width);
    let [waits, is_new] = ["waits_q", "is_new_q"].map(|name| m.register(name, contexts).reset_to(0));
    let own = one_hot(context.wire(), contexts);
    // A search that is swept has its first turn only, in which it compares nothing.
    let is_swept = when(sweeps.wire(), one_hot(swept, contexts)) & !is_new.wire();
    let can = (waits.wire() & !when(runs.wire(), own) & !is_swept).named("can");
    let picks = (can.any() & (!runs.wire() | ends.wire())).named("picks");
    let picked = when(picks, after_last(can, picks)).named("picked");
    let next_context = number_of(picked).named("next_context");
    runs.next(picks | (runs.wire() & !ends.wire()));
    context.next_when(picks, next_context);
    let comes = when(enters, free) | at(load) | at(list) | at(expands) | when(again.wire(), own);
    let comes = tree.map_or(comes, |(visited, ..)| comes | at(visited));
    waits.next((waits.wire() | comes) & !picked);
    is_new.next((is_new.wire() | when(enters, free)) & !picked);
    let is_first = m.register("is_first_q", 1);
    let moves = m.forward("moves", 1);
    is_first.next(picks | (is_first.wire() & !moves.wire()));

    m.section("What is known of it");
    let read: Access<'_> = (picks, next_context);
    let job = Settings::of(m, parameters, &words);
    let of_enter = keep("u_entered", contexts, (enters, entered), of_enter, read);
    let kept = keep("u_jobs", contexts, load, job.kept(), read);
    let of_job = |name: &str| kept.iter().find(|(known, _)| known == name).map_or(kept[0].1, |(_, wire)| *wire);
    let candidate = keep("u_expanded", contexts, expands, vec![named("index", expanded)], read)[0].1;
    let half = m.register("half_q", contexts);
    let here = at(list);
    half.next((half.wire() & !here) | (here & list_half.replicate(contexts)));
    let list_words = words.iter().enumerate().map(|(k, word)| (format!("index_{k}"), *word)).collect();
    let write = (list.0, m.concat(&[list.1, list_half]));
    let read_list = (picks, m.concat(&[next_context, bit_of(half.wire(), next_context)]));
    let depth = contexts.next_power_of_two() * 2;
    let list_words: Vec<Wire<'_>> =
        keep("u_lists", depth, write, list_words, read_list).into_iter().map(|(_, wire)| wire).collect();
    let names = [("phase", PHASE_BITS), ("number", 32), ("left", 32), ("spent", 32)];
    let next: Vec<_> = names.iter().map(|(name, width)| m.forward(&format!("next_{name}"), *width)).collect();
    let state = names.iter().zip(&next).map(|((name, _), forward)| named(name, forward.wire())).collect();
    let state = keep("u_turns", contexts, (ends.wire(), context.wire()), state, read);
    let was_new = hold("was_new_q", picks, (picked & is_new.wire()).any());
    let phase = was_new.mux(Phase::Enter.wire(m), state[0].1).named("phase");
    let has_failed = (of_job("refused") | bit_of(failed, context.wire())).named("has_failed");

    m.section("The turn");
    let step_q = m.register("step_q", STEP_BITS);
    let step = is_first.wire().mux(m.constant(STEP_BITS, 0), step_q.wire()).named("step");
    step_q.next_when(moves.wire(), step + m.constant(STEP_BITS, 1));
    let [number_q, left_q] = ["number_q", "left_q"].map(|name| m.register(name, 32));
    let number = is_first.wire().mux(state[1].1, number_q.wire()).named("number");
    let left = is_first.wire().mux(state[2].1, left_q.wire()).named("left");
    let is = |phase_: Phase, name: &str| (runs.wire() & phase_.is(phase)).named(name);
    let [is_enter, begins, scans, expands_one] = [
        is(Phase::Enter, "is_enter"),
        is(Phase::Begin, "begins"),
        is(Phase::Scan, "scans"),
        is(Phase::Expand, "expands_one"),
    ];
    let in_neighbours = is(Phase::Neighbours, "in_neighbours");
    let in_list = (is(Phase::List, "in_first_list") | in_neighbours).named("in_list");
    let one = m.constant(32, 1);
    let zero = m.constant(32, 0);
    let [is_step_0, is_step_1, is_last_step] = [0, 1, PER_TURN - 1].map(|k| step.is(k));
    let [is_scan, is_graph] = [("is_scan", 0), ("is_graph", 2)].map(|(name, k)| of_job("place").is(k).named(name));
    let no = m.constant(1, 0);
    let is_tree = if has_trees { of_job("place").bit(2).named("is_tree") } else { no };

    m.section("The end of a list, and of a search");
    let spent = when(!begins, state[3].1).named("spent");
    let may_expand = spent.less(of_job("expansions"));
    let expands_next = (is_graph & may_expand).named("expands_next");
    let visit = tree.map_or_else(
        || Visit::none(m),
        |(_, [first, children, is_leaf], is_there)| {
            let (visits, is_keys) = (is(Phase::Visit, "visits"), !of_job("place").bit(0));
            Visit::of_branch(
                m,
                [first, children, is_leaf, is_there],
                &OfTurn { visits, step, moves: moves.wire(), is_keys, has_failed, may_expand },
            )
        },
    );
    let first_len = is_graph.mux(of_job("entry_count"), of_job("len")).named("first_len");
    let first_list = is_graph.mux(of_job("entries"), of_job("list"));
    let is_decided = (begins & !is_step_0 & !is_step_1).named("is_decided");
    let is_empty = is_scan.mux(of_job("count"), first_len).is(0) & !is_tree;
    let is_empty = is_empty.named("is_empty");
    let is_root = is_decided & is_tree;
    let is_through =
        (in_list & !is_step_0 & left.lower(5).equals(step - m.constant(STEP_BITS, 1)) & !left.upper(27).any())
            .named("is_through");
    let stops = (has_failed & is_step_0 & (begins | in_list)).named("stops");
    let ends_list =
        (is_through | (expands_one & of_job("len").is(0)) | (is_decided & is_empty & !is_scan)).named("ends_list");
    let ends_scan = ((scans & (left.is(0) | has_failed)) | (is_decided & is_empty & is_scan)).named("ends_scan");
    let expand = (ends_list & expands_next).named("expand");
    let drain = (stops | ends_scan | (ends_list & !expands_next) | visit.drains).named("drain");
    let marks = (expand | drain).named("marks");

    m.section("What is asked for");
    let begins_list = is_decided & !is_scan & !is_tree;
    let asks_list = ((in_list & is_step_0 & m.constant(32, PER_TURN).less(left)) | begins_list | expands_one) & !marks;
    let asks_list = asks_list.named("asks_list");
    let asks_vector = (scans & !ends_scan).named("asks_vector");
    let compares = (in_list & !is_step_0 & !is_through).named("compares");
    // The vectors of a tree may be behind the last one.
    let checks = (compares | visit.asks_vector | (asks_vector & is_tree)).named("checks");
    let asks_node = visit.asks_node | is_root;
    let is_norm = (begins & is_step_1).named("is_norm");
    let asks_query = (begins & ((is_step_0 & !stops) | (is_step_1 & of_job("cosine")))).named("asks_query");
    let asks = (is_enter | asks_query | asks_list | checks | asks_vector | asks_node | marks).named("asks");
    let list_number = in_list.mux(number + one, zero).named("list_number");
    let place = step.lower(4) - m.constant(4, 1);
    let checked = visit.asks_vector.mux(visit.index, (asks_vector & is_tree).mux(number, place.select(&list_words)));
    let checked = checked.named("checked");
    let kind = [
        (expand, Burst::Expand),
        (drain, Burst::Drain),
        (asks_list, Burst::List),
        (asks_node, Burst::Node),
        (is_enter, Burst::Job),
        (asks_query & !is_norm, Burst::Query),
        (asks_query, Burst::Norm),
    ];
    let kind = kind
        .into_iter()
        .rev()
        .fold(Burst::Vector.wire(m), |rest, (is, burst)| is.mux(burst.wire(m), rest))
        .named("kind");
    // The lowest bit of a node's says whether it is the last of its branch.
    let of_node = (visit.is_last | is_root).extend(32);
    let index = checks.mux(checked, asks_list.mux(list_number, asks_node.mux(of_node, number))).named("index");
    let is_neighbours = (expands_one | in_neighbours).named("is_neighbours");
    let base = [
        (is_enter, of_enter[0].1),
        (asks_query, of_job("query")),
        (asks_list, is_neighbours.mux(of_job("list"), first_list)),
        (asks_node, of_job("list")),
    ];
    let base = base.into_iter().fold(of_job("vectors"), |rest, (is, base)| is.mux(base, rest)).named("base");
    let of_vector = when(checks | asks_vector, index.lower(BLOCK_BITS));
    let of_neighbours = when(is_neighbours, candidate);
    let factor = asks_list.mux(of_neighbours, of_vector | when(visit.asks_node, visit.index.lower(BLOCK_BITS)));
    let factor = factor.named("factor");
    let len = of_job("len");
    let list_stride = (len.bits(16, 4) + len.lower(4).any().extend(13)).extend(BLOCK_BITS);
    let node_blocks = u64::from(NODE_BLOCKS);
    let stride = asks_node.mux(m.constant(BLOCK_BITS, node_blocks), of_job("stride"));
    let stride = asks_list.mux(list_stride, stride).named("stride");
    let offset = when(asks_list, list_number.lower(BLOCK_BITS));
    let is_one = is_enter | asks_list;
    let blocks =
        is_one.mux(m.constant(COUNT_BITS, 1), asks_node.mux(m.constant(COUNT_BITS, node_blocks), of_job("blocks")));

    m.section("The end of the turn");
    let is_last_in_list = (compares & step.is(PER_TURN) & m.constant(32, PER_TURN).less(left)).named("is_last_in_list");
    let ends_turn = [
        marks | is_root | visit.ends,
        is_enter,
        asks_list & !in_list,
        is_decided & is_scan,
        asks_vector & is_last_step,
        is_last_in_list,
    ];
    let ends_turn = m.concat(&ends_turn).any().named("ends_turn");
    ends.drive(runs.wire() & moves.wire() & ends_turn);
    let goes_on = asks_vector | (is_decided & is_scan) | (visit.ends & !visit.expands);
    again.drive(ends.wire() & !marks & goes_on);
    let phases = [
        (is_enter, Phase::Begin),
        (is_decided, Phase::List),
        (is_decided & is_scan, Phase::Scan),
        (expands_one, Phase::Neighbours),
        (expand, Phase::Expand),
        (is_root, Phase::Visit),
        (visit.scans, Phase::Scan),
    ];
    let next_phase = phases.into_iter().fold(phase, |rest, (is, phase)| is.mux(phase.wire(m), rest));
    let next_number = asks_vector.mux(number + one, visit.scans.mux(visit.index, list_number));
    let lefts = [
        (asks_vector, left - one),
        (in_list, left - m.constant(32, PER_TURN)),
        (expands_one | visit.scans, len),
        (is_decided, is_scan.mux(of_job("count"), first_len)),
    ];
    let next_left = lefts.into_iter().fold(left, |rest, (is, left)| is.mux(left, rest));
    let next_spent = spent + (expand | visit.expands).extend(32);
    next.iter().zip([next_phase, next_number, next_left, next_spent]).for_each(|(forward, wire)| forward.drive(wire));
    number_q.next_when(moves.wire(), scans.mux(next_number, number));
    left_q.next_when(moves.wire(), scans.mux(next_left, left));

    let asked =
        Asked { asks, kind, context: context.wire(), index, base, factor, stride, offset, blocks, checks, compares };
    let sweep = Sweep { begins: begins_sweep, context: swept, goes_on: sweeps, remembers };
    let lookup = Lookup { checked, count: of_job("count"), upper: of_enter.get(1).map(|(_, base)| *base) };
    let queue = bursts(m, parameters, &asked, &lookup, sweep, (moves, burst_ready))?;

    m.output("enter_ready_o", can_enter);
    m.output("entered_o", enters);
    m.output("entered_context_o", entered);
    m.output("is_idle_o", !in_use.wire().any());
    m.output("burst_valid_o", queue.port("valid"));
    BURST_COLUMNS.iter().for_each(|name| m.output(&format!("burst_{name}_o"), queue.port(name)));
    if has_trees {
        m.output("picks_o", picks);
        m.output("picked_context_o", next_context);
        m.output("pops_o", moves.wire() & visit.begins);
        m.output("own_context_o", context.wire());
    }
    job.outputs(m);
    builder.finish()
}

/// Bits of the number of a turn's step: the list or the query, indices or vectors, and a marker.
const STEP_BITS: u32 = 5;
