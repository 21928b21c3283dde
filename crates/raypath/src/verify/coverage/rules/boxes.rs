use super::{Rounded, fields, rules};
use crate::verify::layout::{Field, Layout};
use raypath_ops::JobKind;

rules! {
    /// What decides about boxes.
    BoxRule {
        Forwards = "1: runs forwards along an axis",
        Backwards = "1: runs backwards along an axis",
        InverseInfinite = "1: inv = +∞, a direction of +0",
        InverseMinusInfinite = "1: inv = −∞, a direction of −0",
        InverseZero = "1: inv = ±0, an infinite direction",
        InverseNan = "1: inv = NaN",
        NearNan = "2: a near distance 0·∞ drops out",
        FarNan = "2: a far distance 0·∞ drops out",
        OtherNan = "2: a distance is NaN for an operand was",
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

/// How many orders four boxes can have.
pub const PERMUTATIONS: usize = 24;

/// The order with this number, 0 to 23.
pub fn permutation(number: usize) -> [usize; 4] {
    let mut left = vec![0, 1, 2, 3];
    [number / 6, number / 2 % 3, number % 2, 0].map(|place| left.remove(place))
}

fn number_of([a, b, c, _]: [usize; 4]) -> usize {
    let place = |x: usize, before: &[usize]| x - before.iter().filter(|&&y| y < x).count();
    6 * a + 2 * place(b, &[a]) + place(c, &[a, b])
}

impl BoxRule {
    /// Tells each rule that a job exercises, perhaps more than once, and gives the number of the boxes' order.
    pub fn each(rounded: Rounded, layout: &Layout, words: &[u64], mut tell: impl FnMut(Self)) -> usize {
        let (mut origin, mut inverse, mut bounds) = ([0.0; 3], [0; 3], [[[0.0; 2]; 3]; 4]);
        let mut extent = 0.0;
        for (field, code) in fields(layout, JobKind::Quadbox, words) {
            match field {
                Field::Origin(axis) => origin[axis] = rounded.value(code),
                Field::Inverse(axis) => inverse[axis] = code,
                Field::Extent => extent = rounded.value(code),
                Field::Bound { place, axis, is_max } => {
                    bounds[place][axis][usize::from(is_max)] = rounded.value(code);
                }
                _ => {}
            }
        }
        let backwards = inverse.map(|code| rounded.0.is_sign_negative(code));
        let inverse = inverse.map(|code| rounded.value(code));
        (0..3).for_each(|axis| of_axis(backwards[axis], inverse[axis], &mut tell));
        of_extent(extent, &mut tell);
        let mut places = [(false, 0.0, 0); 4];
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
                    tell(Self::NearNan);
                }
                if far.1 {
                    tell(Self::FarNan);
                }
                if distances.iter().any(|(distance, is_zero_by_infinity)| distance.is_nan() && !is_zero_by_infinity) {
                    tell(Self::OtherNan);
                }
                (nears[axis], fars[axis]) = (near.0, far.0);
            }
            let (hit, tmin) = of_interval(nears, fars, extent, &mut tell);
            if hit && bounds.iter().any(|[min, max]| min == max) {
                tell(Self::Flat);
            }
            if bounds.iter().any(|[min, max]| min > max) {
                tell(Self::Inverted);
            }
            places[index] = (hit, if hit { tmin } else { f64::INFINITY }, index);
        }
        of_order(places, &mut tell)
    }
}

fn of_axis(is_backwards: bool, inverse: f64, tell: &mut impl FnMut(BoxRule)) {
    tell(if is_backwards { BoxRule::Backwards } else { BoxRule::Forwards });
    if inverse.is_infinite() {
        tell(if is_backwards { BoxRule::InverseMinusInfinite } else { BoxRule::InverseInfinite });
    } else if inverse == 0.0 {
        tell(BoxRule::InverseZero);
    } else if inverse.is_nan() {
        tell(BoxRule::InverseNan);
    }
}

fn of_extent(extent: f64, tell: &mut impl FnMut(BoxRule)) {
    if extent.is_nan() {
        tell(BoxRule::ExtentNan);
    } else if extent == 0.0 {
        tell(BoxRule::ExtentZero);
    } else if extent < 0.0 {
        tell(BoxRule::ExtentNegative);
    } else if extent.is_infinite() {
        tell(BoxRule::ExtentInfinite);
    }
}

/// Whether there is a hit by rules `paper`, and where.
fn of_interval(nears: [f64; 3], fars: [f64; 3], extent: f64, tell: &mut impl FnMut(BoxRule)) -> (bool, f64) {
    // The machine's maximum and minimum leave NaN out.
    let last_near = nears.into_iter().fold(f64::NAN, f64::max);
    let first_far = fars.into_iter().fold(f64::NAN, f64::min);
    let (tmin, tmax) = (last_near.max(0.0), first_far.min(extent));
    if last_near.is_nan() {
        tell(BoxRule::NearsAllNan);
    } else if last_near < 0.0 {
        tell(BoxRule::Inside);
    } else if last_near == 0.0 {
        tell(BoxRule::NearZero);
    }
    if tmax.is_nan() {
        tell(BoxRule::FarsAllNan);
    }
    if tmin > tmax {
        tell(BoxRule::Missed);
        if tmin <= first_far {
            tell(BoxRule::ExtentMisses);
        }
    } else if tmin < tmax {
        tell(BoxRule::Crossed);
        if extent < first_far {
            tell(BoxRule::ExtentEnds);
        }
    } else if tmin == tmax {
        tell(if tmin.is_infinite() { BoxRule::AtInfinity } else { BoxRule::Touched });
        if extent < first_far {
            tell(BoxRule::ExtentTouches);
        }
    }
    (tmin <= tmax, tmin)
}

fn of_order(mut places: [(bool, f64, usize); 4], tell: &mut impl FnMut(BoxRule)) -> usize {
    places.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let hits = places.iter().filter(|place| place.0).count();
    let by_number = [BoxRule::NoHit, BoxRule::OneHit, BoxRule::TwoHits, BoxRule::ThreeHits, BoxRule::FourHits];
    tell(by_number[hits]);
    let same = (1..hits).filter(|&i| places[i].1 == places[i - 1].1).count();
    if same > 0 {
        tell(BoxRule::Tie);
    }
    if same == 3 {
        tell(BoxRule::TieOfFour);
    }
    if (1..4).contains(&hits) && places[hits - 1].1 == f64::INFINITY {
        tell(BoxRule::InfiniteTie);
    }
    number_of(places.map(|place| place.2))
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
