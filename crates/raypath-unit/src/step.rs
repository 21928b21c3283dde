//! What happens to a ray when an answer arrives. The traversal with a short stack and a restart trail follows Laine,
//! "Restart Trail for Stackless BVH Traversal" (HPG 2010), for nodes with four children.
//!
//! The path from the root to the current node has a level for each node. The stack keeps, for each level with children
//! that are not yet visited, the remaining children near to far. It has fewer entries than there are levels: the entry
//! of level l is at l modulo their number, so deep levels overwrite high ones. `base` is the lowest level that is not
//! overwritten. `place` has, for each level, the place of the child through which the path descends. When the deepest
//! pending level lies below `base`, the ray descends again from the root along these places and takes the next child at
//! that level.
//!
//! Hits shorten the ray. A child behind the closest hit is skipped when its node is tested and again when it is taken
//! from the stack. Children at exactly that distance are visited, because they may have a triangle of a lower index.
//! Box tests of a second descent therefore find the same children in the same places, or fewer at the end.

use crate::blocks::{BLOCK_BYTES, MAX_LEAF, NODE_KIND, TRIANGLES_PER_BLOCK};
use crate::state::{Answer, Group, RayState, Request, answer, request, status};
use crate::words::{LEVELS, Levels, WordCircuit, WordMethods};
use raypath_ops::{Bit, Flags, Word};

/// The parameters of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepParameters {
    /// The number of entries of a ray's stack: 2, 4, 8, 16 or 32.
    pub stack: u32,
}

impl Default for StepParameters {
    /// A stack of 8 entries.
    fn default() -> Self {
        Self { stack: 8 }
    }
}

/// The number of nodes and of triangles, each, after which a ray ends with [`status::ERROR`]. It bounds the work of a
/// ray in a scene that is not a tree.
pub const VISIT_LIMIT: u32 = 1 << 24;

/// Computes a step of a ray: its next state, and what it asks for.
#[inline]
pub fn step<C: WordCircuit>(
    c: C,
    parameters: StepParameters,
    state: RayState<C>,
    answer: Answer<C>,
) -> (RayState<C>, Request<C>) {
    let starts = answer.kind.is(answer::START);
    let has_boxes = answer.kind.is(answer::BOXES);
    let has_triangle = answer.kind.is(answer::TRIANGLE);
    let continues = answer.kind.is(answer::CONTINUE);
    let failed = answer.kind.is(answer::ERROR);

    let state = with_triangle(state, &answer, has_triangle);
    let block_ends = has_triangle & answer.is_last;
    let ends_by_any_hit = block_ends & state.any_hit & state.has_hit;
    let leaf_continues = block_ends & !ends_by_any_hit & !state.leaf_left.is(0);
    let leaf_ends = block_ends & !ends_by_any_hit & state.leaf_left.is(0);

    // The child at `place` of the tested node.
    let at_target = same(state.level, state.target);
    let along = place_of(c, &state, state.level);
    let place = state.restarting.select(at_target.select(along.plus_constant(1), along), c.word(0));
    let chosen = from_place(c, &answer, place);
    let descends = has_boxes & chosen.hit;
    let is_lost = has_boxes & !chosen.hit & state.restarting;

    // The first remaining child of the deepest pending level.
    let pops = leaf_ends | continues | (has_boxes & !chosen.hit & !state.restarting);
    let deepest = state.pending.deepest();
    let is_empty = state.pending.is_empty();
    let is_on_stack = !deepest.less(state.base);
    let is_near = answer.top.present.0[0] & answer.top.tmin[0].compare(state.extent).less_or_equal();
    let takes = pops & !is_empty & is_on_stack & is_near;
    let drops = pops & !is_empty & is_on_stack & !is_near;
    let restarts = pops & !is_empty & !is_on_stack;

    let at_root = starts | restarts;
    let visits = at_root | descends | takes;
    let child = at_root.select(state.root, descends.select(chosen.child, answer.top.child[0]));
    let parent = descends.select(state.level, deepest);
    let level = at_root.select(c.word(0), parent.plus_constant(1));
    let target = Target::of(c, child, level);
    let fetches_node = visits & target.is_node;
    let fetches_leaf = (visits & target.is_leaf) | leaf_continues;
    let left = leaf_continues.select(state.leaf_left, target.count);
    let count = left.less(c.word(TRIANGLES_PER_BLOCK)).select(left.part::<0, 2>(), c.word(TRIANGLES_PER_BLOCK));
    let address = leaf_continues.select(state.leaf_address, target.address);

    let is_over_limit = !(state.nodes.less(c.word(VISIT_LIMIT)) & state.triangles.less(c.word(VISIT_LIMIT)));
    let errs = failed | (visits & !target.is_node & !target.is_leaf) | ((visits | leaf_continues) & is_over_limit);
    let is_done = errs | ends_by_any_hit | (pops & is_empty);

    let group = descends.select(chosen.rest, answer.top.rest(c));
    let group_level = parent;
    let writes = (descends | takes) & group.present.0[0];
    let pending = pending(&state, [descends, takes, drops, is_lost], group.present.0[0], group_level);
    let taken_place = descends.select(place, place_of(c, &state, deepest).plus_constant(1));
    let moves = descends | takes;
    let set_place = |levels: Levels<C>, bit: Bit<C>| moves.select(levels.with(group_level, bit), levels);

    let lowest = lowest_kept(c, group_level, parameters.stack);
    let base = (writes & state.base.less(lowest)).select(lowest, state.base);
    let next = RayState {
        level: visits.select(level, state.level),
        pending,
        place_low: set_place(state.place_low, taken_place.part::<0, 1>().is(1)),
        place_high: set_place(state.place_high, taken_place.part::<1, 1>().is(1)),
        base: restarts.select(c.word(0), base),
        restarting: restarts | (state.restarting & !is_lost & !(descends & at_target)),
        target: restarts.select(deepest, state.target),
        nodes: fetches_node.select(state.nodes.plus_constant(1), state.nodes),
        triangles: fetches_leaf.select(state.triangles.plus(count.widened()), state.triangles),
        leaf_address: fetches_leaf.select(address.plus_constant(BLOCK_BYTES), state.leaf_address),
        leaf_left: fetches_leaf.select(without(c, left, count), state.leaf_left),
        ..state
    };
    let fetches = fetches_node | fetches_leaf;
    let again = drops | is_lost;
    let kind = is_done.select(
        c.word(request::DONE),
        fetches.select(c.word(request::FETCH), again.select(c.word(request::CONTINUE), c.word(request::WAIT))),
    );
    let found = state.has_hit.select(c.word(status::HIT), c.word(status::MISS));
    let request = Request {
        kind,
        address,
        count: fetches_node.select(c.word(0), count),
        writes,
        level: group_level,
        group,
        status: errs.select(c.word(status::ERROR), found),
    };
    (next, request)
}

/// The state with the outcome of a triangle job: the closer hit, at equal distances that of the lower index.
#[inline(always)]
fn with_triangle<C: WordCircuit>(state: RayState<C>, answer: &Answer<C>, has_triangle: Bit<C>) -> RayState<C> {
    let distance = answer.t.compare(state.extent);
    let wins_tie = !state.has_hit | answer.triangle.less(state.triangle);
    let is_closer = distance.less() | (distance.equal() & wins_tie);
    let is_beyond = answer.t.compare(state.t_min).greater_or_equal();
    let is_better = has_triangle & answer.triangle_hit & is_beyond & is_closer;
    RayState {
        extent: is_better.select(answer.t, state.extent),
        has_hit: state.has_hit | is_better,
        triangle: is_better.select(answer.triangle, state.triangle),
        t_num: is_better.select(answer.t_num, state.t_num),
        t_denom: is_better.select(answer.t_denom, state.t_denom),
        back_face: is_better.select(answer.back_face, state.back_face),
        ..state
    }
}

/// The child through which the path descends, with the children after it.
struct Chosen<C: WordCircuit> {
    hit: Bit<C>,
    child: Word<C, 32>,
    rest: Group<C>,
}

/// The child at a place, 0 to 4, of the order of a box job. There is none at place 4.
#[inline(always)]
fn from_place<C: WordCircuit>(c: C, answer: &Answer<C>, place: Word<C, 3>) -> Chosen<C> {
    let Answer { hit: Flags(hit), child, tmin, .. } = *answer;
    let no = c.bit(false);
    let after = |from: usize| {
        let of = |i: usize| (from + i).min(3);
        Group {
            present: Flags(std::array::from_fn(|i| if from + i < 4 { hit[from + i] } else { no })),
            child: std::array::from_fn(|i| child[of(i)]),
            tmin: std::array::from_fn(|i| tmin[of(i) - 1]),
        }
    };
    let places = [0, 1, 2, 3].map(|k| Chosen { hit: hit[k], child: child[k], rest: after(k + 1) });
    let none = Chosen { hit: no, child: child[3], rest: after(4) };
    places.into_iter().enumerate().fold(none, |others, (k, one)| {
        let is_here = place.is(k as u32);
        Chosen {
            hit: is_here.select(one.hit, others.hit),
            child: is_here.select(one.child, others.child),
            rest: is_here.select(one.rest, others.rest),
        }
    })
}

/// A child word, decoded.
struct Target<C: WordCircuit> {
    is_node: Bit<C>,
    is_leaf: Bit<C>,
    address: Word<C, 32>,
    /// The number of triangles of a leaf.
    count: Word<C, 4>,
}

impl<C: WordCircuit> Target<C> {
    /// What a child word at this level refers to: neither a node nor a leaf if its kind is not valid, or if a node is
    /// too deep.
    #[inline(always)]
    fn of(c: C, child: Word<C, 32>, level: Word<C, 7>) -> Self {
        let kind = child.part::<0, 7>();
        let fits = level.less(c.word(LEVELS));
        let is_leaf = !kind.is(0) & kind.less(c.word(MAX_LEAF + 1));
        let block = child.part::<7, 25>();
        let address = Word::new(c, c.word_join((25, block.value), (7, c.constant_word(7, 0))));
        Self { is_node: fits & kind.is(NODE_KIND), is_leaf, address, count: child.part::<0, 4>() }
    }
}

/// The pending levels after a step that descends from a tested node, takes a child from the stack, drops an entry of
/// the stack, or does not find the path again. `level` is that of the node whose children change.
#[inline(always)]
fn pending<C: WordCircuit>(
    state: &RayState<C>,
    [descends, takes, drops, is_lost]: [Bit<C>; 4],
    some_remain: Bit<C>,
    level: Word<C, 7>,
) -> Levels<C> {
    let changed = state.pending.with(level, some_remain & !drops);
    let kept = (descends | takes | drops).select(changed, state.pending);
    is_lost.select(state.pending.below(state.level), kept)
}

/// The place, 0 to 3, of the child through which the path descends at a level.
#[inline(always)]
fn place_of<C: WordCircuit>(c: C, state: &RayState<C>, level: Word<C, 7>) -> Word<C, 3> {
    let bit = |levels: Levels<C>| c.word_of_bit(levels.has(level).value);
    let place = c.word_join((1, bit(state.place_high)), (1, bit(state.place_low)));
    Word::<C, 2>::new(c, place).widened()
}

/// The lowest level that a stack still has when it gets the entry of `level`.
#[inline(always)]
fn lowest_kept<C: WordCircuit>(c: C, level: Word<C, 7>, stack: u32) -> Word<C, 7> {
    let is_shallow = level.less(c.word(stack));
    is_shallow.select(c.word(0), level.plus_constant(128 - (stack - 1)))
}

/// `left` less `count`, which is at most `left`.
#[inline(always)]
fn without<C: WordCircuit>(c: C, left: Word<C, 4>, count: Word<C, 2>) -> Word<C, 4> {
    let count: Word<C, 4> = count.widened();
    left.plus(Word::new(c, c.word_not(4, count.value)).plus_constant(1))
}

#[inline(always)]
fn same<C: WordCircuit>(a: Word<C, 7>, b: Word<C, 7>) -> Bit<C> {
    Bit::new(a.circuit, a.circuit.word_equal(a.value, b.value))
}
