//! The rules of the ray-box operation.

use super::job::{Job, Rule, rules as plain};
use crate::layout::Field;

/// The number of orders of four boxes.
pub const PERMUTATIONS: usize = 24;

/// The order with this number, 0 to 23.
pub fn permutation(number: usize) -> [usize; 4] {
    let mut left = vec![0, 1, 2, 3];
    [number / 6, number / 2 % 3, number % 2, 0].map(|index| left.remove(index))
}

/// The number of an order: the inverse of [`permutation`].
pub fn number_of([a, b, c, _]: [usize; 4]) -> usize {
    let rank = |x: usize, before: &[usize]| x - before.iter().filter(|&&y| y < x).count();
    6 * a + 2 * rank(b, &[a]) + rank(c, &[a, b])
}

/// The distances of a box's planes.
struct Distances {
    /// Whether a near distance is 0·∞.
    near_drops_out: bool,
    /// Whether a far distance is 0·∞.
    far_drops_out: bool,
    /// Whether a distance is NaN for another reason.
    is_other_nan: bool,
    /// The last near and the first far distance; NaN if all are.
    near: f64,
    far: f64,
    /// The ray's part inside the box, by rules `paper`.
    tmin: f64,
    tmax: f64,
    is_flat: bool,
    is_inverted: bool,
}

impl Distances {
    fn is_hit(&self) -> bool {
        self.tmin <= self.tmax
    }
}

/// What a ray and boxes can exercise, and their order: the number of the order of four, and the place of each of eight.
pub fn rules(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    let rounded = job.rounded();
    let origin = job.vector(Field::Origin);
    let inverse = [0, 1, 2].map(|axis| job.word(Field::Inverse(axis)).unwrap_or(0));
    let extent = job.number(Field::Extent);
    let count = if job.name == "octbox" { 8 } else { 4 };
    let mut bounds = vec![[[0.0; 2]; 3]; count];
    for (field, code) in job.each() {
        if let Field::Bound { index, axis, is_max } = field {
            bounds[index][axis][usize::from(is_max)] = rounded.value(code);
        }
    }
    let backwards = inverse.map(|code| job.semantics.format.is_sign_negative(code));
    let inverse = inverse.map(|code| rounded.value(code));
    let distances = |bounds: &[[f64; 2]; 3]| {
        let (mut nears, mut fars) = ([(0.0, false); 3], [(0.0, false); 3]);
        for (axis, slab) in bounds.iter().enumerate() {
            let distances = slab.map(|bound| {
                let relative = rounded.sub(bound, origin[axis]);
                let distance = rounded.mul(relative, inverse[axis]);
                (distance, distance.is_nan() && !relative.is_nan() && !inverse[axis].is_nan())
            });
            let side = usize::from(backwards[axis]);
            (nears[axis], fars[axis]) = (distances[side], distances[1 - side]);
        }
        // The host's maximum and minimum ignore NaN.
        let near = nears.iter().fold(f64::NAN, |last, (distance, _)| last.max(*distance));
        let far = fars.iter().fold(f64::NAN, |first, (distance, _)| first.min(*distance));
        Distances {
            near_drops_out: nears.iter().any(|(_, drops_out)| *drops_out),
            far_drops_out: fars.iter().any(|(_, drops_out)| *drops_out),
            is_other_nan: nears.iter().chain(&fars).any(|(distance, drops_out)| distance.is_nan() && !drops_out),
            near,
            far,
            tmin: near.max(0.0),
            tmax: far.min(extent),
            is_flat: bounds.iter().any(|[min, max]| min == max),
            is_inverted: bounds.iter().any(|[min, max]| min > max),
        }
    };
    let boxes: Vec<Distances> = bounds.iter().map(distances).collect();
    let entry = |(index, of): (usize, &Distances)| {
        let is_hit = of.is_hit();
        (is_hit, if is_hit { of.tmin } else { f64::INFINITY }, index)
    };
    let mut entries: Vec<(bool, f64, usize)> = boxes.iter().enumerate().map(entry).collect();
    entries.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let hits = entries.iter().filter(|entry| entry.0).count();
    let same = (1..hits).filter(|&i| entries[i].1 == entries[i - 1].1).count();

    let axis = |is: &dyn Fn(f64, bool) -> bool| (0..3).any(|axis| is(inverse[axis], backwards[axis]));
    let some = |is: &dyn Fn(&Distances) -> bool| boxes.iter().any(is);
    let mut rules = plain([
        ("1: runs forwards along an axis", backwards.contains(&false)),
        ("1: runs backwards along an axis", backwards.contains(&true)),
        ("1: inv = +∞, a direction of +0", axis(&|inverse, backwards| inverse.is_infinite() && !backwards)),
        ("1: inv = −∞, a direction of −0", axis(&|inverse, backwards| inverse.is_infinite() && backwards)),
        ("1: inv = ±0, an infinite direction", inverse.contains(&0.0)),
        ("1: inv = NaN", axis(&|inverse, _| inverse.is_nan())),
        ("2: a near distance 0·∞ drops out", some(&|b| b.near_drops_out)),
        ("2: a far distance 0·∞ drops out", some(&|b| b.far_drops_out)),
        ("2: a distance is NaN because an operand is", some(&|b| b.is_other_nan)),
        ("2: all near distances are NaN", some(&|b| b.near.is_nan())),
        ("2: all far distances and the extent are NaN", some(&|b| b.tmax.is_nan())),
        ("2: entry +0, the origin is past all near planes", some(&|b| b.near < 0.0)),
        ("2: entry +0, the last near plane is at ±0", some(&|b| b.near == 0.0)),
        ("3: extent +∞", extent == f64::INFINITY),
        ("3: extent NaN", extent.is_nan()),
        ("3: extent < 0", extent < 0.0),
        ("3: extent ±0", extent == 0.0),
        ("3: a hit ends at the extent", some(&|b| b.tmin < b.tmax && extent < b.far)),
        ("3: a box beyond the extent is missed", some(&|b| b.tmin > b.tmax && b.tmin <= b.far)),
        ("3: a box begins at the extent", some(&|b| b.tmin == b.tmax && extent < b.far)),
        ("4: tmin < tmax", some(&|b| b.tmin < b.tmax)),
        ("4: tmin = tmax, finite", some(&|b| b.tmin == b.tmax && b.tmin.is_finite())),
        ("4: tmin > tmax", some(&|b| b.tmin > b.tmax)),
        ("4: a flat box, tmin ≤ tmax", some(&|b| b.is_hit() && b.is_flat)),
        ("4: a box with min > max", some(&|b| b.is_inverted)),
        ("4: tmin = tmax = +∞", some(&|b| b.tmin == b.tmax && b.tmin.is_infinite())),
        ("5: hits at the same distance", same > 0),
        ("5: all boxes are hit at the same distance", same == count - 1),
        ("5: a hit at +∞ and a miss", (1..count).contains(&hits) && entries[hits - 1].1 == f64::INFINITY),
    ]);
    rules.extend((0..=count).map(|number| Rule::new(HITS[number], hits == number)));
    if job.semantics.features.conservative && job.name == "quadbox" {
        // 1 + 3 units in the last place.
        let factor = 1.0 + 3.0 * 2_f64.powi(1 - job.semantics.format.significand() as i32);
        let is_widened = |b: &Distances| b.tmin > b.tmax && b.tmin <= rounded.mul(b.tmax, factor);
        rules.push(Rule::new("a box is hit only because its end is widened", some(&is_widened)));
    }
    let places = entries.iter().enumerate();
    let order = match <[usize; 4]>::try_from(entries.iter().map(|(_, _, index)| *index).collect::<Vec<_>>()) {
        Ok(order) => vec![number_of(order)],
        Err(_) => places.map(|(place, (_, _, index))| 8 * index + place).collect(),
    };
    (rules, order)
}

/// The points of the number of hits.
const HITS: [&str; 9] = [
    "5: no hit",
    "5: one hit",
    "5: two hits",
    "5: three hits",
    "5: four hits",
    "5: five hits",
    "5: six hits",
    "5: seven hits",
    "5: eight hits",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_numbered() {
        for number in 0..PERMUTATIONS {
            assert_eq!(number_of(permutation(number)), number);
        }
    }
}
