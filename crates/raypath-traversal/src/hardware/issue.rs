//! The jobs of a block.

use super::blocks::JOB_WORDS;
use super::connect::Inputs;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use crate::blocks::{NodeKind, VERTEX_WORDS};
use raypath_hdl::{Builder, Error, Module, Register, Wire};
use std::sync::Arc;

/// The module `raypath_unit_issue`, which queues blocks and offers their jobs, one a cycle: one of a node, or one for
/// each triangle.
///
/// A block arrives where `arrived_i` is 1, for `arrived_context_i`; `arrived_failed_i` says that it has an error. When
/// its turn comes, `take_o` is 1 with `take_context_o`; its words, `word_…_i`, and the number of its triangles,
/// `count_i`, 0 for a node, are there from the next cycle on. A job is offered where `offer_o` is 1 and leaves where
/// `ready_i` is 1 too, with `context_o`, whether it `is_node_o`, its `place_o` in the block and whether it `is_last_o`.
/// A block with an error has no job; it is a fault, `fault_valid_o`, until `fault_taken_i` is 1.
///
/// A node with eight children has two jobs. A block of quantised nodes has one job, if it is not that of an instance: so
/// without instances there are no ports for the number of triangles and places, and none for words.
pub fn issue(UnitParameters { contexts, step, .. }: UnitParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_issue");
    let m = &builder;
    let nodes = step.node;
    m.doc("The jobs of blocks, in the order in which the blocks arrive: one of a node, or one for each triangle.");
    let width = bits(contexts);
    let [arrived, failed] = ["arrived_i", "arrived_failed_i"].map(|name| m.input(name, 1));
    let arrived_context = m.input("arrived_context_i", width);
    let block_ports = step.has_several_jobs().then(|| {
        let count = m.input("count_i", 2);
        let words = if nodes.triangles_per_block() > 1 { 0..JOB_WORDS } else { 0..0 };
        let words: Vec<Wire<'_>> = words.map(|k| m.input(&format!("word_{k}_i"), 32)).collect();
        (count, words)
    });
    let ready = m.input("ready_i", 1);
    let fault_taken = m.input("fault_taken_i", 1);

    let take = m.forward("take", 1);
    let block = Inputs::default()
        .port("push", arrived)
        .port("context", arrived_context)
        .port("failed", failed)
        .port("pop", take.wire())
        .place(m, "u_arrivals", &queue("raypath_unit_arrivals", contexts, &[("context", width), ("failed", 1)])?);
    let busy = m.register("busy_q", 1).reset_to(0);
    let failed = m.register("failed_q", 1);
    let context = m.register("context_q", width);
    let block_ports = block_ports.map(|(count, words)| (count, words, m.register("place_q", 2)));

    m.section("The job that is offered");
    let one = m.constant(2, 1);
    let places = block_ports.map(|(count, words, place)| {
        let is_node = count.is(0).named("is_node");
        let next = place.wire() + one;
        let is_last = match nodes {
            NodeKind::Wide8 => next.equals(is_node.mux(m.constant(2, 2), count)),
            _ => is_node | next.equals(count),
        };
        let is_last = is_last.named("is_last");
        Places { words, place, is_node, is_last }
    });
    let fault = (busy.wire() & failed.wire()).named("fault");
    let offer = (busy.wire() & !failed.wire()).named("offer");
    let leaves = (offer & ready).named("leaves");

    m.section("The next block");
    let last_leaves = places.as_ref().map_or(leaves, |places| leaves & places.is_last);
    let ends = (last_leaves | (fault & fault_taken)).named("ends");
    take.drive(block.port("valid") & (!busy.wire() | ends));
    let take = take.wire();
    busy.next(take | (busy.wire() & !ends));
    failed.next_when(take, block.port("failed"));
    context.next_when(take, block.port("context"));
    let job = places.map(|Places { words, place, is_node, is_last }| {
        let number = place.wire();
        place.next_when(take | leaves, take.mux(m.constant(2, 0), number + one));

        if words.is_empty() {
            return (is_node, number, is_last, words);
        }
        m.section("The triangle");
        let coordinate = |k: usize| {
            (1..nodes.triangles_per_block() as usize)
                .fold(words[k], |before, place| number.is(place as u64).mux(words[VERTEX_WORDS * place + k], before))
        };
        let triangle: Vec<Wire<'_>> = (0..VERTEX_WORDS).map(coordinate).collect();
        (is_node, number, is_last, triangle)
    });

    m.output("take_o", take);
    m.output("take_context_o", block.port("context"));
    m.output("offer_o", offer);
    m.output("fault_valid_o", fault);
    m.output("context_o", context.wire());
    if let Some((is_node, place, is_last, triangle)) = job {
        if nodes == NodeKind::Quantised {
            m.unused("unused_is_node", &[is_node]);
        } else {
            m.output("is_node_o", is_node);
            m.output("place_o", place);
        }
        m.output("is_last_o", is_last);
        triangle.iter().enumerate().for_each(|(k, wire)| m.output(&format!("triangle_{k}_o"), *wire));
    }
    builder.finish()
}

/// The places of the jobs of a wide block.
struct Places<'m> {
    words: Vec<Wire<'m>>,
    place: Register<'m>,
    is_node: Wire<'m>,
    is_last: Wire<'m>,
}
