//! The rules of the operation with quantised boxes.

use super::boxes::number_of;
use super::job::{Job, Rule, rules as plain};
use crate::layout::Field;

/// What a ray and a compressed node can exercise, and the number of the children's order.
pub fn rules(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    let rounded = job.rounded();
    let [origin, direction] = [Field::Origin, Field::Direction].map(|field| job.vector(field));
    let [node, scale, inverse] = [Field::NodeOrigin, Field::NodeScale, Field::Inverse].map(|field| job.vector(field));
    let is_backwards: [bool; 3] = std::array::from_fn(|axis| {
        job.word(Field::Inverse(axis)).is_some_and(|code| job.semantics.format.is_sign_negative(code))
    });
    let extent = job.number(Field::Extent);
    let used = job.word(Field::Used).unwrap_or(0);
    let is_parallel = direction.map(|number| number == 0.0);
    let relative: [f64; 3] = std::array::from_fn(|k| rounded.sub(node[k], origin[k]));
    let factor = |k: usize, number: f64| if is_parallel[k] { number } else { rounded.mul(number, inverse[k]) };
    let (mut outside, mut inside, mut drops_out) = ([false; 2], false, false);
    let (mut is_inverted, mut is_flat) = (false, false);
    let (mut has_least, mut has_most) = (false, false);
    let mut entries: [(bool, bool, f64, usize); 4] = std::array::from_fn(|child| {
        let (mut tmin, mut tmax) = (0.0_f64, extent);
        for k in 0..3 {
            let offset = |is_max| job.word(Field::Offset { child, axis: k, is_max }).unwrap_or(0) as f64;
            let distance = |offset: f64| {
                let step = factor(k, scale[k]);
                rounded.add(rounded.mul(rounded.round(offset), step), factor(k, relative[k]))
            };
            let [min, max] = [offset(false), offset(true)];
            (is_inverted, is_flat) = (is_inverted || min > max, is_flat || min == max);
            (has_least, has_most) = (has_least || min == 0.0, has_most || max == 255.0);
            let [min, max] = [distance(min), distance(max)];
            let (near, far) = match (is_parallel[k], is_backwards[k]) {
                (true, _) => {
                    (outside[0], outside[1]) = (outside[0] || min > 0.0, outside[1] || max < 0.0);
                    inside |= min <= 0.0 && max >= 0.0;
                    let near = if min > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
                    (near, if max < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY })
                }
                (false, true) => (max, min),
                (false, false) => (min, max),
            };
            drops_out |= near.is_nan() || far.is_nan();
            // The host's maximum and minimum ignore NaN.
            (tmin, tmax) = (tmin.max(near), tmax.min(far));
        }
        let is_used = used >> child & 1 == 1;
        (is_used, is_used && tmin <= tmax, tmin, child)
    });
    let passed_unused = entries.iter().any(|(is_used, ..)| !is_used);
    let hits = entries.iter().filter(|entry| entry.1).count();
    let distance = |entry: &(bool, bool, f64, usize)| if entry.1 { entry.2 } else { f64::INFINITY };
    entries.sort_by(|a, b| b.1.cmp(&a.1).then(distance(a).total_cmp(&distance(b))).then(a.3.cmp(&b.3)));
    let same = (1..hits).filter(|&i| entries[i].2 == entries[i - 1].2).count();
    let rules = plain([
        ("1: runs forwards along an axis", is_backwards.contains(&false)),
        ("1: runs backwards along an axis", is_backwards.contains(&true)),
        ("parallel to a slab and inside", inside),
        ("parallel to a slab and before its min", outside[0]),
        ("parallel to a slab and beyond its max", outside[1]),
        ("2: a distance is NaN", drops_out),
        ("an offset of 0", has_least),
        ("an offset of 255", has_most),
        ("a flat child", is_flat),
        ("a child with min > max", is_inverted),
        ("a child is not used", passed_unused),
        ("3: extent +∞", extent == f64::INFINITY),
        ("3: extent NaN", extent.is_nan()),
        ("5: no hit", hits == 0),
        ("5: one hit", hits == 1),
        ("5: two hits", hits == 2),
        ("5: three hits", hits == 3),
        ("5: four hits", hits == 4),
        ("5: hits at the same distance", same > 0),
        ("5: all boxes are hit at the same distance", same == 3),
    ]);
    (rules, vec![number_of(entries.map(|(.., child)| child))])
}
