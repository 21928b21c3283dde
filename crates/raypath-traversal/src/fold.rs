//! The closest hit of a block of triangles.

use crate::state::TriangleHit;
use crate::words::WordCircuit;
use raypath_ops::{Bit, Num, Select, bundle};

bundle! {
    /// The limits that a ray sets to hits.
    pub struct HitLimits<C> {
        /// The least distance of a hit.
        pub t_min: Num<C>,
        /// Back faces are not hit.
        pub cull_back: Bit<C>,
        /// Front faces are not hit.
        pub cull_front: Bit<C>,
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
    let is_culled = found.back_face.select(limits.cull_back, limits.cull_front);
    let counts = found.is_hit & !is_culled & found.t.compare(limits.t_min).greater_or_equal();
    let has_before = !is_first & before.is_hit;
    let distance = found.t.compare(before.t);
    let wins_tie = distance.equal() & found.triangle.less(before.triangle);
    let is_better = counts & (!has_before | distance.less() | wins_tie);
    TriangleHit { is_hit: counts | has_before, ..is_better.select(found, before) }
}

impl<C: WordCircuit> Select<C> for TriangleHit<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        Self {
            is_hit: condition.select(if_true.is_hit, if_false.is_hit),
            t: condition.select(if_true.t, if_false.t),
            t_num: condition.select(if_true.t_num, if_false.t_num),
            t_denom: condition.select(if_true.t_denom, if_false.t_denom),
            u_num: condition.select(if_true.u_num, if_false.u_num),
            v_num: condition.select(if_true.v_num, if_false.v_num),
            back_face: condition.select(if_true.back_face, if_false.back_face),
            triangle: condition.select(if_true.triangle, if_false.triangle),
        }
    }
}
