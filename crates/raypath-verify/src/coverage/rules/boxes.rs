//! The rules of the ray-box operation.

use super::declare::{fields, rules};
use super::rounded::Rounded;
use crate::layout::{Field, Layout};
use raypath_ops::JobKind;

rules! {
    /// What a ray and four boxes can exercise.
    BoxRule {
        Forwards = "1: runs forwards along an axis",
        Backwards = "1: runs backwards along an axis",
        InverseInfinite = "1: inv = +∞, a direction of +0",
        InverseMinusInfinite = "1: inv = −∞, a direction of −0",
        InverseZero = "1: inv = ±0, an infinite direction",
        InverseNan = "1: inv = NaN",
        NearNan = "2: a near distance 0·∞ drops out",
        FarNan = "2: a far distance 0·∞ drops out",
        OtherNan = "2: a distance is NaN because an operand is",
        NearsAllNan = "2: all near distances are NaN",
        FarsAllNan = "2: all far distances and the extent are NaN",
        Inside = "2: entry +0, the origin is past all near planes",
        NearZero = "2: entry +0, the last near plane is at ±0",
        ExtentInfinite = "3: extent +∞",
        ExtentNan = "3: extent NaN",
        ExtentNegative = "3: extent < 0",
        ExtentZero = "3: extent ±0",
        ExtentEnds = "3: a hit ends at the extent",
        ExtentMisses = "3: a box beyond the extent is missed",
        ExtentTouches = "3: a box begins at the extent",
        Crossed = "4: tmin < tmax",
        Touched = "4: tmin = tmax, finite",
        Missed = "4: tmin > tmax",
        Flat = "4: a flat box, tmin ≤ tmax",
        Inverted = "4: a box with min > max",
        AtInfinity = "4: tmin = tmax = +∞",
        NoHit = "5: no hit",
        OneHit = "5: one hit",
        TwoHits = "5: two hits",
        ThreeHits = "5: three hits",
        FourHits = "5: four hits",
        Tie = "5: hits at the same distance",
        TieOfFour = "5: four hits at the same distance",
        InfiniteTie = "5: a hit at +∞ and a miss",
    }
}

/// The number of orders of four boxes.
pub const PERMUTATIONS: usize = 24;

/// The order with this number, 0 to 23.
pub fn permutation(number: usize) -> [usize; 4] {
    let mut left = vec![0, 1, 2, 3];
    [number / 6, number / 2 % 3, number % 2, 0].map(|index| left.remove(index))
}

/// The number of an order: the inverse of [`permutation`].
fn number_of([a, b, c, _]: [usize; 4]) -> usize {
    let rank = |x: usize, before: &[usize]| x - before.iter().filter(|&&y| y < x).count();
    6 * a + 2 * rank(b, &[a]) + rank(c, &[a, b])
}

impl BoxRule {
    /// Calls `visit` with each rule that a job exercises, possibly more than once, and returns the number of the boxes'
    /// order.
    pub fn each(rounded: Rounded, layout: &Layout, words: &[u64], mut visit: impl FnMut(Self)) -> usize {
        let (mut origin, mut inverse, mut bounds) = ([0.0; 3], [0; 3], [[[0.0; 2]; 3]; 4]);
        let mut extent = 0.0;
        for (field, code) in fields(layout, JobKind::Quadbox, words) {
            match field {
                Field::Origin(axis) => origin[axis] = rounded.value(code),
                Field::Inverse(axis) => inverse[axis] = code,
                Field::Extent => extent = rounded.value(code),
                Field::Bound { index, axis, is_max } => {
                    bounds[index][axis][usize::from(is_max)] = rounded.value(code);
                }
                _ => {}
            }
        }
        let backwards = inverse.map(|code| rounded.0.is_sign_negative(code));
        let inverse = inverse.map(|code| rounded.value(code));
        (0..3).for_each(|axis| of_axis(backwards[axis], inverse[axis], &mut visit));
        of_extent(extent, &mut visit);
        let mut entries = [(false, 0.0, 0); 4];
        for (index, bounds) in bounds.iter().enumerate() {
            let (mut nears, mut fars) = ([0.0; 3], [0.0; 3]);
            for (axis, slab) in bounds.iter().enumerate() {
                let distances = slab.map(|bound| {
                    let relative = rounded.sub(bound, origin[axis]);
                    let distance = rounded.mul(relative, inverse[axis]);
                    (distance, distance.is_nan() && !relative.is_nan() && !inverse[axis].is_nan())
                });
                let side = usize::from(backwards[axis]);
                let (near, far) = (distances[side], distances[1 - side]);
                if near.1 {
                    visit(Self::NearNan);
                }
                if far.1 {
                    visit(Self::FarNan);
                }
                if distances.iter().any(|(distance, is_zero_by_infinity)| distance.is_nan() && !is_zero_by_infinity) {
                    visit(Self::OtherNan);
                }
                (nears[axis], fars[axis]) = (near.0, far.0);
            }
            let (hit, tmin) = of_interval(nears, fars, extent, &mut visit);
            if hit && bounds.iter().any(|[min, max]| min == max) {
                visit(Self::Flat);
            }
            if bounds.iter().any(|[min, max]| min > max) {
                visit(Self::Inverted);
            }
            entries[index] = (hit, if hit { tmin } else { f64::INFINITY }, index);
        }
        of_order(entries, &mut visit)
    }
}

fn of_axis(is_backwards: bool, inverse: f64, visit: &mut impl FnMut(BoxRule)) {
    visit(if is_backwards { BoxRule::Backwards } else { BoxRule::Forwards });
    if inverse.is_infinite() {
        visit(if is_backwards { BoxRule::InverseMinusInfinite } else { BoxRule::InverseInfinite });
    } else if inverse == 0.0 {
        visit(BoxRule::InverseZero);
    } else if inverse.is_nan() {
        visit(BoxRule::InverseNan);
    }
}

fn of_extent(extent: f64, visit: &mut impl FnMut(BoxRule)) {
    if extent.is_nan() {
        visit(BoxRule::ExtentNan);
    } else if extent == 0.0 {
        visit(BoxRule::ExtentZero);
    } else if extent < 0.0 {
        visit(BoxRule::ExtentNegative);
    } else if extent.is_infinite() {
        visit(BoxRule::ExtentInfinite);
    }
}

/// Whether the box is hit by rules `paper`, and its tmin.
fn of_interval(nears: [f64; 3], fars: [f64; 3], extent: f64, visit: &mut impl FnMut(BoxRule)) -> (bool, f64) {
    // The host's maximum and minimum ignore NaN.
    let last_near = nears.into_iter().fold(f64::NAN, f64::max);
    let first_far = fars.into_iter().fold(f64::NAN, f64::min);
    let (tmin, tmax) = (last_near.max(0.0), first_far.min(extent));
    if last_near.is_nan() {
        visit(BoxRule::NearsAllNan);
    } else if last_near < 0.0 {
        visit(BoxRule::Inside);
    } else if last_near == 0.0 {
        visit(BoxRule::NearZero);
    }
    if tmax.is_nan() {
        visit(BoxRule::FarsAllNan);
    }
    if tmin > tmax {
        visit(BoxRule::Missed);
        if tmin <= first_far {
            visit(BoxRule::ExtentMisses);
        }
    } else if tmin < tmax {
        visit(BoxRule::Crossed);
        if extent < first_far {
            visit(BoxRule::ExtentEnds);
        }
    } else if tmin == tmax {
        visit(if tmin.is_infinite() { BoxRule::AtInfinity } else { BoxRule::Touched });
        if extent < first_far {
            visit(BoxRule::ExtentTouches);
        }
    }
    (tmin <= tmax, tmin)
}

fn of_order(mut entries: [(bool, f64, usize); 4], visit: &mut impl FnMut(BoxRule)) -> usize {
    entries.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let hits = entries.iter().filter(|entry| entry.0).count();
    let by_number = [BoxRule::NoHit, BoxRule::OneHit, BoxRule::TwoHits, BoxRule::ThreeHits, BoxRule::FourHits];
    visit(by_number[hits]);
    let same = (1..hits).filter(|&i| entries[i].1 == entries[i - 1].1).count();
    if same > 0 {
        visit(BoxRule::Tie);
    }
    if same == 3 {
        visit(BoxRule::TieOfFour);
    }
    if (1..4).contains(&hits) && entries[hits - 1].1 == f64::INFINITY {
        visit(BoxRule::InfiniteTie);
    }
    number_of(entries.map(|entry| entry.2))
}

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
