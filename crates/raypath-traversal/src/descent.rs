//! The way of a ray through a scene, as a program over native numbers: in the same order as by [`step`], with the same
//! hit, end and counts, but faster. Tests compare the two.
//!
//! [`step`]: crate::step::step

use crate::answers::{Answers, ReadyRay};
use crate::blocks::{
    BLOCK_BYTES, BOX_KINDS, BOX_WORDS, LeafTriangle, MAX_LEAF, NODE_KIND, NodeKind, VERTEX_WORDS, child_words, word,
};
use crate::blocks::{quantised, wide8};
use crate::candidate::{Candidate, Verdict};
use crate::instance::{INSTANCE_KIND, Instance};
use crate::model::{Hit, HitInstance, Memory, RayRequest, Reply};
use crate::native::MAX_STACK;
use crate::query::{Front, instance_flags, ray_flags};
use crate::state::{NO_INSTANCE, status};
use crate::step::{StepParameters, UnitFeatures};
use crate::words::LEVELS;
use raypath_model::{NearestFirst, OneRay};
use raypath_ops::{Binary32, Ray, Rules, Word, array_of};

/// The stack of a ray, and the places on its path: kept from ray to ray, because they need not be cleared.
#[derive(Debug, Clone)]
pub(crate) struct Trail {
    /// By level, modulo the entries of the stack.
    stack: [Children; MAX_STACK],
    /// The place of the child through which the path descends, by level.
    places: [u8; LEVELS as usize],
}

/// The children of a node that are hit, near to far.
#[derive(Debug, Clone, Copy)]
struct Children {
    /// The place of the first that is not yet visited.
    next: u32,
    count: u32,
    child: [u32; 4],
    /// The distances at which the ray enters their boxes.
    tmin: [f32; 4],
}

impl Trail {
    pub fn new() -> Self {
        let children = Children { next: 0, count: 0, child: [0; 4], tmin: [0.0; 4] };
        Self { stack: [children; MAX_STACK], places: [0; LEVELS as usize] }
    }

    /// Traces a ray. Without SIMD instructions or with the rules `chisel` there is no reply.
    #[inline]
    pub fn trace(
        &mut self,
        answers: &Answers,
        parameters: StepParameters,
        memory: &(impl Memory + ?Sized),
        ray: &RayRequest,
        decide: &mut dyn FnMut(&Candidate) -> Verdict,
    ) -> Option<Reply> {
        let ready = answers.ready(ray);
        let now = OneRay::new(&ready.ray)?;
        let mut descent = Descent {
            answers,
            parameters,
            memory,
            ray,
            decide,
            ready,
            here: ready,
            now,
            extent: ray.t_max,
            best: None,
            best_is_box: false,
            nodes: 0,
            triangles: 0,
            instance: None,
        };
        // A copy for each, in which the rules are constants.
        let end = match answers.rules() {
            Rules::Chisel => return None,
            _ if ready.is_refused => Err(status::REFUSED),
            Rules::Paper => descent.visit_all(Rules::Paper, self),
            Rules::Bounds(bits) => descent.visit_all(Rules::Bounds(bits), self),
        };
        let Descent { best, best_is_box, nodes, triangles, .. } = descent;
        let found = match best {
            None => status::MISS,
            Some(_) if best_is_box => status::PROCEDURAL,
            Some(_) => status::HIT,
        };
        Some(Reply { status: end.err().unwrap_or(found), hit: best.filter(|_| end.is_ok()), nodes, triangles })
    }
}

struct Descent<'d, M: ?Sized> {
    answers: &'d Answers,
    parameters: StepParameters,
    memory: &'d M,
    ray: &'d RayRequest,
    decide: &'d mut dyn FnMut(&Candidate) -> Verdict,
    ready: ReadyRay,
    /// In the space of the instance, if the ray is in one.
    here: ReadyRay,
    /// In the space of the instance, if the ray is in one.
    now: OneRay,
    extent: f32,
    best: Option<Hit>,
    best_is_box: bool,
    nodes: u32,
    triangles: u32,
    /// The instance that the ray is in.
    instance: Option<Instance>,
}

/// A node after its boxes were tested.
struct TestedNode {
    found: NearestFirst,
    children: [u32; 4],
}

/// The kinds of child words that lead to a node with eight children once more.
const CONTINUATIONS: [u32; 2] = [wide8::CONTINUATION, wide8::CONTINUATION + 1];

/// The comparisons that sort each half of eight.
const SORT_HALVES: [(usize, usize); 10] =
    [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2), (4, 5), (6, 7), (4, 6), (5, 7), (5, 6)];

/// What a child word refers to.
enum Target {
    Missing,
    /// The address, and with eight children the window.
    Node(u32, u32),
    Instance(u32),
    /// The address, the number of triangles, and whether their geometry is opaque.
    Leaf(u32, u32, bool),
    /// The address, and whether the geometry is opaque.
    Box(u32, bool),
    Invalid,
}

impl<'d, M: Memory + ?Sized> Descent<'d, M> {
    /// Visits what the ray visits.
    ///
    /// # Errors
    /// The status of a ray that ends otherwise than with a hit or a miss.
    #[inline(always)]
    fn visit_all(&mut self, rules: Rules, Trail { stack, places }: &mut Trail) -> Result<(), u32> {
        let entries = self.parameters.stack;
        let slot = |level: u32| (level & (entries - 1)) as usize % MAX_STACK;
        let lowest_kept = |level: u32| (level + 1).saturating_sub(entries);
        // As in the state of a ray; `target` while it descends again.
        let (mut pending, mut base, mut target) = (0_u64, 0, None);
        let (mut instance_level, mut outer_level) = (0, 0);
        let root = self.given(self.ray.root);
        let (mut child, mut level) = (root, 0_u32);
        loop {
            match self.target_of(child, level) {
                Target::Node(address, window) => {
                    let TestedNode { found, children } = self.node(rules, address, window)?;
                    let mut place = 0;
                    let bit = 1 << level;
                    if let Some(level_to_take) = target {
                        place = usize::from(places[level as usize]) + usize::from(level == level_to_take);
                        if place >= found.count as usize {
                            // The ray has become shorter since.
                            pending &= bit - 1;
                        }
                        if level == level_to_take || place >= found.count as usize {
                            target = None;
                        }
                    }
                    if place < found.count as usize {
                        places[level as usize] = place as u8;
                        child = children[found.index[place % 4] as usize % 4];
                        if place + 1 < found.count as usize {
                            let after = &mut stack[slot(level)];
                            (after.next, after.count) = (place as u32 + 1, found.count);
                            after.child = array_of!(i => children[found.index[i] as usize % 4]);
                            after.tmin = found.tmin;
                            pending |= bit;
                            base = base.max(lowest_kept(level));
                        } else {
                            pending &= !bit;
                        }
                        level += 1;
                        continue;
                    }
                }
                Target::Instance(address) => {
                    let was_outside = self.instance.is_none();
                    // Its constants take the place of others, also if the ray stays out of it.
                    instance_level = level;
                    if let Some(root) = self.enter(address)? {
                        child = root;
                        places[level as usize] = 0;
                        outer_level = if was_outside { level } else { outer_level };
                        pending &= !(1 << level);
                        level += 1;
                        continue;
                    }
                }
                Target::Leaf(address, count, is_opaque) => {
                    if self.leaf(address, count, is_opaque)? {
                        return Ok(());
                    }
                }
                Target::Box(address, is_opaque) => {
                    if self.procedural(address, is_opaque)? {
                        return Ok(());
                    }
                }
                Target::Missing => {}
                Target::Invalid => return Err(status::SCENE),
            }
            // The next child of the deepest pending level, unless it is behind the hit.
            loop {
                if pending == 0 {
                    return Ok(());
                }
                let deepest = 63 - pending.leading_zeros();
                let is_in_lost_space = self.instance.is_some() && (outer_level..instance_level).contains(&deepest);
                if deepest < base || is_in_lost_space {
                    // The stack, or the constants in that space, are gone: the ray descends again.
                    (base, target, child, level) = (0, Some(deepest), root, 0);
                    self.leave();
                    break;
                }
                let Children { next, count, child: children, tmin } = &mut stack[slot(deepest)];
                let place = *next as usize % 4;
                if tmin[place] <= self.extent {
                    places[deepest as usize] = place as u8;
                    (child, level) = (children[place], deepest + 1);
                    *next += 1;
                    if next == count {
                        pending &= !(1 << deepest);
                    }
                    if deepest < instance_level {
                        self.leave();
                    }
                    break;
                }
                pending &= !(1 << deepest);
            }
        }
    }

    /// What a child word at this level refers to.
    #[inline(always)]
    fn target_of(&self, child: u32, level: u32) -> Target {
        let low = self.parameters.node.block_bytes() - 1;
        let UnitFeatures { instances, nested, .. } = self.parameters.features;
        let may_enter = instances && (nested || self.instance.is_none());
        let last_leaf = if self.parameters.features.has_flags() { 2 * MAX_LEAF } else { MAX_LEAF };
        let address = child & !low;
        match child & low {
            _ if child == 0 => Target::Missing,
            NODE_KIND if level < LEVELS => Target::Node(address, 0),
            kind if (1..=last_leaf).contains(&kind) => {
                Target::Leaf(address, (kind - 1) % MAX_LEAF + 1, kind <= MAX_LEAF)
            }
            kind if self.parameters.features.has_candidates() && BOX_KINDS.contains(&kind) => {
                Target::Box(address, kind == BOX_KINDS[0])
            }
            INSTANCE_KIND if level < LEVELS && may_enter => Target::Instance(address),
            kind if self.parameters.node == NodeKind::Wide8 && level < LEVELS && CONTINUATIONS.contains(&kind) => {
                Target::Node(address, kind - wide8::CONTINUATION + 1)
            }
            _ => Target::Invalid,
        }
    }

    /// The children of a node that are hit.
    #[inline(always)]
    fn node(&mut self, rules: Rules, address: u32, window: u32) -> Result<TestedNode, u32> {
        let block = self.fetch(address, 1, 0)?;
        let (found, children) = match self.parameters.node {
            NodeKind::Wide4 => {
                let block: &[u8; BLOCK_BYTES as usize] = block.first_chunk().ok_or(status::MEMORY)?;
                let boxes: &[[u8; 4 * BOX_WORDS]] = block.as_chunks().0;
                let children = array_of!(i => word(block, NodeKind::Wide4.child_word() + i));
                (self.now.boxes_of_bytes(rules, array_of!(i => &boxes[i])), children)
            }
            NodeKind::Quantised => {
                let slabs = quantised::slabs(block.first_chunk().ok_or(status::MEMORY)?);
                (self.now.slabs(rules, slabs), child_words(block, NodeKind::Quantised))
            }
            NodeKind::Wide8 => return self.eight(rules, address, window, block),
        };
        Ok(TestedNode { found: found.nearest_first(), children })
    }

    /// The children of a window of a node with eight.
    #[inline(always)]
    fn eight(&self, rules: Rules, address: u32, window: u32, block: &[u8]) -> Result<TestedNode, u32> {
        let bytes = block.first_chunk().ok_or(status::MEMORY)?;
        let slabs = wide8::slabs(bytes);
        let half = |first: usize| array_of!(axis => array_of!(side => array_of!(i => slabs[axis][side][first + i])));
        let halves = [self.now.slabs(rules, half(0)), self.now.slabs(rules, half(4))];
        // Distances are not negative, so they have the order of their bits.
        let mut keys: [u64; wide8::CHILDREN] = array_of!(i => {
            let (half, place) = (&halves[i / 4], i % 4);
            let key = u64::from(half.tmin[place].to_bits()) << 3 | i as u64;
            if half.hits >> place & 1 == 1 { key } else { u64::MAX }
        });
        for (a, b) in SORT_HALVES.into_iter().chain(wide8::MERGE) {
            (keys[a], keys[b]) = (keys[a].min(keys[b]), keys[a].max(keys[b]));
        }
        let first = (wide8::WINDOW * window) as usize;
        let count = keys.iter().skip(first).filter(|key| **key != u64::MAX).count().min(4) as u32;
        let key = |place: usize| keys.get(first + place).copied().unwrap_or(u64::MAX);
        let word = wide8::children(bytes);
        let children = array_of!(place => match place {
            3 => address | (wide8::CONTINUATION + window),
            _ => word((key(place) & 7) as usize),
        });
        let tmin = array_of!(place => f32::from_bits((key(place) >> 3) as u32));
        Ok(TestedNode { found: NearestFirst { count, index: [0, 1, 2, 3], tmin }, children })
    }

    /// A child word that does not come from a node.
    fn given(&self, word: u32) -> u32 {
        match self.parameters.node {
            NodeKind::Wide8 => wide8::given(Binary32, Word::truncate(word)).value,
            NodeKind::Wide4 | NodeKind::Quantised => word,
        }
    }

    /// Tests the triangles of a leaf. Returns whether the ray ends with their hit.
    #[inline(always)]
    fn leaf(&mut self, mut address: u32, mut left: u32, is_opaque: bool) -> Result<bool, u32> {
        let Some((is_opaque, culls)) = self.culls(is_opaque, ray_flags::SKIP_TRIANGLES) else { return Ok(false) };
        loop {
            let count = left.min(self.parameters.node.triangles_per_block());
            let block = self.fetch(address, 0, count)?;
            let found = self.found_in(block, count, culls);
            let ends = if is_opaque || !self.parameters.features.has_candidates() {
                found.for_each(|hit| self.commit_closer(hit));
                self.has(ray_flags::TERMINATE_ON_FIRST_HIT) && self.best.is_some()
            } else {
                let found: Vec<Hit> = found.collect();
                self.ask_about(found, address, count)?
            };
            left -= count;
            if ends || left == 0 {
                return Ok(ends);
            }
            address = address.wrapping_add(self.parameters.node.block_bytes());
        }
    }

    /// The triangles of a block that are hit and count, by their places.
    #[inline(always)]
    fn found_in(
        &self,
        block: &[u8],
        count: u32,
        [cull_back, cull_front]: [bool; 2],
    ) -> impl Iterator<Item = Hit> + use<M> {
        let (nodes, triangles) = (self.parameters.node, self.answers.triangles());
        let place = |i: usize| i.min(count as usize - 1);
        let number = |k: usize| f32::from_bits(word(block, k));
        let found = match nodes {
            // In order: vertices that are looked up take an eighth of the model's time.
            NodeKind::Wide4 | NodeKind::Wide8 => {
                self.now.triangles(triangles, |i, k| number(VERTEX_WORDS * place(i) + k))
            }
            NodeKind::Quantised => {
                let vertices: [_; 4] = array_of!(i => LeafTriangle::vertices(block, place(i), nodes));
                self.now.triangles(triangles, |i, k| number(3 * vertices[i][k / 3] + k % 3))
            }
        };
        let indices: [u32; 3] = array_of!(i => word(block, nodes.index_word() + i));
        let indices = if count == 1 { [indices[0]; 3] } else { indices };
        let (t_min, is_flipped, of_block) = (self.ray.t_min, self.is_flipped(), self.indices(block));
        let has_weights = self.parameters.features.barycentrics;
        (0..count as usize).filter(move |i| found.hits >> i & 1 == 1).filter_map(move |i| {
            let (t, t_num, t_denom) = (found.t[i], found.t_num[i], found.t_denom[i]);
            let back_face = (t_denom < 0.0) != is_flipped;
            let is_culled = if back_face { cull_back } else { cull_front };
            let barycentric = has_weights.then(|| found.edges.map(|edge| edge[i] / t_denom));
            let hit = Hit { primitive: indices[i], t, t_num, t_denom, back_face, barycentric, ..of_block };
            (t > t_min && !is_culled).then_some(hit)
        })
    }

    /// The indices of the primitives of a block, but for their own.
    #[inline(always)]
    fn indices(&self, block: &[u8]) -> Hit {
        let has_flags = self.parameters.features.has_flags();
        let geometry = if has_flags { LeafTriangle::geometry(block, self.parameters.node) } else { 0 };
        let instance = self.instance.map(|Instance { index, custom_index, shader_offset, .. }| match has_flags {
            true => HitInstance { index, custom_index, shader_offset },
            false => HitInstance { index, ..HitInstance::default() },
        });
        Hit { geometry, instance: instance.and_then(HitInstance::or_none), ..Hit::default() }
    }

    /// Commits an opaque hit if it is closer than the closest.
    #[inline(always)]
    fn commit_closer(&mut self, hit: Hit) {
        let order = |hit: &Hit| {
            let instance = hit.instance.map_or(NO_INSTANCE, |instance| instance.index);
            (instance, hit.geometry, hit.primitive)
        };
        let wins_tie = || self.best.as_ref().is_some_and(|best| order(&hit) < order(best));
        if hit.t < self.extent || (hit.t == self.extent && wins_tie()) {
            self.commit(hit, false);
        }
    }

    fn commit(&mut self, hit: Hit, is_box: bool) {
        self.extent = hit.t;
        self.now.set_extent(hit.t);
        (self.best, self.best_is_box) = (Some(hit), is_box);
    }

    /// Asks about the triangles of a block that count, the closest first. Returns whether the ray ends. For each after
    /// the first, the block is fetched once more.
    fn ask_about(&mut self, mut found: Vec<Hit>, address: u32, count: u32) -> Result<bool, u32> {
        found.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
        while let Some(&hit) = found.first().filter(|hit| hit.t < self.extent) {
            let candidate = self.candidate(hit, false, false);
            let Verdict { accepts, ends, .. } = (self.decide)(&candidate);
            if accepts {
                self.commit(hit, false);
            }
            if ends || (accepts && self.has(ray_flags::TERMINATE_ON_FIRST_HIT)) {
                return Ok(true);
            }
            if accepts || found.len() == 1 {
                break;
            }
            self.fetch(address, 0, count)?;
            found.retain(|other| (other.t, other.primitive) > (hit.t, hit.primitive));
        }
        Ok(false)
    }

    /// Asks about a procedural box. Returns whether the ray ends.
    fn procedural(&mut self, address: u32, is_opaque: bool) -> Result<bool, u32> {
        let Some((is_opaque, _)) = self.culls(is_opaque, ray_flags::SKIP_AABBS) else { return Ok(false) };
        let block = self.fetch(address, 0, 1)?;
        let indices = Hit { primitive: word(block, self.parameters.node.index_word()), ..self.indices(block) };
        let candidate = self.candidate(indices, true, is_opaque);
        let Verdict { accepts, ends, t } = (self.decide)(&candidate);
        let accepts = accepts && self.ray.t_min <= t && t <= self.extent;
        if accepts {
            let barycentric = self.parameters.features.barycentrics.then_some([0.0; 2]);
            self.commit(Hit { t, t_num: t, t_denom: 1.0, barycentric, ..indices }, true);
        }
        Ok(ends || (accepts && self.has(ray_flags::TERMINATE_ON_FIRST_HIT)))
    }

    fn candidate(&self, hit: Hit, is_box: bool, is_opaque: bool) -> Candidate {
        let Ray { origin, dir, .. } = self.here.ray;
        Candidate { hit, is_box, is_opaque, origin: origin.into(), direction: dir.into() }
    }

    /// Whether a leaf of this opacity counts as opaque, and whether its back and its front faces are culled; none if
    /// nothing of it is hit. `skip` is the flag that skips what it holds.
    #[inline(always)]
    fn culls(&self, is_opaque: bool, skip: u32) -> Option<(bool, [bool; 2])> {
        let of_instance = |flag: u32| self.instance.is_some_and(|instance| u32::from(instance.flags) & flag != 0);
        let (has_flags, has) = (self.parameters.features.has_flags(), |flag| self.has(flag));
        if !has_flags {
            // The triangles are tested all the same.
            let none = has(ray_flags::SKIP_TRIANGLES) || has(ray_flags::CULL_OPAQUE);
            let faces = [ray_flags::CULL_BACK_FACING_TRIANGLES, ray_flags::CULL_FRONT_FACING_TRIANGLES];
            return Some((true, faces.map(|flag| none || has(flag))));
        }
        let is_opaque = match () {
            () if has(ray_flags::OPAQUE) => true,
            () if has(ray_flags::NO_OPAQUE) => false,
            () if of_instance(instance_flags::FORCE_OPAQUE) => true,
            () if of_instance(instance_flags::FORCE_NO_OPAQUE) => false,
            () => is_opaque,
        };
        let is_skipped = has(if is_opaque { ray_flags::CULL_OPAQUE } else { ray_flags::CULL_NO_OPAQUE });
        if is_skipped || has(skip) {
            return None;
        }
        let (back, front) = (ray_flags::CULL_BACK_FACING_TRIANGLES, ray_flags::CULL_FRONT_FACING_TRIANGLES);
        let culls = !of_instance(instance_flags::FACING_CULL_DISABLE);
        Some((is_opaque, [back, front].map(|flag| culls && has(flag))))
    }

    /// Whether the clockwise faces are front faces.
    #[inline(always)]
    fn is_flipped(&self) -> bool {
        let is_flipped = self.instance.is_some_and(|instance| {
            self.parameters.features.has_flags() && u32::from(instance.flags) & instance_flags::FLIP_FACING != 0
        });
        is_flipped != (self.parameters.front == Front::Clockwise)
    }

    #[inline(always)]
    fn has(&self, flag: u32) -> bool {
        self.ray.flags & flag != 0
    }

    /// Enters an instance. Returns its only child, the root of its object, unless its mask keeps the ray out or it has
    /// none.
    #[inline(always)]
    fn enter(&mut self, address: u32) -> Result<Option<u32>, u32> {
        let block = self.fetch(address, 1, 0)?;
        let instance = Instance::of(block, self.parameters.node).ok_or(status::MEMORY)?;
        let is_masked = self.parameters.features.has_flags() && instance.mask & self.ray.cull_mask == 0;
        if is_masked || instance.root == 0 {
            return Ok(None);
        }
        let inside = self.answers.instance(self.parameters.node, &self.here, block);
        if inside.is_refused {
            return Err(status::SCENE);
        }
        self.now = OneRay::new(&inside.ray).ok_or(status::SCENE)?;
        self.here = inside;
        self.now.set_extent(self.extent);
        self.instance = Some(instance);
        Ok(Some(self.given(instance.root)))
    }

    /// Leaves the instance, if the ray is in one.
    #[inline(always)]
    fn leave(&mut self) {
        if self.instance.take().is_some() {
            self.now = OneRay::new(&self.ready.ray).unwrap_or(self.now);
            self.here = self.ready;
            self.now.set_extent(self.extent);
        }
    }

    /// A block of the memory, which counts as so many nodes and triangles.
    #[inline(always)]
    fn fetch(&mut self, address: u32, nodes: u32, triangles: u32) -> Result<&'d [u8], u32> {
        let limit = self.parameters.node_limit;
        if nodes > 0 && self.nodes >= limit && limit > 0 {
            return Err(status::LIMIT);
        }
        self.nodes = self.nodes.wrapping_add(nodes);
        self.triangles = self.triangles.wrapping_add(triangles);
        let address = RayRequest::address(self.ray.base, address);
        self.memory.block(address, self.parameters.node.block_bytes()).map_err(|_| status::MEMORY)
    }
}
