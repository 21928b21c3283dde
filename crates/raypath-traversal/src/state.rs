//! What the unit keeps for a ray, what it learns, and what it asks for next.

use crate::codes::codes;
use crate::query::{Culls, InstanceFlags, InstanceWords, RayFlags, select_fields};
use crate::words::{Levels, WordCircuit};
use raypath_ops::{Bit, Circuit, Flags, Num, Select, Word, array_of, bundle};

codes! {
    /// The kinds of an [`Answer`].
    pub mod answer: "Answer", "What a ray learns in a step.", None;
    /// A ray begins.
    START = 0;
    /// The outcome of a box job.
    BOXES = 1;
    /// The outcomes of the triangle jobs of a block.
    BLOCK = 2;
    /// Nothing new: the ray asked to continue, because it reads its stack once in a step.
    CONTINUE = 3;
    /// The memory reported an error.
    ERROR = 4;
    /// A ray begins that its set-up refuses.
    REFUSED = 5;
    /// The constants of a ray in the space of an instance are there.
    ENTER = 6;
    /// The set-up refuses the ray in the space of an instance.
    CANNOT_ENTER = 7;
    /// What the user decides about a candidate.
    VERDICT = 8;
}

codes! {
    /// The kinds of a [`Request`].
    pub mod request: "Request", "What a ray asks for after a step.", None;
    /// To fetch a block.
    FETCH = 0;
    /// Another step, with the answer [`CONTINUE`](super::answer::CONTINUE).
    CONTINUE = 1;
    /// The ray is done.
    DONE = 2;
    /// The user's verdict on a candidate.
    CANDIDATE = 3;
}

codes! {
    /// The ways in which a ray ends.
    pub mod status: "Status", "How a ray ends: hit_status_o.", None;
    /// It hits nothing.
    MISS = 0;
    /// It hits a triangle.
    HIT = 1;
    /// It hits a procedural box, as the user decided.
    PROCEDURAL = 2;
    /// The ray was refused: its direction cannot be inverted, a value is not finite, or its flags have no meaning.
    REFUSED = 3;
    /// The memory reported an error.
    MEMORY = 4;
    /// The scene is not a tree of at most 64 levels, or has an instance that the ray cannot enter.
    SCENE = 5;
    /// The ray has read as many nodes as it may.
    LIMIT = 6;
    {
        /// Whether a ray that ends so has a hit.
        pub const fn is_hit(status: u32) -> bool {
            matches!(status, HIT | PROCEDURAL)
        }
    }
}

/// The index of what is in no instance.
pub const NO_INSTANCE: u32 = u32::MAX;

bundle! {
    /// What a step knows of a ray from its beginning.
    pub struct RayWords<C> {
        /// The child word of the root.
        pub root: Word<C, 32>,
        /// The distance from which on hits of boxes count.
        pub t_min: Num<C>,
        /// The distance below which hits count.
        pub t_max: Num<C>,
        /// The ray ends at the first block with a hit.
        pub any_hit: Bit<C>,
        /// Its other flags.
        pub flags: RayFlags<C>,
        /// The instances that count.
        pub cull_mask: Word<C, 8>,
    }

    /// The state of a ray between two steps, without the constants that its jobs need.
    pub struct RayState<C> {
        /// The ray ends at the first block with a hit.
        pub any_hit: Bit<C>,
        /// Its other flags.
        pub flags: RayFlags<C>,
        /// The instances that count: those whose masks have a bit of it.
        pub cull_mask: Word<C, 8>,
        /// The distance from which on hits of boxes count.
        pub t_min: Num<C>,
        /// The child word of the root.
        pub root: Word<C, 32>,

        /// The distance of the closest hit so far, or the ray's extent.
        pub extent: Num<C>,
        /// A triangle was hit.
        pub has_hit: Bit<C>,
        /// The numerator of the closest hit's distance.
        pub t_num: Num<C>,
        /// The denominator of its distance.
        pub t_denom: Num<C>,
        /// V of the closest hit; `t_denom` times the weight of vertex b.
        pub u_num: Num<C>,
        /// W of the closest hit; `t_denom` times the weight of vertex c.
        pub v_num: Num<C>,
        /// The ray meets its back face.
        pub back_face: Bit<C>,
        /// It is a procedural box.
        pub hit_is_box: Bit<C>,
        /// The index of the closest primitive.
        pub primitive: Word<C, 32>,
        /// The index of its geometry.
        pub geometry: Word<C, 32>,
        /// Its instance.
        pub hit_instance: InstanceWords<C>,

        /// The nodes and instances that were fetched.
        pub nodes: Word<C, 32>,
        /// The triangles that were fetched.
        pub triangles: Word<C, 32>,

        /// The level of the node that was fetched last; the root has level 0.
        pub level: Word<C, 7>,
        /// The levels with children that are not yet visited.
        pub pending: Levels<C>,
        /// Bit 0 of the place of the child, in the order of distance, through which the path descends at each level.
        pub place_low: Levels<C>,
        /// Bit 1 of that place.
        pub place_high: Levels<C>,
        /// The lowest level whose remaining children are on the stack.
        pub base: Word<C, 7>,
        /// The path descends again from the root, because the stack has lost the level `target`.
        pub restarting: Bit<C>,
        /// The level at which such a descent takes the next child.
        pub target: Word<C, 7>,

        /// The address of the leaf's block that was fetched last.
        pub leaf_address: Word<C, 32>,
        /// The triangles in this block and those after it.
        pub leaf_left: Word<C, 4>,
        /// The leaf counts as opaque.
        pub leaf_is_opaque: Bit<C>,
        /// The leaf is a procedural box.
        pub leaf_is_box: Bit<C>,

        /// The path is inside an instance: jobs need the constants in its space.
        pub inside: Bit<C>,
        /// That instance.
        pub instance: InstanceWords<C>,
        /// Its flags.
        pub instance_flags: InstanceFlags<C>,
        /// The level of that instance, the innermost. Its object begins one level deeper.
        pub instance_level: Word<C, 7>,
        /// The level of the outermost instance that the path is in.
        pub outer_level: Word<C, 7>,
    }

    /// The remaining children of a node, near to far: an entry of the stack.
    pub struct Group<C> {
        /// Whether each place has a child. Places are filled from 0.
        pub present: Flags<C, 3>,
        /// The child words.
        pub child: [Word<C, 32>; 3],
        /// The distances at which the ray enters their boxes.
        pub tmin: [Num<C>; 3],
    }

    /// A hit of a triangle, if there is one.
    pub struct TriangleHit<C> {
        /// There is one.
        pub is_hit: Bit<C>,
        /// There are further ones in its block.
        pub has_more: Bit<C>,
        /// Its distance: the quotient of the two numbers below.
        pub t: Num<C>,
        /// The numerator of the distance.
        pub t_num: Num<C>,
        /// The denominator of the distance.
        pub t_denom: Num<C>,
        /// V: `t_denom` times the weight of vertex b.
        pub u_num: Num<C>,
        /// W: `t_denom` times the weight of vertex c.
        pub v_num: Num<C>,
        /// Its vertices run clockwise as the ray's origin sees them.
        pub is_clockwise: Bit<C>,
        /// The triangle's index in its geometry.
        pub primitive: Word<C, 32>,
        /// The index of its geometry.
        pub geometry: Word<C, 32>,
    }

    /// What a ray learns in a step.
    pub struct Answer<C> {
        /// One of [`answer`].
        pub kind: Word<C, 4>,
        /// Of a box job: whether the child at each place of the order is hit. Hits come first.
        pub hit: Flags<C, 4>,
        /// Of a box job: the distances at places 1 to 3 of that order. The child at place 0 is never kept.
        pub tmin: [Num<C>; 3],
        /// Of a box job: the number of the child at each place.
        pub box_index: [Word<C, 2>; 4],
        /// Of the jobs of a node with eight children: the upper bit of the number of the child at each place. That at
        /// place 3 stands for all after it.
        pub box_upper: Flags<C, 4>,
        /// Of these jobs: which children are at these places, see [`Request::window`].
        pub window: Word<C, 2>,
        /// Of a box job: the child words in the order of their numbers, or what a node with eight children has of them.
        pub child: [Word<C, 32>; 4],
        /// Of the triangle jobs of a block: the closest hit. With a verdict, the candidate; a box has the user's distance.
        pub closest: TriangleHit<C>,
        /// Of a verdict: the candidate becomes the closest hit, if it is in the ray's range.
        pub verdict_accepts: Bit<C>,
        /// Of a verdict: the ray ends.
        pub verdict_ends: Bit<C>,
    }

    /// What a ray asks for after a step.
    pub struct Request<C> {
        /// One of [`request`].
        pub kind: Word<C, 2>,
        /// To fetch: the address of the block.
        pub address: Word<C, 32>,
        /// To fetch: the number of triangles in the block; 0 for a node, 2 for an instance: the number of its jobs.
        pub count: Word<C, 2>,
        /// To fetch a node with eight children: 0 for the nearest three of those that are hit, 1 for the next three,
        /// 2 for the last two.
        pub window: Word<C, 2>,
        /// To fetch: the block is that of an instance.
        pub is_instance: Bit<C>,
        /// An entry of the stack is written.
        pub writes: Bit<C>,
        /// The level of the entry.
        pub level: Word<C, 7>,
        /// The entry.
        pub group: Group<C>,
        /// To fetch triangles: those that are not hit.
        pub culls: Culls<C>,
        /// To fetch: the block was fetched before, for a candidate that was ignored.
        pub repeats: Bit<C>,
        /// When done: one of [`status`].
        pub status: Word<C, 3>,
    }
}

impl<C: WordCircuit> RayState<C> {
    /// The state of a ray that begins.
    #[inline(always)]
    pub fn begin(c: C, ray: RayWords<C>) -> Self {
        let RayWords { root, t_min, t_max, any_hit, flags, cull_mask } = ray;
        let (no, none) = (c.bit(false), Levels::none(c));
        Self {
            any_hit,
            flags,
            cull_mask,
            t_min,
            root,
            extent: t_max,
            has_hit: no,
            t_num: c.zero(),
            t_denom: c.zero(),
            u_num: c.zero(),
            v_num: c.zero(),
            back_face: no,
            hit_is_box: no,
            primitive: c.word(0),
            geometry: c.word(0),
            hit_instance: InstanceWords::none(c),
            nodes: c.word(0),
            triangles: c.word(0),
            level: c.word(0),
            pending: none,
            place_low: none,
            place_high: none,
            base: c.word(0),
            restarting: no,
            target: c.word(0),
            leaf_address: c.word(0),
            leaf_left: c.word(0),
            leaf_is_opaque: no,
            leaf_is_box: no,
            inside: no,
            instance: InstanceWords::none(c),
            instance_flags: InstanceFlags::none(c),
            instance_level: c.word(0),
            outer_level: c.word(0),
        }
    }
}

impl<C: Circuit> Group<C> {
    /// No children.
    #[inline(always)]
    pub fn none(c: C) -> Self {
        Self { present: Flags([c.bit(false); 3]), child: [c.word(0); 3], tmin: [c.zero(); 3] }
    }

    /// The children without the first.
    #[inline(always)]
    pub fn rest(self, c: C) -> Self {
        let Self { present: Flags([_, second, third]), child, tmin } = self;
        Self {
            present: Flags([second, third, c.bit(false)]),
            child: [child[1], child[2], child[2]],
            tmin: [tmin[1], tmin[2], tmin[2]],
        }
    }
}

impl<C: Circuit> Select<C> for Group<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        Self {
            present: Flags(array_of!(i => condition.select(if_true.present.0[i], if_false.present.0[i]))),
            child: array_of!(i => condition.select(if_true.child[i], if_false.child[i])),
            tmin: array_of!(i => condition.select(if_true.tmin[i], if_false.tmin[i])),
        }
    }
}

select_fields! {
    TriangleHit { is_hit, has_more, t, t_num, t_denom, u_num, v_num, is_clockwise, primitive, geometry }
}
