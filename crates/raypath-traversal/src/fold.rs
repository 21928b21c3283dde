//! The closest hit of a block of triangles.

use crate::query::Culls;
use crate::state::TriangleHit;
use crate::words::WordCircuit;
use raypath_ops::{Bit, Num, bundle};

bundle! {
    /// The limits that a ray sets to hits.
    pub struct HitLimits<C> {
        /// The distance beyond which hits count.
        pub t_min: Num<C>,
        /// The triangles that are not hit.
        pub culls: Culls<C>,
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
    let counts = found.is_hit & !is_culled & found.t.compare(limits.t_min).greater();
    let has_before = !is_first & before.is_hit;
    let distance = found.t.compare(before.t);
    let wins_tie = distance.equal() & found.primitive.less(before.primitive);
    let is_better = counts & (!has_before | distance.less() | wins_tie);
    TriangleHit { is_hit: counts | has_before, ..is_better.select(found, before) }
}
