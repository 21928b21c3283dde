//! The rules of the operations with keys, points and spheres.

use super::job::{Job, Rule, rules};
use crate::layout::Field;
pub use raypath_ops::operations::key_compare::SEPARATORS;

/// What a key and separators can exercise, and the number of the child if the separators are in order.
pub fn keys(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    let key = job.number(Field::Key);
    let separators: [f64; SEPARATORS] = std::array::from_fn(|index| job.number(Field::Separator(index)));
    let ordered: Vec<f64> = separators.iter().copied().filter(|separator| !separator.is_nan()).collect();
    let is_ordered = ordered.is_sorted() && separators[ordered.len()..].iter().all(|separator| separator.is_nan());
    let child = ordered.iter().filter(|separator| **separator <= key).count();
    let rules = rules([
        ("the key equals a separator", ordered.contains(&key)),
        ("the key equals several separators", ordered.iter().filter(|separator| **separator == key).count() > 1),
        ("the key is between two separators", (1..ordered.len()).any(|i| ordered[i - 1] < key && key < ordered[i])),
        ("the key is ±0, a separator too", key == 0.0 && ordered.contains(&0.0)),
        ("the key is NaN", key.is_nan()),
        ("some separators are +∞", separators.contains(&f64::INFINITY)),
        ("some separators are NaN", ordered.len() < SEPARATORS),
        ("the separators are out of order", !is_ordered),
    ]);
    (rules, if is_ordered { vec![child] } else { Vec::new() })
}

/// What a point and four boxes can exercise.
pub fn points(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    let point = job.vector(Field::Point);
    let (mut count, mut on_face, mut is_inverted, mut has_nan) = (0, false, false, false);
    let mut outside = [[false; 2]; 3];
    for index in 0..4 {
        let bound = |axis, is_max| job.number(Field::Bound { index, axis, is_max });
        let (mut below, mut above) = ([false; 3], [false; 3]);
        let mut is_inside = true;
        let mut is_on_face = false;
        for axis in 0..3 {
            let (min, max, x) = (bound(axis, false), bound(axis, true), point[axis]);
            (below[axis], above[axis]) = (x < min, x > max);
            is_inside &= min <= x && x <= max;
            is_on_face |= x == min || x == max;
            is_inverted |= min > max;
            has_nan |= min.is_nan() || max.is_nan() || x.is_nan();
        }
        count += usize::from(is_inside);
        on_face |= is_inside && is_on_face;
        // A point that is outside in one direction only shows that this comparison counts.
        let ways = below.iter().chain(&above).filter(|is_outside| **is_outside).count();
        for axis in 0..3 {
            outside[axis][0] |= ways == 1 && below[axis];
            outside[axis][1] |= ways == 1 && above[axis];
        }
    }
    let rules = rules([
        ("in no box", count == 0),
        ("in one box", count == 1),
        ("in two boxes", count == 2),
        ("in three boxes", count == 3),
        ("in four boxes", count == 4),
        ("in a box, on its face", on_face),
        ("below a box in x alone", outside[0][0]),
        ("above a box in x alone", outside[0][1]),
        ("below a box in y alone", outside[1][0]),
        ("above a box in y alone", outside[1][1]),
        ("below a box in z alone", outside[2][0]),
        ("above a box in z alone", outside[2][1]),
        ("a box with min > max", is_inverted),
        ("a coordinate or bound is NaN", has_nan),
    ]);
    (rules, Vec::new())
}

/// What a ray and a sphere can exercise.
pub fn spheres(job: &Job<'_>) -> Vec<Rule> {
    let rounded = job.rounded();
    let [origin, d, centre] = [Field::Origin, Field::Direction, Field::Centre].map(|field| job.vector(field));
    let radius = job.number(Field::Radius);
    let f: [f64; 3] = std::array::from_fn(|k| rounded.sub(centre[k], origin[k]));
    let dot = |x: [f64; 3], y: [f64; 3]| {
        let [p, q, r] = std::array::from_fn(|k| rounded.mul(x[k], y[k]));
        rounded.add(rounded.add(p, q), r)
    };
    let across = |i: usize, j: usize| rounded.sub(rounded.mul(f[i], d[j]), rounded.mul(f[j], d[i]));
    let normal = [across(1, 2), across(2, 0), across(0, 1)];
    let square = rounded.mul(radius, radius);
    let (a, b, c) = (dot(d, d), dot(f, d), rounded.sub(dot(f, f), square));
    let discriminant = rounded.sub(rounded.mul(square, a), dot(normal, normal));
    let meets = discriminant >= 0.0 && a > 0.0;
    rules([
        ("a hit from outside", meets && discriminant > 0.0 && b > 0.0 && c > 0.0),
        ("a hit from inside, towards the centre", meets && b > 0.0 && c < 0.0),
        ("a hit from inside, away from the centre", meets && b < 0.0 && c < 0.0),
        ("b = 0", meets && b == 0.0),
        ("c = 0", meets && c == 0.0),
        ("c = 0, away from the centre", meets && c == 0.0 && b < 0.0),
        ("a miss because the sphere is behind", meets && b < 0.0 && c > 0.0),
        ("a miss because the line misses", discriminant < 0.0),
        ("a tangent, discriminant = 0", meets && discriminant == 0.0 && !a.is_infinite()),
        ("a = 0", a == 0.0),
        ("a is NaN", a.is_nan()),
        ("b is NaN", b.is_nan()),
        ("c is NaN, b is not", c.is_nan() && !b.is_nan()),
        ("the discriminant alone is NaN", discriminant.is_nan() && ![a, b, c].iter().any(|x| x.is_nan())),
        ("a negative radius", radius < 0.0),
        ("a radius of ±0", radius == 0.0),
    ])
}
