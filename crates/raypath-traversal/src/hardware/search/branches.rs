//! The branches of trees that are read next.

use super::super::connect::{Inputs, hold, keep, named};
use super::super::queue::queue;
use super::wiring::{context_bits, one_hot, when};
use crate::search::{BRANCHES, SearchParameters};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The fields of a branch: the index of child 0, a bit for each child, and whether they are vectors.
pub const BRANCH: [(&str, u32); 3] = [("first", 32), ("children", 4), ("is_leaf", 1)];

/// The module `raypath_search_branches`.
///
/// A node of a tree is sent to the datapath where `sent_i` is 1, the last of its branch with `is_last_i`, and its outcome
/// comes where `valid_i` is 1, in the order of nodes: the boxes that the query is in, or the child of its key. If it has
/// children to read, they are kept. Where `visited_o` is 1, the last outcome of a branch of `visited_context_o` has come.
///
/// A search has no branches where `enter_i` is 1. Where `read_i` is 1, the branch that came last is read: it is there in
/// the next cycle, and until the next is read, if `is_there_o`. It leaves where `pop_i` is 1. `overflowed_o` has a bit for
/// each search with more branches than there are places.
pub fn branches(parameters: SearchParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_branches");
    let m = &builder;
    m.doc("The nodes of trees whose outcomes are to come, and the children that are read next.");
    let (width, contexts) = (context_bits(parameters), parameters.contexts);
    let columns = [("context", width), ("first", 32), ("is_leaf", 1), ("is_keys", 1), ("is_last", 1)];
    let sent = m.input("sent_i", 1);
    let of_sent = columns.map(|(name, width)| named(name, m.input(&format!("{name}_i"), width)));
    let valid = m.input("valid_i", 1);
    let (inside, child) = (m.input("inside_i", 4), m.input("child_i", 6));
    let [enter, read, pop] = ["enter", "read", "pop"]
        .map(|name| (m.input(&format!("{name}_i"), 1), m.input(&format!("{name}_context_i"), width)));

    m.section("The nodes whose outcomes are to come");
    // Each search has the nodes of one branch, four at most.
    let node = Inputs::default().port("push", sent).ports(of_sent).port("pop", valid).place(
        m,
        "u_nodes",
        &queue("raypath_search_nodes", 4 * contexts.next_power_of_two(), &columns)?,
    );
    let (context, is_keys) = (node.port("context"), node.port("is_keys"));
    let first = node.port("first") + when(is_keys, child.extend(32));
    let children = is_keys.mux(m.constant(4, 1), inside).named("children");

    m.section("The branches of each search, of which the last is next");
    let branches = (valid & children.any()).named("branches");
    let at = |(enable, context)| when(enable, one_hot(context, contexts));
    let place_bits = BRANCHES.ilog2();
    let counts: Vec<_> =
        (0..contexts).map(|k| m.register(&format!("count_{k}_q"), place_bits + 1).reset_to(0)).collect();
    let wires: Vec<Wire<'_>> = counts.iter().map(|count| count.wire()).collect();
    let (count, read_count) = (context.select(&wires).named("count"), read.1.select(&wires).named("read_count"));
    let pushes = (branches & !count.top()).named("pushes");
    let [adds, takes, clears] =
        [("adds", (pushes, context)), ("takes", pop), ("clears", enter)].map(|(name, access)| at(access).named(name));
    for (k, register) in (0..).zip(counts) {
        let step = m.concat(&[takes.bit(k).replicate(place_bits), takes.bit(k) | adds.bit(k)]);
        let next = register.wire() + step;
        register.next(when(!clears.bit(k), next));
    }
    let overflowed = m.register("overflowed_q", contexts).reset_to(0);
    overflowed.next((overflowed.wire() | at((branches & count.top(), context))) & !clears);
    let words = [first, children, node.port("is_leaf")];
    let words = BRANCH.iter().zip(words).map(|((name, _), wire)| named(name, wire)).collect();
    let depth = contexts.next_power_of_two() * BRANCHES as u32;
    let newest = read_count.lower(place_bits) - m.constant(place_bits, 1);
    let next = keep(
        "u_branches",
        depth,
        (pushes, m.concat(&[context, count.lower(place_bits)])),
        words,
        (read.0, m.concat(&[read.1, newest])),
    );

    next.into_iter().for_each(|(name, wire)| m.output(&format!("next_{name}_o"), wire));
    m.output("next_is_there_o", hold("is_there_q", read.0, read_count.any()));
    m.output("visited_o", valid & node.port("is_last"));
    m.output("visited_context_o", context);
    m.output("overflowed_o", overflowed.wire());
    builder.finish()
}
