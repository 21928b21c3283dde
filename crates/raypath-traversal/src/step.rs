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
//!
//! An instance is a level of the path with one child, the root of its object. From there on, jobs need the constants of
//! the ray in the object's space. The ray leaves the instance when it takes a child of a level above, or begins again
//! at the root. With nested instances, the constants are those in the innermost: if the child is in an instance that is
//! neither the innermost nor none, the ray descends again from the root, which enters it again.

use crate::blocks::{BOX_KINDS, KINDS, MAX_LEAF, NODE_KIND, NodeKind, wide8};
use crate::instance::{INSTANCE_JOBS, INSTANCE_KIND};
use crate::query::{Front, InstanceFlags, InstanceWords, Queries};
use crate::state::{Answer, Group, RayState, Request, answer, request, status};
use crate::words::{LEVELS, Levels, WordCircuit, WordMethods, label};
use raypath_ops::{Bit, EdgeRule, Flags, Num, Select, Word, array_of, bundle};

/// The parameters of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepParameters {
    /// The number of entries of a ray's stack: 2, 4, 8, 16 or 32.
    pub stack: u32,
    /// The nodes of the scene.
    pub node: NodeKind,
    /// The order of the vertices of a front face.
    pub front: Front,
    /// The nodes and instances that a ray may read, a bound on the work in a scene that is not a tree: where it would
    /// read one more, it ends with [`status::LIMIT`]. 0 for no bound. It is an input of the hardware.
    pub node_limit: u32,
    /// Optional parts.
    pub features: UnitFeatures,
}

/// Optional parts of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UnitFeatures {
    /// Hits have barycentric coordinates.
    pub barycentrics: bool,
    /// To which triangles the points of an edge belong.
    pub edges: EdgeRule,
    /// Scenes have instances.
    pub instances: bool,
    /// Objects of instances have instances.
    pub nested: bool,
    /// What decides which primitives count.
    pub queries: Queries,
}

impl Default for StepParameters {
    /// A stack of 8 entries and wide nodes, without optional parts.
    fn default() -> Self {
        Self {
            stack: 8,
            node: NodeKind::Wide4,
            front: Front::default(),
            node_limit: NODE_LIMIT,
            features: UnitFeatures::OFF,
        }
    }
}

impl StepParameters {
    /// Whether the hardware has a field of the state, of an answer, of a request or of a hit, by a part of its name.
    pub(crate) fn has(self, field: &str) -> bool {
        (self.node == NodeKind::Wide8 || !["box_upper", "window"].iter().any(|part| field.contains(part)))
            && self.features.has(field)
    }

    /// Whether the boxes of nodes are decoded.
    pub(crate) fn has_decoder(self) -> bool {
        self.node != NodeKind::Wide4
    }

    /// What tells the jobs of a block apart, with its width.
    pub(crate) fn of_job(self) -> [(&'static str, u32); 2] {
        [("place", self.place_bits()), ("is_last", 1)]
    }

    /// The bits of the place of a job in its block.
    pub(crate) fn place_bits(self) -> u32 {
        (self.node.triangles_per_block() - 1).ilog2() + 1
    }
}

impl UnitFeatures {
    /// No optional parts.
    pub const OFF: Self =
        Self { barycentrics: false, edges: EdgeRule::Shared, instances: false, nested: false, queries: Queries::None };

    /// All optional parts.
    pub const ALL: Self =
        Self { barycentrics: true, edges: EdgeRule::Once, instances: true, nested: true, queries: Queries::Full };

    /// Whether there are flags of primitives and instances.
    pub(crate) fn has_flags(self) -> bool {
        self.queries != Queries::None
    }

    /// Whether there are candidates.
    pub(crate) fn has_candidates(self) -> bool {
        self.queries == Queries::Full
    }

    /// Whether these features need a field, by a part of its name.
    pub(crate) fn has(self, field: &str) -> bool {
        let is_one_of = |parts: &[&str]| parts.iter().any(|part| field.contains(part));
        (self.barycentrics || !is_one_of(&["u_num", "v_num"]))
            && (self.instances || !is_one_of(&["inside", "instance", "cull_mask"]))
            && (self.has_flags()
                || !is_one_of(&["flags_", "cull_mask", "culls_", "geometry", "custom_index", "shader_offset"]))
            && (self.has_candidates() || !is_one_of(&CANDIDATES))
            && (self.nested || !is_one_of(&["outer_level"]))
    }
}

/// Parts of the names of fields that candidates need.
const CANDIDATES: [&str; 9] =
    ["t_min", "is_box", "leaf_is", "has_more", "verdict", "repeats", "asks", "after_", "accepted"];

/// The usual [`StepParameters::node_limit`], more than any ray needs.
pub const NODE_LIMIT: u32 = 1 << 24;

bundle! {
    /// A step before the stack is read: what the state and the answer determine.
    pub struct HalfStep<C> {
        /// The state with the hit of the answer.
        pub state: RayState<C>,
        /// The ray begins.
        pub starts: Bit<C>,
        /// The ray's set-up or the memory failed.
        pub failed: Bit<C>,
        /// The failure is that of the set-up of a ray that begins.
        pub is_refused: Bit<C>,
        /// The failure is that of the set-up of a ray in the space of an instance.
        pub cannot_enter: Bit<C>,
        /// The path descends to a child of the tested node.
        pub descends: Bit<C>,
        /// A second descent does not find its path again, because the ray has become shorter.
        pub is_lost: Bit<C>,
        /// A block of the same leaf is fetched: the next, or the same once more.
        pub leaf_continues: Bit<C>,
        /// It is the same, for what comes after a candidate that was ignored.
        pub repeats: Bit<C>,
        /// The user is asked about a candidate.
        pub asks: Bit<C>,
        /// The ray ends with its first hit, or as the user decides.
        pub ends: Bit<C>,
        /// The next child comes from the deepest pending level, if there is one.
        pub pops: Bit<C>,
        /// There is no pending level.
        pub is_empty: Bit<C>,
        /// The ray has read as many nodes as it may.
        pub is_at_limit: Bit<C>,
        /// The stack has the deepest pending level.
        pub is_on_stack: Bit<C>,
        /// The deepest pending level.
        pub deepest: Word<C, 7>,
        /// The level whose children change.
        pub parent: Word<C, 7>,
        /// The place of the child there.
        pub place: Word<C, 2>,
        /// The child to which the path descends.
        pub child: Word<C, 32>,
        /// The children after it.
        pub rest: Group<C>,
    }
}

/// Computes a step of a ray: its next state, and what it asks for. `top` is the stack's entry of the deepest level that
/// is pending before the step ([`HalfStep::deepest`]), modulo the entries of the stack.
#[inline]
pub fn step<C: WordCircuit>(
    c: C,
    parameters: StepParameters,
    state: RayState<C>,
    answer: Answer<C>,
    top: Group<C>,
) -> (RayState<C>, Request<C>) {
    let half = prepare(c, parameters, state, answer, c.word(parameters.node_limit));
    finish(c, parameters, half, top)
}

/// The first half of a [`step`], which does not read the stack.
#[inline(always)]
pub fn prepare<C: WordCircuit>(
    c: C,
    parameters: StepParameters,
    state: RayState<C>,
    answer: Answer<C>,
    node_limit: Word<C, 32>,
) -> HalfStep<C> {
    let features = parameters.features;
    let is = |kind: u32| answer::CODES.is(answer.kind, kind);
    let starts = is(answer::START);
    let has_boxes = is(answer::BOXES);
    let has_block = is(answer::BLOCK);
    let continues = is(answer::CONTINUE);
    let is_refused = is(answer::REFUSED);
    let [root, index, custom_and_mask, offset_and_flags] = answer.child;
    let is_of_instance = |kind: u32| if features.instances { is(kind) } else { c.bit(false) };
    let (may_enter, may_not) = (is_of_instance(answer::ENTER), is_of_instance(answer::CANNOT_ENTER));
    let mask: Word<C, 8> = custom_and_mask.part::<24, 8>();
    let no_bit = Word::<C, 8>::new(c, c.word_and(8, mask.value, state.cull_mask.value)).is(0);
    // Its mask keeps the ray out, or it has no tree.
    let is_closed = if features.has_flags() { no_bit | root.is(0) } else { root.is(0) };
    let stays_out = (may_enter | may_not) & is_closed;
    let (enters, cannot_enter) = (may_enter & !is_closed, may_not & !is_closed);
    let failed = is(answer::ERROR) | is_refused | cannot_enter;

    let no = c.bit(false);
    let has_verdict = if features.has_candidates() { is(answer::VERDICT) } else { no };
    let block = tested_block(parameters, &state, &answer, has_block, has_verdict);
    let state = with_hit(parameters, state, &answer, block.commits);
    let is_done = (has_block & !block.asks) | has_verdict;
    let ends = (is_done & state.any_hit & state.has_hit) | (has_verdict & answer.verdict_ends);
    let goes_on = is_done & !ends;
    // After a hit that was accepted, no other of its block is closer.
    let repeats = goes_on & has_verdict & !block.commits & !state.leaf_is_box & answer.closest.has_more;
    let repeats = if features.has_candidates() { repeats } else { no };
    let has_next = c.word(parameters.node.triangles_per_block()).less(state.leaf_left);
    let leaf_moves = goes_on & !repeats & has_next;
    // Where the ray ends, it does not matter.
    let next_block = is_done & !repeats & has_next;
    let leaf_ends = goes_on & !repeats & !has_next;

    label!(c: starts, is_refused, may_enter, may_not, is_closed, enters, cannot_enter, failed, stays_out);
    label!(c: has_boxes, has_block, has_verdict, is_done, ends, goes_on, repeats, has_next, next_block, leaf_ends);

    // The child at `place` of the tested node, or the only child of an instance.
    let at_target = same(state.level, state.target);
    let along: Word<C, 3> = place_of(c, &state, state.level).widened();
    let first = state.restarting.select(at_target.select(along.plus_constant(1), along), c.word(0));
    let chosen = from_place(c, &answer, first, |item| child_of(c, parameters.node, &state, &answer, item));
    let descends = (has_boxes & chosen.hit) | enters;
    let is_lost = has_boxes & !chosen.hit & state.restarting;
    let is_hit = chosen.hit;
    label!(c: at_target, along, first, is_hit, descends, is_lost);

    // The first remaining child of the deepest pending level.
    let leaves = leaf_ends | continues | stays_out;
    let pops = leaves | (has_boxes & !chosen.hit & !state.restarting);
    let deepest = state.pending.deepest();
    // The constants are those of an instance that was fetched last, also if the ray stays out of it.
    let instance_level = (may_enter | may_not).select(state.level, state.instance_level);
    // The child is in an instance whose constants are gone.
    let leads_to_lost_space = if features.nested {
        state.inside & deepest.less(instance_level) & !deepest.less(state.outer_level)
    } else {
        no
    };
    let parent = descends.select(state.level, deepest);
    let after_deepest = place_of(c, &state, deepest).plus_constant(1);
    let place = descends.select(first.part::<0, 2>(), after_deepest);
    label!(c: leaves, pops, deepest, instance_level, leads_to_lost_space, after_deepest, parent, place);
    HalfStep {
        starts,
        failed,
        is_refused,
        cannot_enter,
        descends,
        is_lost,
        leaf_continues: leaf_moves | repeats,
        repeats,
        asks: block.asks,
        ends,
        pops,
        is_empty: state.pending.is_empty(),
        is_at_limit: !state.nodes.less(node_limit) & !node_limit.is(0),
        is_on_stack: !deepest.less(state.base) & !leads_to_lost_space,
        deepest,
        parent,
        place,
        child: enters.select(given(c, parameters.node, root), chosen.child),
        rest: Group { present: Flags(array_of!(i => chosen.rest.present.0[i] & !enters)), ..chosen.rest },
        state: RayState {
            inside: state.inside | enters,
            instance_level,
            instance: enters.select(
                InstanceWords {
                    index,
                    custom_index: custom_and_mask.part::<0, 24>(),
                    shader_offset: offset_and_flags.part::<0, 24>(),
                },
                state.instance,
            ),
            instance_flags: match features.has_flags() {
                true => enters.select(InstanceFlags::of(offset_and_flags), state.instance_flags),
                false => InstanceFlags::none(c),
            },
            outer_level: (enters & !state.inside).select(state.level, state.outer_level),
            leaf_address: next_block
                .select(state.leaf_address.plus_constant(parameters.node.block_bytes()), state.leaf_address),
            leaf_left: next_block.select(after_block(c, parameters.node, state.leaf_left), state.leaf_left),
            // The ray is on its path again where it takes the next child.
            restarting: state.restarting & !is_lost & !(descends & at_target),
            ..state
        },
    }
}

/// The second half of a [`step`].
#[inline(always)]
pub fn finish<C: WordCircuit>(
    c: C,
    parameters: StepParameters,
    half: HalfStep<C>,
    top: Group<C>,
) -> (RayState<C>, Request<C>) {
    let HalfStep { state, starts, descends, is_lost, leaf_continues, pops, is_empty, deepest, parent, .. } = half;
    let is_near = top.present.0[0] & top.tmin[0].compare(state.extent).less_or_equal();
    let is_read = pops & !is_empty & half.is_on_stack;
    let takes = is_read & is_near;
    let drops = is_read & !is_near;
    let restarts = pops & !is_empty & !half.is_on_stack;

    label!(c: is_near, is_read, takes, drops, restarts);

    let at_root = starts | restarts;
    let visits = at_root | descends | takes;
    let child = at_root.select(given(c, parameters.node, state.root), descends.select(half.child, top.child[0]));
    let level = at_root.select(c.word(0), parent.plus_constant(1));
    let leaves_instance = at_root | (takes & parent.less(state.instance_level));
    let inside = state.inside & !leaves_instance;
    let target = Target::of(c, parameters, child, level);
    let may_enter = if parameters.features.nested { c.bit(true) } else { !inside };
    let is_instance = if parameters.features.instances { target.is_instance & may_enter } else { c.bit(false) };
    let fetches_instance = visits & is_instance;
    let fetches_node = visits & target.is_node;
    let instance_flags = leaves_instance.select(InstanceFlags::none(c), state.instance_flags);
    let is_opaque = state.flags.is_opaque(target.is_opaque, instance_flags);
    let skips_leaf = if parameters.features.has_flags() {
        visits & target.is_leaf & state.flags.skip(target.is_box, is_opaque)
    } else {
        c.bit(false)
    };
    let begins_leaf = visits & target.is_leaf & !skips_leaf;
    let fetches_leaf = begins_leaf | leaf_continues;
    let left = leaf_continues.select(state.leaf_left, target.count);
    let full = parameters.node.triangles_per_block();
    let count = left.less(c.word(full)).select(left.part::<0, 2>(), c.word(full));
    label!(c: at_root, visits, child, level, leaves_instance, fetches_instance, fetches_node, is_opaque, skips_leaf);
    label!(c: inside, is_instance, begins_leaf, fetches_leaf, left, count);
    let address = leaf_continues.select(state.leaf_address, target.address);
    // A node with eight children may be visited once more.
    let keeps_address = if parameters.node == NodeKind::Wide8 { fetches_leaf | fetches_node } else { fetches_leaf };

    let visits_node = fetches_node | fetches_instance;
    let is_over_limit = visits_node & half.is_at_limit;
    let is_missing = visits & target.is_missing;
    let is_invalid = visits & !target.is_node & !target.is_leaf & !is_instance & !target.is_missing;
    let errs = half.failed | is_invalid | is_over_limit;
    let is_done = errs | half.ends | (pops & is_empty);
    label!(c: address, keeps_address, visits_node, is_over_limit, is_invalid, errs, instance_flags);

    let group = descends.select(half.rest, top.rest(c));
    let moves = descends | takes;
    let some_remain = group.present.0[0];
    let writes = moves & some_remain;
    let (changes, stays) = (moves | drops, some_remain & !drops);
    let (changing, moved) = (Levels::only(parent, changes), Levels::only(parent, moves));
    let changed = state.pending.with(changing, stays);
    label!(c: moves, some_remain, writes, changes, stays, changing, moved);

    let lowest = lowest_kept(c, parent, parameters.stack);
    let base = (writes & state.base.less(lowest)).select(lowest, state.base);
    let next = RayState {
        level: visits.select(level, state.level),
        pending: is_lost.select(state.pending.below(state.level), changed),
        place_low: state.place_low.with(moved, half.place.part::<0, 1>().is(1)),
        place_high: state.place_high.with(moved, half.place.part::<1, 1>().is(1)),
        base: restarts.select(c.word(0), base),
        restarting: restarts | state.restarting,
        target: restarts.select(deepest, state.target),
        nodes: (visits_node & !half.is_at_limit).select(state.nodes.plus_constant(1), state.nodes),
        triangles: fetches_leaf.select(state.triangles.plus(count.widened()), state.triangles),
        leaf_address: keeps_address.select(address, state.leaf_address),
        leaf_left: fetches_leaf.select(left, state.leaf_left),
        leaf_is_opaque: begins_leaf.select(is_opaque, state.leaf_is_opaque),
        leaf_is_box: begins_leaf.select(target.is_box, state.leaf_is_box),
        inside,
        instance: leaves_instance.select(InstanceWords::none(c), state.instance),
        instance_flags,
        ..state
    };
    let asks = |kind: u32| request::CODES.word(c, kind);
    let continues = drops | is_lost | skips_leaf | is_missing;
    let next_kind = continues.select(asks(request::CONTINUE), asks(request::FETCH));
    let kind = is_done.select(asks(request::DONE), next_kind);
    let kind =
        if parameters.features.has_candidates() { half.asks.select(asks(request::CANDIDATE), kind) } else { kind };
    let ends_as = |code: u32| status::CODES.word(c, code);
    let of_box = if parameters.features.has_candidates() { state.hit_is_box } else { c.bit(false) };
    let of_hit = of_box.select(ends_as(status::PROCEDURAL), ends_as(status::HIT));
    let found = state.has_hit.select(of_hit, ends_as(status::MISS));
    let of_scene = (is_invalid | half.cannot_enter).select(ends_as(status::SCENE), ends_as(status::LIMIT));
    let other_failure = (half.failed & !half.cannot_enter).select(ends_as(status::MEMORY), of_scene);
    let failure = half.is_refused.select(ends_as(status::REFUSED), other_failure);
    label!(c: lowest, next_kind, found, other_failure, failure);
    let request = Request {
        kind,
        address,
        count: fetches_node.select(c.word(0), fetches_instance.select(c.word(INSTANCE_JOBS), count)),
        window: target.window,
        is_instance: fetches_instance,
        writes,
        level: parent,
        group,
        culls: state.flags.culls(parameters.front, instance_flags),
        repeats: half.repeats,
        status: errs.select(failure, found),
    };
    (next, request)
}

/// What happens to the closest hit of a block.
struct TestedBlock<C: WordCircuit> {
    /// It becomes the closest hit of the ray.
    commits: Bit<C>,
    /// The user is asked about it.
    asks: Bit<C>,
}

/// What happens to the closest hit of a block, or to the candidate that it was. An opaque hit is committed if it is
/// closer, of hits at equal distances that of the lowest instance, geometry and index, in this order.
#[inline(always)]
fn tested_block<C: WordCircuit>(
    parameters: StepParameters,
    state: &RayState<C>,
    answer: &Answer<C>,
    has_block: Bit<C>,
    has_verdict: Bit<C>,
) -> TestedBlock<C> {
    let (c, hit, features) = (has_block.circuit, answer.closest, parameters.features);
    let distance = hit.t.compare(state.extent);
    let mut is_lower = hit.primitive.less(state.primitive);
    if features.has_flags() {
        is_lower = hit.geometry.less(state.geometry) | (same(hit.geometry, state.geometry) & is_lower);
    }
    if features.instances {
        label!(c: is_lower);
        let (index, of_hit) = (state.instance.index, state.hit_instance.index);
        is_lower = index.less(of_hit) | (same(index, of_hit) & is_lower);
    }
    // A hit at the ray's own end does not count.
    let wins_tie = state.has_hit & is_lower;
    let (is_nearer, is_as_near) = (distance.less(), distance.equal());
    let is_better = is_nearer | (is_as_near & wins_tie);
    let is_closer = has_block & hit.is_hit & is_better;
    label!(c: is_lower, wins_tie, is_nearer, is_as_near, is_better, is_closer);
    if !features.has_candidates() {
        return TestedBlock { commits: is_closer, asks: c.bit(false) };
    }
    let RayState { leaf_is_box: is_box, leaf_is_opaque, .. } = *state;
    let is_in_range = distance.less_or_equal() & hit.t.compare(state.t_min).greater_or_equal();
    let may_accept = !is_box | is_in_range;
    let accepts = has_verdict & answer.verdict_accepts & may_accept;
    let of_opaque = is_closer & leaf_is_opaque & !is_box;
    let commits = of_opaque | accepts;
    let asks = has_block & (is_box | (hit.is_hit & is_nearer & !leaf_is_opaque));
    label!(c: is_in_range, may_accept, accepts, of_opaque, commits, asks);
    TestedBlock { commits, asks }
}

/// Whether a face is a back face, from the order of its vertices.
#[inline(always)]
pub(crate) fn is_back_face<C: WordCircuit>(front: Front, flags: InstanceFlags<C>, is_clockwise: Bit<C>) -> Bit<C> {
    let is_flipped = match front {
        Front::CounterClockwise => flags.flipped,
        Front::Clockwise => !flags.flipped,
    };
    is_flipped.select(!is_clockwise, is_clockwise)
}

/// The state with a closest hit, if there is a new one. A box has its distance as a fraction, and no weights.
#[inline(always)]
fn with_hit<C: WordCircuit>(
    parameters: StepParameters,
    state: RayState<C>,
    answer: &Answer<C>,
    is_better: Bit<C>,
) -> RayState<C> {
    let (mut hit, c) = (answer.closest, is_better.circuit);
    let mut back_face = is_back_face(parameters.front, state.instance_flags, hit.is_clockwise);
    if parameters.features.has_candidates() {
        let is_box = state.leaf_is_box;
        (hit.t_num, hit.t_denom) =
            (is_box.select(hit.t, hit.t_num), is_box.select(Num::new(c, c.constant(1.0)), hit.t_denom));
        (hit.u_num, hit.v_num) = (is_box.select(c.zero(), hit.u_num), is_box.select(c.zero(), hit.v_num));
        back_face = back_face & !is_box;
    }
    RayState {
        extent: is_better.select(hit.t, state.extent),
        has_hit: state.has_hit | is_better,
        t_num: is_better.select(hit.t_num, state.t_num),
        t_denom: is_better.select(hit.t_denom, state.t_denom),
        u_num: is_better.select(hit.u_num, state.u_num),
        v_num: is_better.select(hit.v_num, state.v_num),
        back_face: is_better.select(back_face, state.back_face),
        hit_is_box: is_better.select(state.leaf_is_box, state.hit_is_box),
        primitive: is_better.select(hit.primitive, state.primitive),
        geometry: is_better.select(hit.geometry, state.geometry),
        hit_instance: is_better.select(state.instance, state.hit_instance),
        ..state
    }
}

/// The child through which the path descends, with the children after it.
struct Chosen<C: WordCircuit> {
    hit: Bit<C>,
    child: Word<C, 32>,
    rest: Group<C>,
}

/// The number of a child of a node.
#[derive(Clone, Copy)]
struct Item<C: WordCircuit> {
    index: Word<C, 2>,
    /// With eight children: the upper bit of the number.
    upper: Bit<C>,
    /// With eight children: it stands for those after it.
    continues: Bit<C>,
}

impl<C: WordCircuit> Select<C> for Item<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        Self {
            index: condition.select(if_true.index, if_false.index),
            upper: condition.select(if_true.upper, if_false.upper),
            continues: condition.select(if_true.continues, if_false.continues),
        }
    }
}

/// The child word of a child of a node.
#[inline(always)]
fn child_of<C: WordCircuit>(
    c: C,
    node: NodeKind,
    state: &RayState<C>,
    answer: &Answer<C>,
    Item { index, upper, continues }: Item<C>,
) -> Word<C, 32> {
    if node != NodeKind::Wide8 {
        c.label(format_args!("number"), &index);
        return numbered(answer.child, index);
    }
    let number = Word::new(c, c.word_join((1, c.word_of_bit(upper.value)), (2, index.value)));
    label!(c: index, upper, number);
    let once_more = wide8::continuation(c, state.leaf_address, answer.window);
    continues.select(once_more, wide8::child(c, answer.child, number))
}

/// A child word that does not come from a node.
#[inline(always)]
fn given<C: WordCircuit>(c: C, node: NodeKind, word: Word<C, 32>) -> Word<C, 32> {
    if node == NodeKind::Wide8 { wide8::given(c, word) } else { word }
}

/// The child at a place, 0 to 4, of the order of a box job, and those at the places after it. There is none at place 4.
#[inline(always)]
fn from_place<C: WordCircuit>(
    c: C,
    answer: &Answer<C>,
    place: Word<C, 3>,
    child: impl Fn(Item<C>) -> Word<C, 32>,
) -> Chosen<C> {
    let [one, two, four] = [place.part::<0, 1>(), place.part::<1, 1>(), place.part::<2, 1>()].map(|bit| bit.is(1));
    let number = place.part::<0, 2>();
    let no = c.bit(false);
    let Flags([a, b, d, e]) = answer.hit;
    let [w, x, y, z] = array_of!(i => {
        Item { index: answer.box_index[i], upper: answer.box_upper.0[i], continues: c.bit(i == 3) }
    });
    let [t, u, v] = answer.tmin;
    Chosen {
        hit: !four & numbered([a, b, d, e], number),
        child: child(numbered([w, x, y, z], number)),
        // The last place has nothing after it, that before it has one child, and so on.
        rest: Group {
            present: Flags([
                !four & numbered([b, d, e, no], number),
                !four & !two & one.select(e, d),
                !four & !two & !one & e,
            ]),
            child: [child(two.select(z, one.select(y, x))), child(one.select(z, y)), child(z)],
            tmin: [two.select(v, one.select(u, t)), one.select(v, u), v],
        },
    }
}

/// The value of this number.
#[inline(always)]
fn numbered<C: WordCircuit, T: Select<C>>(values: [T; 4], number: Word<C, 2>) -> T {
    let [low, high] = [number.part::<0, 1>().is(1), number.part::<1, 1>().is(1)];
    high.select(low.select(values[3], values[2]), low.select(values[1], values[0]))
}

/// A child word, decoded.
struct Target<C: WordCircuit> {
    /// There is nothing.
    is_missing: Bit<C>,
    is_node: Bit<C>,
    is_leaf: Bit<C>,
    is_instance: Bit<C>,
    /// The geometry of a leaf is opaque.
    is_opaque: Bit<C>,
    /// The leaf is a procedural box.
    is_box: Bit<C>,
    address: Word<C, 32>,
    /// Of a node with eight children: see [`Request::window`].
    window: Word<C, 2>,
    /// The number of triangles of a leaf.
    count: Word<C, 4>,
}

impl<C: WordCircuit> Target<C> {
    /// What a child word at this level refers to: nothing if its kind is not valid, or if a node or an instance is too
    /// deep.
    #[inline(always)]
    fn of(c: C, parameters: StepParameters, child: Word<C, 32>, level: Word<C, 7>) -> Self {
        let StepParameters { node, features, .. } = parameters;
        // The bits of the kind, and the address without them.
        let low = node.offset_bits();
        let part = |low, width| c.word_part(child.value, low, width);
        let kind: Word<C, 7> = match node {
            NodeKind::Wide4 | NodeKind::Wide8 => child.part::<0, 7>(),
            NodeKind::Quantised => child.part::<0, 6>().widened(),
        };
        label!(c: kind);
        let is = |known: u32| KINDS.is(kind, known);
        let fits = level.less(c.word(LEVELS));
        let last = if features.has_flags() { 2 * MAX_LEAF } else { MAX_LEAF };
        let is_triangles = !is(0) & kind.less(KINDS.word(c, last + 1));
        let (opaque_box, other_box) = (is(BOX_KINDS[0]), is(BOX_KINDS[1]));
        let is_box = if features.has_candidates() { opaque_box | other_box } else { c.bit(false) };
        let is_opaque = kind.less(KINDS.word(c, MAX_LEAF + 1)) | (opaque_box & is_box);
        // The count of a leaf is in the three lowest bits of its kind, where 0 stands for 8.
        let lowest: Word<C, 3> = child.part::<0, 3>();
        let lowest = Word::new(c, c.word_join((1, c.word_of_bit(lowest.is(0).value)), (3, lowest.value)));
        let count = if features.has_flags() { lowest } else { child.part::<0, 4>() };
        let address = Word::new(c, c.word_join((32 - low, part(low, 32 - low)), (low, c.constant_word(low, 0))));
        let is_instance = fits & is(INSTANCE_KIND);
        let mut is_node = is(NODE_KIND);
        let mut window = c.word(0);
        if node == NodeKind::Wide8 {
            let continues = [wide8::CONTINUATION, wide8::CONTINUATION + 1].map(&is);
            is_node = is_node | continues[0] | continues[1];
            window = kind.part::<6, 1>().is(1).select(kind.part::<0, 2>(), window);
        }
        c.label(format_args!("is_node_kind"), &is_node);
        let (is_missing, is_node, is_leaf) = (child.is(0), fits & is_node, is_triangles | is_box);
        label!(c: fits, is_missing, is_instance, is_node, is_triangles, opaque_box, is_box, is_leaf);
        Self { is_missing, is_node, is_leaf, is_instance, is_opaque, is_box, address, window, count }
    }
}

/// The place, 0 to 3, of the child through which the path descends at a level.
#[inline(always)]
fn place_of<C: WordCircuit>(c: C, state: &RayState<C>, level: Word<C, 7>) -> Word<C, 2> {
    let (place_1, place_0) = (state.place_high.has(level), state.place_low.has(level));
    let place = Word::new(c, c.word_join((1, c.word_of_bit(place_1.value)), (1, c.word_of_bit(place_0.value))));
    label!(c: place_1, place_0, place);
    place
}

/// The lowest level that a stack still has when it gets the entry of `level`.
#[inline(always)]
fn lowest_kept<C: WordCircuit>(c: C, level: Word<C, 7>, stack: u32) -> Word<C, 7> {
    let is_shallow = level.less(c.word(stack));
    is_shallow.select(c.word(0), level.plus_constant(128 - (stack - 1)))
}

/// The triangles that are left of a leaf after a full block.
#[inline(always)]
fn after_block<C: WordCircuit>(c: C, node: NodeKind, left: Word<C, 4>) -> Word<C, 4> {
    left.plus(c.word(16 - node.triangles_per_block()))
}

#[inline(always)]
fn same<C: WordCircuit, const W: u32>(a: Word<C, W>, b: Word<C, W>) -> Bit<C> {
    Bit::new(a.circuit, a.circuit.word_equal(a.value, b.value))
}
