//! The closest hit of a block of triangles.

use crate::query::Culls;
use crate::state::TriangleHit;
use crate::words::{WordCircuit, label};
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
    let passes = found.is_hit & !is_culled & found.t.compare(limits.t_min).greater();
    let counts = passes & is_after;
    let has_before = !is_first & before.is_hit;
    let distance = found.t.compare(before.t);
    let wins_tie = distance.equal() & found.primitive.less(before.primitive);
    let is_better = counts & (!has_before | distance.less() | wins_tie);
    let has_more = has_before & (counts | before.has_more);
    let c = is_first.circuit;
    // The first is taken in any case: its indices are those of a block without a hit, too.
    let is_taken = is_better | is_first;
    label!(c: is_first, is_culled, is_after, passes, counts, has_before, has_more, is_better, is_taken);
    TriangleHit { is_hit: counts | has_before, has_more, ..is_taken.select(found, before) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answers::no_hit;
    use raypath_ops::Binary32;

    /// Candidates of a block: each hit once, near to far and of the same distance the lower index, if nothing is
    /// accepted. A fold only compares, so three distances and three indices stand for those of any three triangles.
    #[test]
    fn each_hit_of_a_block_is_reported_once() {
        const ORDERS: [[u32; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let mut reports = 0;
        for (case, order, count) in (0..64_u32)
            .flat_map(|case| ORDERS.map(|order| (case, order)))
            .flat_map(|(case, order)| [1, 2, 3].map(|count| (case, order, count)))
        {
            // A distance of 0 is a miss.
            let distance = |place: usize| case >> (2 * place) & 3;
            let triangle = |place: usize| TriangleHit::<Binary32> {
                is_hit: (distance(place) > 0).into(),
                t: (distance(place) as f32).into(),
                primitive: Word::truncate(order[place]),
                ..no_hit()
            };
            let mut expected: Vec<(u32, u32)> = (0..count).map(|place| (distance(place), order[place])).collect();
            expected.retain(|(distance, _)| *distance > 0);
            expected.sort_unstable();
            let mut found: Vec<(u32, u32)> = Vec::new();
            loop {
                let (t, primitive) = found.last().copied().unwrap_or_default();
                let after = After {
                    is_set: (!found.is_empty()).into(),
                    t: (t as f32).into(),
                    primitive: Word::truncate(primitive),
                };
                let culls = Culls { clockwise: false.into(), counter_clockwise: false.into() };
                let limits = HitLimits { t_min: 0.0.into(), culls, after };
                let closest = (0..count)
                    .fold(no_hit(), |before, place| fold(before, (place == 0).into(), triangle(place), limits));
                if !bool::from(closest.is_hit) {
                    break;
                }
                found.push((f32::from(closest.t) as u32, closest.primitive.value));
                assert_eq!(bool::from(closest.has_more), found.len() < expected.len(), "{case:#b}, {order:?}, {count}");
            }
            assert_eq!(found, expected, "{case:#b}, {order:?}, {count}");
            reports += found.len();
        }
        assert_eq!(reports, 6 * (48 + 96 + 144));
    }
}
