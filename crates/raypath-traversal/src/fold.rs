//! The closest hit of a block of triangles.

use crate::query::Culls;
use crate::state::TriangleHit;
use crate::words::WordCircuit;
use raypath_ops::{Bit, Num, Word, bundle};

bundle! {
    /// The limits that a ray sets to hits.
    pub struct HitLimits<C> {
        /// The distance beyond which hits count.
        pub t_min: Num<C>,
        /// The triangles that are not hit.
        pub culls: Culls<C>,
        /// The hit after which hits count.
        pub after: After<C>,
    }

    /// A hit of a block after which others count, in the order of distance, then of index: those before it were
    /// candidates already.
    pub struct After<C> {
        /// There is one.
        pub is_set: Bit<C>,
        /// Its distance.
        pub t: Num<C>,
        /// Its index.
        pub primitive: Word<C, 32>,
    }
}

/// The closest hit after one more triangle of a block, of several at the same distance that of the lowest index.
/// `before` is the closest hit of the triangles before it, which is ignored at the first triangle.
#[inline]
pub fn fold<C: WordCircuit>(
    before: TriangleHit<C>,
    is_first: Bit<C>,
    found: TriangleHit<C>,
    limits: HitLimits<C>,
) -> TriangleHit<C> {
    let is_culled = found.is_clockwise.select(limits.culls.clockwise, limits.culls.counter_clockwise);
    let After { is_set, t, primitive } = limits.after;
    let order = found.t.compare(t);
    let is_after = !is_set | order.greater() | (order.equal() & primitive.less(found.primitive));
    let counts = found.is_hit & !is_culled & found.t.compare(limits.t_min).greater() & is_after;
    let has_before = !is_first & before.is_hit;
    let distance = found.t.compare(before.t);
    let wins_tie = distance.equal() & found.primitive.less(before.primitive);
    let is_better = counts & (!has_before | distance.less() | wins_tie);
    let has_more = has_before & (counts | before.has_more);
    // The first is taken in any case: its indices are those of a block without a hit, too.
    TriangleHit { is_hit: counts | has_before, has_more, ..(is_better | is_first).select(found, before) }
}
