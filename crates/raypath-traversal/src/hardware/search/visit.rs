//! What a turn does with a branch of a tree.

use super::super::scheduler::lowest;
use super::wiring::{number_of, when};
use raypath_hdl::{Builder, Wire};

/// What a turn does with the branch of its search, if the unit has trees: else, nothing.
pub struct Visit<'m> {
    /// The step asks for a node, or for a vector, of this index.
    pub asks_node: Wire<'m>,
    pub asks_vector: Wire<'m>,
    pub index: Wire<'m>,
    /// It is the last node of its branch.
    pub is_last: Wire<'m>,
    /// The vectors of a range of keys come next, from the index on.
    pub scans: Wire<'m>,
    /// The branch is taken, in the first step of a turn.
    pub begins: Wire<'m>,
    /// The turn ends, and the children of a node were read; or the search has no branches, or may not read more.
    pub ends: Wire<'m>,
    pub expands: Wire<'m>,
    pub drains: Wire<'m>,
}

/// What a turn knows of its search.
pub struct OfTurn<'m> {
    pub visits: Wire<'m>,
    pub step: Wire<'m>,
    pub moves: Wire<'m>,
    pub is_keys: Wire<'m>,
    pub has_failed: Wire<'m>,
    pub may_expand: Wire<'m>,
}

impl<'m> Visit<'m> {
    pub fn none(m: &'m Builder) -> Self {
        let (no, index) = (m.constant(1, 0), m.constant(32, 0));
        let [asks_node, asks_vector, is_last, scans, begins, ends, expands, drains] = [no; 8];
        Self { asks_node, asks_vector, index, is_last, scans, begins, ends, expands, drains }
    }

    /// A branch is visited in a turn: each step asks for one of the children, or for one of the four vectors of a child.
    pub fn of_branch(m: &'m Builder, [first, children, is_leaf, is_there]: [Wire<'m>; 4], of: &OfTurn<'m>) -> Self {
        let OfTurn { visits, step, moves, is_keys, has_failed, may_expand } = *of;
        let (is_first, vector) = (!step.any(), step.lower(2));
        let cannot = (!is_there | has_failed | (!is_leaf & !may_expand)).named("cannot_visit");
        let drains = (visits & is_first & cannot).named("drains_tree");
        let goes = (visits & !drains).named("goes_on_in_tree");
        let scans = (goes & is_leaf & is_keys).named("scans_range");
        let rest_q = m.register("rest_of_children_q", 4);
        let rest = is_first.mux(children, rest_q.wire()).named("rest_of_children");
        let child = lowest(rest).named("child");
        let ends_child = !is_leaf | vector.all();
        rest_q.next_when(moves, rest & !when(ends_child, child));
        let is_last = (!(rest ^ child).any()).named("is_last_child");
        let number = number_of(child);
        let index = is_leaf.mux(m.concat(&[number, vector]), m.concat(&[m.constant(2, 0), number]));
        let asks = (goes & !scans).named("asks_child");
        let ends = (goes & (scans | (is_last & ends_child))).named("ends_branch");
        Self {
            asks_node: asks & !is_leaf,
            asks_vector: asks & is_leaf,
            index: first + when(!scans, index).extend(32),
            is_last,
            scans,
            begins: goes & is_first,
            ends,
            expands: ends & !is_leaf,
            drains,
        }
    }
}
