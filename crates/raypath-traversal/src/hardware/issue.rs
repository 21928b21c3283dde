//! The jobs of a block.

use super::connect::Inputs;
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use crate::blocks::{NodeKind, VERTEX_NUMBERS, VERTEX_WORDS};
use crate::step::StepParameters;
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module `raypath_unit_issue`, which queues blocks and offers their jobs, one a cycle: one of a node, two of one
/// with eight children or of an instance, or one for each triangle.
///
/// A block arrives where `arrived_i` is 1, for `arrived_context_i`; `arrived_failed_i` says that it has an error. When
/// its turn comes, `take_o` is 1 with `take_context_o`; its words, `word_…_i`, and the number of its triangles,
/// `count_i`, 0 for a node, are there from the next cycle on. A job is offered where `offer_o` is 1 and leaves where
/// `ready_i` is 1 too, with `context_o`, whether it `is_node_o`, its `place_o` in the block and whether it `is_last_o`.
/// A block with an error has no job; it is a fault, `fault_valid_o`, until `fault_taken_i` is 1.
///
/// With quantised nodes, the block of an instance, `is_instance_i`, has its words at the outputs of a triangle.
pub fn issue(UnitParameters { contexts, step, .. }: UnitParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_issue");
    let m = &builder;
    let nodes = step.node;
    m.doc("The jobs of blocks, in the order in which the blocks arrive: one of a node, or one for each triangle.");
    let width = bits(contexts);
    let [arrived, failed] = ["arrived_i", "arrived_failed_i"].map(|name| m.input(name, 1));
    let arrived_context = m.input("arrived_context_i", width);
    let count = m.input("count_i", 2);
    let words: Vec<Wire<'_>> = triangle_words(nodes).map(|k| m.input(&format!("word_{k}_i"), 32)).collect();
    let is_instance = tells_instances(step).then(|| m.input("is_instance_i", 1));
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
    let place = m.register("place_q", 2);

    m.section("The job that is offered");
    let is_node = count.is(0).named("is_node");
    let next = (place.wire() + m.constant(2, 1)).named("next_place");
    let is_last = match nodes {
        NodeKind::Wide8 => next.equals(is_node.mux(m.constant(2, 2), count)),
        NodeKind::Wide4 | NodeKind::Quantised => is_node | next.equals(count),
    };
    let is_last = is_last.named("is_last");
    let fault = (busy.wire() & failed.wire()).named("fault");
    let offer = (busy.wire() & !failed.wire()).named("offer");
    let leaves = (offer & ready).named("leaves");

    m.section("The next block");
    let ends = ((leaves & is_last) | (fault & fault_taken)).named("ends");
    take.drive(block.port("valid") & (!busy.wire() | ends));
    let take = take.wire().comment("with the last job of a block, because the words of the next come a cycle later");
    busy.next(take | (busy.wire() & !ends));
    failed.next_when(take, block.port("failed"));
    context.next_when(take, block.port("context"));
    place.next_when(take | leaves, take.mux(m.constant(2, 0), next));

    m.section("The triangle");
    let triangle = match nodes {
        NodeKind::Wide4 | NodeKind::Wide8 => of_place(&words, place.wire()),
        NodeKind::Quantised => {
            let is_second = place.wire().bit(0);
            let is_second = is_instance.map_or(is_second, |is_instance| is_second & !is_instance);
            of_vertices(&words, is_second.named("is_second"))
        }
    };

    m.output("take_o", take);
    m.output("take_context_o", block.port("context"));
    m.output("offer_o", offer);
    m.output("fault_valid_o", fault);
    m.output("context_o", context.wire());
    m.output("is_node_o", is_node);
    m.output("place_o", place.wire().lower(step.place_bits()));
    m.output("is_last_o", is_last);
    triangle.iter().enumerate().for_each(|(k, wire)| m.output(&format!("triangle_{k}_o"), *wire));
    builder.finish()
}

/// The words of a block that its triangles need.
pub fn triangle_words(nodes: NodeKind) -> impl Iterator<Item = usize> {
    let (count, numbers) = match nodes {
        NodeKind::Wide4 | NodeKind::Wide8 => (VERTEX_WORDS * nodes.triangles_per_block() as usize, None),
        NodeKind::Quantised => (SHARED_VERTICES * 3, Some(VERTEX_NUMBERS)),
    };
    (0..count).chain(numbers)
}

/// Whether the issue tells the triangles of a block from an instance.
pub fn tells_instances(StepParameters { node, features, .. }: StepParameters) -> bool {
    node == NodeKind::Quantised && features.instances
}

/// The vertices of a quantised leaf's block.
const SHARED_VERTICES: usize = 4;

/// The coordinates of the triangle at a place, of triangles that follow each other.
fn of_place<'m>(words: &[Wire<'m>], place: Wire<'m>) -> Vec<Wire<'m>> {
    let triangles = words.chunks(VERTEX_WORDS);
    let coordinate = |k: usize| {
        let (first, others) = (words[k], (0..).zip(triangles.clone()).skip(1));
        others.fold(first, |before, (number, triangle)| place.is(number).mux(triangle[k], before))
    };
    (0..VERTEX_WORDS).map(coordinate).collect()
}

/// The coordinates of the first triangle or of the second, which has the vertices with the numbers in the last word.
fn of_vertices<'m>(words: &[Wire<'m>], is_second: Wire<'m>) -> Vec<Wire<'m>> {
    let m = is_second.builder();
    let numbers = words[3 * SHARED_VERTICES];
    let vertex = |corner: u32| {
        let of_second = numbers.bits(2 * corner + 1, 2 * corner);
        is_second.mux(of_second, m.constant(2, corner.into())).named(&format!("vertex_{corner}"))
    };
    let vertices = [0, 1, 2].map(vertex);
    m.unused("unused_numbers", &[numbers.upper(32 - 6)]);
    let coordinate = |k: usize| {
        let of_each: [Wire<'m>; SHARED_VERTICES] = std::array::from_fn(|number| words[3 * number + k % 3]);
        vertices[k / 3].select(&of_each)
    };
    (0..VERTEX_WORDS).map(coordinate).collect()
}
